"""The programs simulated: calibrations as they would be done, beside what theory says of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from programs import GROUPS, KNOWN, STAND, written

from acalx.numerics.arrays import Array
from acalx.programs import Program
from acalx.quantities.parameter import parameter_groups
from acalx.simulation import ErrorSources, Outcome, simulate

__all__ = ["SETTING_RAD", "TRIALS", "outcomes", "simulated"]

TRIALS = 2000
SETTING_RAD = 1e-4


def outcomes(programs: Sequence[Program], setting_rad: float = 0.0) -> dict[str, Outcome]:
    """Each program with units as their make has them, read with the noise of the model.

    With `setting_rad`, attitudes are off by so much about each axis, and no one knows.
    """
    errors = ErrorSources(parameters={}, noise=1.0, setting_rad=setting_rad, gravity=0.0)
    return dict(simulate(programs, STAND, KNOWN, errors, trials=TRIALS).outcomes)


def simulated(programs: Sequence[Program]) -> tuple[list[list[str]], list[list[str]], dict[str, str]]:
    """Tables of what came out with noise alone and with wrong attitudes, and figures for the page."""
    alone, wrong = outcomes(programs), outcomes(programs, SETTING_RAD)
    rows = [["program", "achieved / predicted", "probability", "in the 95 % intervals, accel.", "gyros"]]
    for name, one in alone.items():
        ratio = one.deviations / one.predicted
        cells = [f"{ratio.min():.3f} to {ratio.max():.3f}", f"{min(one.scatter_probability, one.bias_probability):.2f}"]
        rows.append([name, *cells, *(f"{100 * share:.1f} %" for share in _covered(one))])
    groups = parameter_groups(KNOWN.parameters)
    chosen = ("accel_bias", "accel_scale", "accel_misalignment", "gyro_bias", "gyro_scale", "gyro_misalignment")
    off = [["program", *(group.replace("_", " ") for group in chosen)]]
    for name, one in wrong.items():
        ratio = one.deviations / one.predicted
        off.append([name, *(f"{np.sqrt(np.mean(ratio[groups[group]] ** 2)):.2f}" for group in chosen)])
    agreeing = sum(one.agrees for one in alone.values())
    largest = max(float(np.abs(one.deviations / one.predicted - 1.0).max()) for one in alone.values())
    lost = max(float(_ratio(one).max()) for one in wrong.values())
    figures = {
        "agreeing": _share(agreeing, len(alone)),
        "largest_apart": f"{100 * largest:.0f}",
        "trials": f"{TRIALS:,}",
        "setting_rad": f"{SETTING_RAD:g}",
        "wrong_agreeing": _share(sum(not one.agrees for one in wrong.values()), len(wrong)),
        "lost": f"{lost:.1f}",
        **_with_24(alone, "alone", theory=True),
        **_with_24(wrong, "off"),
    }
    return rows, off, figures


def _share(some: int, count: int) -> str:
    return f"all {count}" if some == count else f"{some} of the {count}"


def _with_24(outcome: dict[str, Outcome], name: str, *, theory: bool = False) -> dict[str, str]:
    """Largest standard errors of the gyros' scales in ppm and biases in deg/h, both with 24 positions."""
    found = {}
    for short, program, visits in (("six", "six_faces_and_turns_12", 2), ("joint", "joint_24", 1)):
        one = outcome[program]
        sizes = (one.predicted if theory else one.deviations) / np.sqrt(visits)
        for group in ("gyro_scale", "gyro_bias"):
            largest = GROUPS[group].factor * sizes[parameter_groups(KNOWN.parameters)[group]].max()
            found[f"{name}_{short}_{group}"] = written(float(largest))
    return found


def _ratio(outcome: Outcome) -> Array:
    return np.asarray(outcome.deviations / outcome.predicted)


def _covered(outcome: Outcome) -> tuple[float, float]:
    """Share of the trials in which intervals held the parameter, of accelerometers and of gyros."""
    accel = np.array([one.name.startswith("accel") for one in KNOWN.parameters])
    return float(outcome.coverage[accel].mean()), float(outcome.coverage[~accel].mean())
