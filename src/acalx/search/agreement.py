"""When the ends of many descents agree, and which of them are the same program."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from acalx.numerics.arrays import Array
from acalx.problem import Problem, comparable
from acalx.search.result import Solution

__all__ = ["Verdict", "distinct_solutions", "fewest_starts", "judge"]

_TIMES = 3


@dataclass(frozen=True)
class Verdict:
    """How far the ends of descents agree.

    Parameters
    ----------
    starts : int
        Number of descents.
    minima : int
        Number of different minima among their ends.
    best : int
        Number of descents that ended in the best of them.
    """

    starts: int
    minima: int
    best: int

    @property
    def settled(self) -> bool:
        """Whether more starts would hardly find a better minimum.

        The best was found at least three times, and from w different minima among N ends the
        expected number of minima, w (N - 1) / (N - w - 2), is below w + 1/2. Source: Boender
        and Rinnooy Kan, Math. Program. 37 (1987) 59.
        """
        rest = self.starts - self.minima - 2
        if self.best < _TIMES or rest <= 0:
            return False
        return self.minima * (self.starts - 1) / rest < self.minima + 0.5

    def __str__(self) -> str:
        if self.minima == 1:
            return f"all {self.starts} starts led to the same minimum"
        return f"{self.starts} starts led to {self.minima} different minima, {self.best} of them to the best"


def fewest_starts(problem: Problem) -> int:
    """So many descents are made before any verdict counts.

    Where the stand's limits or kinks of the criterion cut the landscape up, a few descents can
    agree on a poor minimum that most of the landscape leads to.
    """
    if not all(setting.full_turn for setting in problem.stand.settings):
        return 64
    return 24 if problem.objective.criterion.terms().ceilings else 8


def judge(losses: Array, agreement: float) -> Verdict:
    """Count the minima among final losses; those closer than `agreement` are the same."""
    finite = np.sort(losses[np.isfinite(losses)])
    minima = int((np.diff(finite) > agreement).sum()) + int(len(finite) > 0) + int(len(finite) < len(losses))
    best = int((finite <= finite[0] + agreement).sum()) if len(finite) else 0
    return Verdict(len(losses), minima, best)


def distinct_solutions(
    problem: Problem, settings: Iterable[Array], losses: Iterable[float], tolerance: float, *, sort: bool = True
) -> tuple[Solution, ...]:
    """The best program and all others within a tolerance of its loss, each set of positions once.

    Positions are sorted by their angles, unless their order has a meaning.
    """
    ranked = sorted(zip(losses, settings, strict=True), key=lambda pair: pair[0])
    good = [(loss, program) for loss, program in ranked if loss <= ranked[0][0] + tolerance]
    ends = np.cumsum([len(program) for _, program in good])
    rows = problem.response.regressors(np.concatenate([program for _, program in good]))
    together = np.split(comparable(rows), ends[:-1])
    kept: list[Solution] = []
    felt: list[Array] = []
    for (loss, program), rows in zip(good, together, strict=True):
        if any(_same_positions(rows, other) for other in felt):
            continue
        kept.append(Solution(problem.restrictions.canonical(program) if sort else program, float(loss)))
        felt.append(rows)
    return tuple(kept)


def _same_positions(rows: Array, others: Array, tolerance: float = 1e-3) -> bool:
    """Whether each position of one program occurs in the other, as the sensor feels them."""
    if not _near(rows[:1], others, tolerance).any():  # most programs differ already here
        return False
    near = _near(rows, others, tolerance)
    return bool(near.any(axis=0).all() and near.any(axis=1).all())


def _near(rows: Array, others: Array, tolerance: float) -> np.ndarray:
    """Which rows (a, q) are within a tolerance of which others (b, q), (a, b)."""
    squares = (rows**2).sum(axis=1)[:, None] + (others**2).sum(axis=1) - 2.0 * rows @ others.T
    return np.asarray(squares < tolerance**2)
