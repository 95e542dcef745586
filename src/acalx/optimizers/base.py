"""The interface of an optimizer, the account that it keeps, and the result that it gives."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal, final

import numpy as np

from acalx.arrays import Array
from acalx.errors import AcalxError, CompatibilityError
from acalx.problem import Problem

__all__ = ["Account", "Design", "Optimizer", "Result", "Solution", "Status", "Watch"]

Status = Literal["ok", "limit", "interrupted"]
Watch = Callable[["Account"], None]


@dataclass(frozen=True)
class Solution:
    """A program and its loss.

    Parameters
    ----------
    settings : array (n, d), in rad
    loss : float
    """

    settings: Array
    loss: float


@dataclass(frozen=True)
class Design:
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
class Result:
    """What an optimizer found.

    Parameters
    ----------
    status : str
        ``ok``; ``limit`` where a limit ended the search before it could be trusted;
        ``interrupted`` where the user did.
    message : str
        Why the search ended.
    solutions : tuple of Solution
        The best program first, then all distinct ones that are equally good to the
        optimizer's tolerance.
    evaluations : int
        Number of programs evaluated.
    seconds : float
    history : list of (evaluations, seconds, loss)
        Each time the best loss fell.
    gain : float or None
        By how much the final polish lowered the loss; None where there was none.
    design : Design or None
        The approximate design that was rounded, where there was one.
    """

    status: Status
    message: str
    solutions: tuple[Solution, ...]
    evaluations: int
    seconds: float
    history: list[tuple[int, float, float]]
    gain: float | None = None
    design: Design | None = None

    @property
    def best(self) -> Solution:
        """The best program."""
        return self.solutions[0]


@dataclass
class Account:
    """Running account of a search: the best program so far, evaluations, time, progress.

    Parameters
    ----------
    watch : callable, optional
        Called with the account after each step of the search, e.g. to show progress.
    """

    watch: Watch | None = None
    best: Solution | None = None
    evaluations: int = 0
    fraction: float = 0.0
    history: list[tuple[int, float, float]] = field(default_factory=list)
    started: float = field(default_factory=time.perf_counter)

    @property
    def seconds(self) -> float:
        """Time since the search began."""
        return time.perf_counter() - self.started

    def see(self, settings: Array, losses: Array) -> None:
        """Count programs (s, n, d) that were evaluated and keep the best of them."""
        self.evaluations += len(losses)
        self.keep(settings, losses)

    def keep(self, settings: Array, losses: Array) -> None:
        """Keep the best of programs (s, n, d) that are counted already."""
        k = int(losses.argmin())
        if np.isfinite(losses[k]) and (self.best is None or losses[k] < self.best.loss):
            self.best = Solution(settings[k].copy(), float(losses[k]))
            self.history.append((self.evaluations, self.seconds, self.best.loss))
        if self.watch is not None:
            self.watch(self)


class Optimizer(ABC):
    """What searches for the best program of a problem.

    A new optimizer gives `search`; `solve` refuses what does not fit, keeps the account and
    turns an interrupt into a result. Concrete optimizers are frozen dataclasses of options.
    """

    def check(self, problem: Problem) -> None:  # noqa: B027 - most take every problem
        """Raise CompatibilityError for a problem that the optimizer can't handle."""

    @abstractmethod
    def search(self, problem: Problem, rng: np.random.Generator, account: Account) -> Result:
        """Search for the best program; `account` is told of every evaluation."""

    @final
    def solve(self, problem: Problem, rng: np.random.Generator, watch: Watch | None = None) -> Result:
        """Best program of a problem, the same for the same state of the random generator.

        Parameters
        ----------
        problem : Problem
        rng : numpy Generator
        watch : callable, optional
            Called with the running `Account` after each step.

        Raises
        ------
        CompatibilityError
            The parts do not fit together; before any work.
        AcalxError
            No program of the problem can estimate all parameters.
        """
        self.check(problem)
        account = Account(watch)
        try:
            result = self.search(problem, rng, account)
        except KeyboardInterrupt:
            if account.best is None:
                raise
            return Result(
                "interrupted",
                f"interrupted after {account.seconds:.1f} s; this is the best program so far",
                (Solution(problem.canonical(account.best.settings), account.best.loss),),
                account.evaluations,
                account.seconds,
                account.history,
            )
        if not np.isfinite(result.best.loss):
            raise AcalxError(no_regular_program(problem))
        return result


def no_regular_program(problem: Problem) -> str:
    """Message for a problem in which every program that was tried is singular."""
    limits = ", ".join(
        f"{s.name}_deg=[{np.degrees(s.lower):g},{np.degrees(s.upper):g}]" for s in problem.stand.settings
    )
    everything = problem.random(np.random.default_rng(0), 1)
    many = Problem(problem.stand, problem.model, problem.criterion, max(problem.n, 500))
    unseen = many.information(many.random(np.random.default_rng(0), 1)[0]).inestimable()
    if not unseen:
        unseen = problem.information(everything[0]).inestimable()
    can_not = f"; no position there shows {'; '.join(unseen)}" if unseen else ""
    return f"no program of {problem.n} positions within {limits} can estimate all the parameters{can_not}"


def refuse_steps(optimizer: Optimizer, problem: Problem, instead: str) -> None:
    """Raise CompatibilityError where the stand stops at steps only."""
    if problem.stand.stepped:
        raise CompatibilityError(
            f"optimizer {type(optimizer).__name__} moves angles continuously, but stand "
            f"{type(problem.stand).__name__} stops at steps only; use {instead}, or leave the step out"
        )
