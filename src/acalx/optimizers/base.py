"""The interface of an optimizer, the account that it keeps, and the result that it gives."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import ClassVar, Literal, final

import numpy as np

from acalx.arrays import Array
from acalx.errors import CompatibilityError, NoProgramError
from acalx.optimizers.pareto import FrontPoint, front_points, knee
from acalx.problem import Problem

__all__ = ["Account", "Optimizer", "Result", "Solution", "Status", "Survey", "Watch"]

Status = Literal["ok", "limit", "interrupted"]
# Losses of a survey that differ by less are the same.
_SAME = 1e-9
Watch = Callable[["Account"], None]


@dataclass(frozen=True)
class Solution:
    """A program and its loss.

    Parameters
    ----------
    settings : array (n, d), in rad
    loss : float
        nan where there are several objectives.
    """

    settings: Array
    loss: float


@dataclass(frozen=True)
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
        optimizer's tolerance. They have the problem's number of positions, or fewer where the
        optimizer chooses it.
    evaluations : int
        Number of programs evaluated.
    seconds : float
    history : list of (evaluations, seconds, loss)
        Each time the best loss fell.
    gain : float or None
        By how much the final polish lowered the loss; None where there was none.
    survey : Survey or None
        All that was looked at, from a search that goes through everything.
    front : tuple of FrontPoint
        Where there are several objectives: programs none of which is better than another in
        every one, by ascending first loss. Empty for one criterion.
    knee : int or None
        Which point of the front is the solution (see `acalx.optimizers.pareto.knee`).
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
    survey: Survey | None = None
    front: tuple[FrontPoint, ...] = ()
    knee: int | None = None

    @classmethod
    def of_front(cls, status: Status, message: str, problem: Problem, account: Account) -> Result:
        """The front that an account holds, with its knee as the solution."""
        assert account.front is not None
        programs, losses = account.front
        points = front_points(np.stack([problem.canonical(program) for program in programs]), losses)
        best = knee(losses)
        return cls(
            status,
            message,
            (Solution(points[best].settings, float("nan")),),
            account.evaluations,
            account.seconds,
            account.history,
            front=points,
            knee=best,
        )

    design: Design | None = None

    @property
    def best(self) -> Solution:
        """The best program; of several objectives the knee of the front."""
        return self.solutions[0]


@dataclass
class Account:
    """Running account of a search: the best program so far, evaluations, time, progress.

    Parameters
    ----------
    watch : callable, optional
        Called with the account after each step of the search, e.g. to show progress.
    front : (array (m, n, d), array (m, k)), optional
        Programs and losses of the front so far, where there are several objectives.
    """

    watch: Watch | None = None
    best: Solution | None = None
    evaluations: int = 0
    fraction: float = 0.0
    front: tuple[Array, Array] | None = None
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
        if not len(losses):
            return
        k = int(losses.argmin())
        if np.isfinite(losses[k]) and (self.best is None or losses[k] < self.best.loss):
            self.best = Solution(settings[k].copy(), float(losses[k]))
            self.history.append((self.evaluations, self.seconds, self.best.loss))
        self.tick()

    def hold(self, settings: Array, losses: Array) -> None:
        """Keep a front, programs (m, n, d) and losses (m, k), in the place of the one before."""
        if len(losses):
            self.front = settings, losses
        self.tick()

    def tick(self) -> None:
        """Let the watch know."""
        if self.watch is not None:
            self.watch(self)

    @property
    def found(self) -> bool:
        """Whether there is a program yet."""
        return self.best is not None or self.front is not None


class Optimizer(ABC):
    """What searches for the best program of a problem.

    A new optimizer gives `search`; `solve` refuses what does not fit, keeps the account and
    turns an interrupt into a result. Concrete optimizers are frozen dataclasses of options.

    Attributes
    ----------
    several : bool
        Whether it takes several objectives, and gives their front, rather than one criterion.
    """

    several: ClassVar[bool] = False

    def check(self, problem: Problem) -> None:  # noqa: B027 - most take every problem
        """Raise CompatibilityError for a problem that the optimizer can't handle."""

    def exact(self) -> Optimizer:
        """The same search with exactly the problem's number of positions, where it may take fewer."""
        return self

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
        NoProgramError
            No program of the problem can estimate all parameters.
        """
        _check_objectives(self, problem)
        self.check(problem)
        account = Account(watch)
        try:
            result = self.search(problem, rng, account)
        except KeyboardInterrupt:
            said = f"interrupted after {account.seconds:.1f} s; this is the best"
            if account.front is not None:
                return Result.of_front("interrupted", f"{said} front so far", problem, account)
            if account.best is None:
                raise
            return Result(
                "interrupted",
                f"{said} program so far",
                (Solution(problem.canonical(account.best.settings), account.best.loss),),
                account.evaluations,
                account.seconds,
                account.history,
            )
        if not (result.front or np.isfinite(result.best.loss)):
            raise NoProgramError(no_regular_program(problem))
        return result


def _check_objectives(optimizer: Optimizer, problem: Problem) -> None:
    """Raise CompatibilityError where several objectives meet an optimizer of one, or one of several."""
    name, objectives = type(optimizer).__name__, problem.criterion.objective_names
    if optimizer.several and len(objectives) == 1:
        raise CompatibilityError(
            f"optimizer {name} takes several objectives, got {objectives[0]} alone; "
            "give two or more, as in objectives=[d,a], or use optimizer=gradient"
        )
    if not optimizer.several and len(objectives) > 1:
        raise CompatibilityError(
            f"optimizer {name} takes one criterion, got the objectives {', '.join(objectives)}; "
            "for several use optimizer=scalarized or optimizer=nsga2, or multiply them to a product"
        )


def no_regular_program(problem: Problem) -> str:
    """Message for a problem in which every program that was tried is singular."""
    limits = ", ".join(setting.limits.replace(", ", ",") for setting in problem.stand.settings)
    everything = problem.random(np.random.default_rng(0), 1)
    many = replace(problem, n=max(problem.n, 500), replicates=True)
    unseen = many.information(many.random(np.random.default_rng(0), 1)[0]).inestimable()
    if not unseen:
        unseen = problem.information(everything[0]).inestimable()
    can_not = f"; no position there shows {'; '.join(unseen)}" if unseen else ""
    fixed = problem.stand.circumstances
    where, remedy = (f" with {fixed}", f"; change {fixed.replace(', ', ' or ')}") if fixed else ("", "")
    return (
        f"no program of {problem.n} positions within {limits}{where} can estimate all the parameters{can_not}{remedy}"
    )


def refuse_steps(optimizer: Optimizer, problem: Problem, instead: str) -> None:
    """Raise CompatibilityError where the stand stops at steps only."""
    if problem.stand.stepped:
        raise CompatibilityError(
            f"optimizer {type(optimizer).__name__} moves angles continuously, but stand "
            f"{type(problem.stand).__name__} stops at steps only; use {instead}, or leave the step out"
        )
