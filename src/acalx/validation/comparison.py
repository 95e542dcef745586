"""Programs compared on a real sensor: calibrate on the measured positions nearest to each, test on the rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, final

import numpy as np

from acalx.criteria import Criterion
from acalx.estimation.base import Estimator
from acalx.estimation.calibration import Calibration
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus
from acalx.validation.splits import validate_splits
from acalx.validation.subsets import best_positions, efficiency, nearest_positions, random_positions, random_turns

__all__ = ["COMPARED", "Compared", "compare_programs", "directions_of", "felt_in", "median_of"]

Kind = Literal["program", "best", "random"]
COMPARED = ("angle_deg", "efficiency", "r_squared", "rms")
_LEAST_TESTED = 2


@final
@dataclass(frozen=True, eq=False)
class Compared:
    """One way to choose n of the measured positions, and how right the calibration from them is on the others.

    Parameters
    ----------
    name : str
    n : int
    angle_deg : float, degrees
        Mean angle between the positions of the program and the measured ones that stand for them;
        nan where there is no program.
    efficiency : float
        D-efficiency of the measured positions that were taken, relative to even ones.
    r_squared, rms : float
        On the positions that were not taken; -inf and inf where these can't show all the parameters.
    kind : str
        ``program``, ``best`` (by the criterion) or ``random`` (the median of such choices).
    """

    name: str
    n: int
    angle_deg: float
    efficiency: float
    r_squared: float
    rms: float
    kind: Kind = field(default="program", kw_only=True)


def compare_programs(
    calibration: Calibration,
    programs: Mapping[str, Array],
    criterion: Criterion,
    estimator: Estimator,
    rng: np.random.Generator,
    subsets: Sequence[int] = (),
    random: int = 200,
    turns: int = 1,
) -> list[Compared]:
    """Compare programs on the positions that a sensor was measured in.

    A program with so many positions that fewer than two are left to test is left out. For
    each number of positions there are two rows more: the measured positions that the
    criterion likes best, and the median of random ones.

    Parameters
    ----------
    calibration : Calibration
        From all the positions; it says where the vertical was.
    programs : mapping
        From a name to the vertical in sensor axes, arrays (n, 3).
    criterion : Criterion
    estimator : Estimator
    rng : numpy Generator
    subsets : sequence of int
        Further numbers of positions.
    random : int
        How many random choices.
    turns : int
        So many turns of each program as a whole are tried to find measured positions near it.
    """
    total, least = calibration.readings.n, calibration.model.smallest_n
    model, directions, felt = calibration.model, directions_of(calibration), felt_in(calibration)
    if felt is None:
        return []
    near = {} if directions is None else programs
    fitting = {name: p for name, p in near.items() if least <= len(p) <= total - _LEAST_TESTED}
    rows = []
    numbers = sorted({len(p) for p in fitting.values()} | {n for n in subsets if least <= n <= total - _LEAST_TESTED})
    for n in numbers:
        for name, program in fitting.items():
            if len(program) == n and directions is not None:
                chosen, angles = nearest_positions(directions, program, random_turns(turns, rng))
                rows.append(_on_the_rest(name, chosen, float(np.degrees(angles.mean())), calibration, estimator))
        best = best_positions(felt, n, model, criterion, rng)
        rows.append(replace(_on_the_rest(f"best {n} measured", best, np.nan, calibration, estimator), kind="best"))
        others = random_positions(total, n, random, rng)
        row = _on_the_rest(f"random {n}, median", others, np.nan, calibration, estimator)
        rows.append(replace(row, kind="random"))
    return rows


def median_of(rows: Sequence[Compared]) -> Compared:
    """Medians of the figures of the same choice on several sensors."""
    medians = (float(np.median([getattr(row, key) for row in rows])) for key in COMPARED)
    return Compared(rows[0].name, rows[0].n, *medians, kind=rows[0].kind)


def felt_in(calibration: Calibration) -> Stimulus | None:
    """What the calibrated sensor felt in the measured positions; None where that is not known."""
    readings, model = calibration.readings, calibration.model
    per = calibration.unit.per_channel(model.channels)
    return model.felt(
        calibration.estimate.parameters, (readings.means - calibration.unit.offset) / per, readings.stimulus
    )


def directions_of(calibration: Calibration) -> Array | None:
    """Unit vectors (n, 3) of the one vector that the model reads, in sensor axes; None where it reads more."""
    felt, names = felt_in(calibration), tuple(calibration.model.needs)
    if felt is None or len(names) != 1 or felt.weights is not None or felt[names[0]].shape[-1] != 3:
        return None
    vectors = felt[names[0]]
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / lengths) if (lengths > 0).all() else None


def _on_the_rest(
    name: str, train: np.ndarray, angle: float, calibration: Calibration, estimator: Estimator
) -> Compared:
    """Calibrated on chosen positions (n,), or the median of several choices (s, n), and tested on the others."""
    readings, model = calibration.readings, calibration.model
    train = np.atleast_2d(train)
    everything = np.arange(readings.n)
    test = np.array([np.setdiff1d(everything, chosen) for chosen in train])
    tested = validate_splits(readings, train, test, model, estimator, calibration.unit)
    directions = directions_of(calibration)
    share = np.full(len(train), np.nan) if directions is None else efficiency(directions[train], model)
    figures = (float(np.median(values)) for values in (share, tested.r_squared, tested.rms))
    return Compared(name, train.shape[1], angle, *figures)
