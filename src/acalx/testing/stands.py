"""The contract of a stand."""

from __future__ import annotations

import numpy as np

from acalx.errors import CompatibilityError
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import VECTORS, Stimulus
from acalx.stands import Setting, Stand
from acalx.stands.degrees import wrong_degree
from acalx.testing.rules import (
    STACKS,
    N,
    arrays,
    require,
    require_close,
    require_derivative,
    require_shape,
    require_stacked,
)

__all__ = ["check_stand"]


def check_stand(stand: Stand, *, seed: int = 0) -> None:
    """Check a stand: limits, random and wrapped settings, stimulus, derivative, aim, equivalents, axes off, speeds.

    Parameters
    ----------
    stand : Stand
    seed : int
        Of the random settings.
    """
    settings = stand.settings
    require(len(settings) > 0 and all(isinstance(s, Setting) for s in settings), stand, "settings are one or more")
    require(
        len(set(stand.axes.names)) == len(settings), stand, f"each setting has its own name, got {stand.axes.names}"
    )
    require(not wrong_degree(stand), stand, "frequencies are the degrees of the stimulus in each setting, or None")
    for stack in STACKS:
        shape = (*stack, N)
        angles, again = (stand.axes.random(np.random.default_rng(seed), shape) for _ in range(2))
        require_shape(stand, "random", angles, (*shape, len(settings)))
        require_close(stand, "random settings follow from the seed", angles, again, 0.0)
        require(bool(stand.axes.allows(angles).all()), stand, "random settings are ones that the stand allows")
        stimulus = stand.stimulus(angles)
        require(any(True for _ in stimulus.items()), stand, "stimulus gives one quantity or more")
        samples = () if stimulus.weights is None else stimulus.weights.shape
        widths = {name: 3 if name in VECTORS else np.shape(value)[-1] for name, value in stimulus.items()}
        for name, value in stimulus.items():
            require_shape(stand, f"stimulus.{name}", value, (*shape, *samples, widths[name]))
            require(bool(stimulus.units[name]), stand, f"stimulus says the unit of {name}")
        require_stacked(stand, "stimulus", lambda x: arrays(stand.stimulus(x)), angles)
        turned = angles + 2.0 * np.pi * np.array([s.periodic for s in settings])
        for same in (turned, stand.axes.wrap(turned), stand.axes.wrap(angles)):
            for (name, value), (_, other) in zip(stimulus.items(), stand.stimulus(same).items(), strict=True):
                require_close(stand, f"a periodic setting a turn on gives the same {name}", other, value, 1e-9)
        exact, numerical = stand.derivative(angles), Stand.derivative(stand, angles)
        for name, width in widths.items():
            alone, wanted = (Stimulus({name: each[name]}) for each in (exact, numerical))
            require_derivative(stand, alone, wanted, (*shape, *samples, width, len(settings)))
        if "specific_force" in stimulus and stimulus.weights is None:
            _check_aim(stand, stimulus["specific_force"])
        for program in angles.reshape(-1, N, len(settings))[:1]:
            _check_equivalents(stand, program)
            _check_misaligned(stand, program)
    speeds = stand.speeds
    require(np.shape(speeds) == (len(settings),), stand, f"there is a speed for each setting, got {speeds}")
    require(bool((speeds > 0).all()), stand, "speeds are positive")


def _check_aim(stand: Stand, directions: Array) -> None:
    """Settings for directions (..., n, 3), where the stand can be aimed; what is no angle is as near to 0 as can be."""
    try:
        aimed = stand.aim(directions)
    except CompatibilityError:
        return
    require_shape(stand, "aim", aimed, (*directions.shape[:-1], len(stand.settings)))
    force = dict(stand.stimulus(aimed).items())["specific_force"]
    require_close(stand, "aim brings the vertical where it is told", force, directions, 1e-7)
    for k, setting in enumerate(stand.settings):
        if not setting.angle:
            rule = f"aim leaves {setting.name} at rest, which is {setting.rest:g} here"
            require(bool((aimed[..., k] == setting.rest).all()), stand, rule)


def _check_equivalents(stand: Stand, program: Array) -> None:
    """Other settings for those of a program (n, d)."""
    ways = stand.equivalents(program)
    require_shape(stand, "equivalents", ways, (len(ways), *program.shape))
    require(np.array_equal(ways[0], program), stand, "the given settings come first among the equivalent ones")
    require(bool(stand.axes.allows(ways).all()), stand, "equivalent settings are ones that the stand allows")
    wanted = dict(stand.stimulus(program).items())
    for name, felt in stand.stimulus(ways).items():
        expected = np.broadcast_to(wanted[name], felt.shape)
        require_close(stand, f"equivalent settings give the same {name}", felt, expected, 1e-9)


def _check_misaligned(stand: Stand, program: Array) -> None:
    """What is felt for a program (n, d) where the axes are off, by nothing and by each of the errors alone."""
    wanted, count = dict(stand.stimulus(program).items()), len(stand.axis_errors)
    felt = dict(stand.misaligned(program, np.zeros((2, 1, count))).items())
    for name, value in wanted.items():
        value = np.broadcast_to(value, (2, *value.shape))
        got = np.broadcast_to(felt[name], value.shape)
        require_close(stand, f"axes off by nothing change nothing of {name}", got, value, 1e-9)
    if count:
        off = dict(stand.misaligned(program, np.full((2, 1, count), 0.1)).items())
        changed = [np.abs(off[name] - value).max() for name, value in wanted.items()]
        require(max(changed) > 1e-6, stand, "axes that are off change what is felt")
