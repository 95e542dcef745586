"""What searches answer: programs for one criterion, or the front of several objectives."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Literal, Self, final

import numpy as np

from acalx.numerics.arrays import Array
from acalx.search.pareto import FrontPoint

__all__ = ["ApproximateDesign", "Found", "Front", "Result", "Solution", "Status", "Survey"]

Status = Literal["ok", "limit", "interrupted"]
# Losses of a survey that differ by less are the same.
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class Solution:
    """A program and its loss.

    Parameters
    ----------
    settings : array (n, d), in rad
    loss : float
    """

    settings: Array
    loss: float


@dataclass(frozen=True, eq=False)
class Survey:
    """Every program that a systematic search looked at: s sequences, each with several numbers of positions.

    Parameters
    ----------
    names : tuple of str
        What makes a sequence, names with their units.
    sequences : array (s, len(names))
    numbers : array (k,)
        Numbers of positions, ascending.
    losses : array (s, k)
        Of the information per measurement; inf where singular or not allowed.
    """

    names: tuple[str, ...]
    sequences: Array
    numbers: np.ndarray
    losses: Array

    @property
    def best(self) -> tuple[int, int]:
        """Row and column of the best program; the shortest of those that are as good."""
        near = self.losses <= self.losses.min() + _SAME
        column = int(near.any(axis=0).argmax())
        return int(near[:, column].argmax()), column


@dataclass(frozen=True, eq=False)
class ApproximateDesign:
    """An approximate design: positions and the share of the measurements, or of the time, that each gets.

    Parameters
    ----------
    settings : array (k, d), in rad
    weights : array (k,)
        Positive, their sum is 1.
    points : array (k,) of int
        Number of the support point, from 0. On a grid neighbors share the weight of an optimum
        that lies between them, and have the same number.
    loss : float
        Of one measurement, on average; for n measurements it is lower by degree times log n.
    gap : float
        The efficiency among all designs on the candidates is at least 1 / (1 + gap).
    candidates : int
        From how many positions it was chosen.
    method : str
        How it was found.
    """

    settings: Array
    weights: Array
    points: np.ndarray
    loss: float
    gap: float
    candidates: int
    method: str

    @property
    def count(self) -> int:
        """Number of support points."""
        return int(self.points.max()) + 1

    def merged(self) -> tuple[Array, Array]:
        """One position for each support point, the heaviest, with the weight of all: (c, d) and (c,)."""
        totals = np.bincount(self.points, self.weights).astype(float)
        order = np.argsort(-self.weights, kind="stable")
        _, first = np.unique(self.points[order], return_index=True)
        return self.settings[order[first]], totals


@dataclass(frozen=True)
class Found(ABC):
    """What any search ends with.

    Parameters
    ----------
    status : str
        ``ok``; ``limit`` where a limit ended the search before it could be trusted;
        ``interrupted`` where the user did.
    message : str
        Why the search ended.
    evaluations : int
        Number of programs evaluated.
    seconds : float
    history : list of (evaluations, seconds, loss)
        Each time the best loss fell.
    """

    status: Status
    message: str
    evaluations: int
    seconds: float
    history: list[tuple[int, float, float]]

    @property
    @abstractmethod
    def program(self) -> Array:
        """The program to take, (n, d) in rad."""

    @abstractmethod
    def with_program(self, settings: Array) -> Self:
        """The same with this in its place: the same positions in another order, or rotated at no cost."""

    def ended(self, status: Status, message: str) -> Self:
        """The same with another end."""
        return replace(self, status=status, message=message)


@final
@dataclass(frozen=True, eq=False)
class Result(Found):
    """The best programs by one criterion.

    Parameters
    ----------
    status, message, evaluations, seconds, history
        As of `Found`.
    solutions : tuple of Solution
        The best program first, then all distinct ones that are equally good to the
        optimizer's tolerance. They have the problem's number of positions, or fewer where the
        optimizer chooses it.
    gain : float or None
        By how much the final polish lowered the loss; None where there was none.
    survey : Survey or None
        All that was looked at, from a search that goes through everything.
    design : ApproximateDesign or None
        The approximate design that was rounded, where there was one.
    """

    solutions: tuple[Solution, ...]
    gain: float | None = None
    survey: Survey | None = None
    design: ApproximateDesign | None = None

    @property
    def best(self) -> Solution:
        """The solution of least loss, the first of them."""
        return self.solutions[0]

    @property
    def program(self) -> Array:
        """That of the best solution."""
        return self.best.settings

    def with_program(self, settings: Array) -> Self:
        """The best solution with these settings."""
        return replace(self, solutions=(replace(self.best, settings=settings), *self.solutions[1:]))


@final
@dataclass(frozen=True, eq=False)
class Front(Found):
    """The best compromises between several objectives: programs none of which is better than another in every one.

    Parameters
    ----------
    status, message, evaluations, seconds, history
        As of `Found`.
    points : tuple of FrontPoint
        By ascending first loss.
    knee : int
        Which of them to take where nothing else says (see `acalx.search.pareto.knee`).
    settings : array (n, d), in rad, optional
        Of the knee, where its positions come in another order than the point has them.
    """

    points: tuple[FrontPoint, ...]
    knee: int
    settings: Array | None = None

    @property
    def losses(self) -> Array:
        """Of all the points, (m, k)."""
        return np.array([point.losses for point in self.points])

    @property
    def program(self) -> Array:
        """That of the knee."""
        return self.points[self.knee].settings if self.settings is None else self.settings

    def with_program(self, settings: Array) -> Self:
        """The knee with these settings."""
        return replace(self, settings=settings)
