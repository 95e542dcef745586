"""The contract of a stand."""

from __future__ import annotations

import numpy as np

from acalx.stands import Setting, Stand
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
    """Check a stand: limits, random and wrapped settings, stimulus, derivative, aim.

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
    for stack in STACKS:
        shape = (*stack, N)
        angles, again = (stand.axes.random(np.random.default_rng(seed), shape) for _ in range(2))
        require_shape(stand, "random", angles, (*shape, len(settings)))
        require_close(stand, "random settings follow from the seed", angles, again, 0.0)
        require(bool(stand.axes.allows(angles).all()), stand, "random settings are ones that the stand allows")
        stimulus = stand.stimulus(angles)
        require(any(True for _ in stimulus.quantities()), stand, "stimulus gives one quantity or more")
        for name, value in stimulus.quantities():
            require_shape(stand, f"stimulus.{name}", value, (*shape, 3))
        require_stacked(stand, "stimulus", lambda x: arrays(stand.stimulus(x)), angles)
        turned = angles + 2.0 * np.pi * np.array([s.periodic for s in settings])
        for same in (turned, stand.axes.wrap(turned), stand.axes.wrap(angles)):
            for (name, value), (_, other) in zip(stimulus.quantities(), stand.stimulus(same).quantities(), strict=True):
                require_close(stand, f"a periodic setting a turn on gives the same {name}", other, value, 1e-9)
        exact, numerical = stand.derivative(angles), Stand.derivative(stand, angles)
        require_derivative(stand, exact, numerical, (*shape, 3, len(settings)))
        if stimulus.specific_force is not None and type(stand).aim is not Stand.aim:
            force = arrays(stand.stimulus(stand.aim(stimulus.specific_force)))[0]
            require_close(stand, "aim brings the vertical where it is told", force, stimulus.specific_force, 1e-7)
