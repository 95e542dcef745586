"""The interface of an optimizer."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar, Generic, Self, TypeVar, cast, final, get_args

import numpy as np

from acalx.errors import CompatibilityError, Option, PluginError
from acalx.problem import Problem
from acalx.search.account import Account, Watch
from acalx.search.regularity import no_regular_program
from acalx.search.result import Found, Front, Result, Solution, Status

__all__ = ["Optimizer", "refuse_steps"]

Answer = TypeVar("Answer", bound=Found)
# A position within this of a limit, in rad, is on it.
_TOLERANCE = 1e-6


class Optimizer(ABC, Generic[Answer]):
    """What searches for the best program of a problem, or for the front of several objectives.

    A new optimizer gives `search`; `solve` refuses what does not fit, keeps the account and
    turns an interrupt into a result. Concrete optimizers are frozen dataclasses of options,
    ``Optimizer[Result]`` or, for several objectives, ``Optimizer[Front]``.

    Attributes
    ----------
    several : bool
        Whether it takes several objectives, and gives their front, rather than one criterion.
    by_position : bool
        Whether it looks at what each position shows by itself, so that their order must not matter.
    """

    several: ClassVar[bool] = False
    by_position: ClassVar[bool] = False

    def check(self, problem: Problem) -> None:
        """Raise CompatibilityError for a problem that the optimizer can't handle."""

    def exact(self) -> Self:
        """The same search with exactly the problem's number of positions, where it may take fewer."""
        return self

    @abstractmethod
    def search(self, problem: Problem, rng: np.random.Generator, account: Account) -> Answer:
        """Search for the best program; `account` is told of every evaluation."""

    @final
    def solve(self, problem: Problem, rng: np.random.Generator, watch: Watch | None = None) -> Answer:
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
        PluginError
            `search` gives something else than programs of the problem.
        """
        _check_objectives(self, problem)
        if problem.model.ordered and (self.by_position or problem.stand.axes.stepped):
            raise _order_matters(self, problem)
        self.check(problem)
        account = Account(watch)
        try:
            result = self.search(problem, rng, account)
        except KeyboardInterrupt:
            if not account.found:
                raise
            return cast(Answer, _interrupted(problem, account))
        _check_found(self, problem, result)
        if isinstance(result, Result) and not np.isfinite(result.best.loss):
            raise no_regular_program(problem)
        return result


def _check_found(optimizer: Optimizer[Any], problem: Problem, found: object) -> None:
    """Raise PluginError where an optimizer gives something else than programs of the problem."""
    name, kind = type(optimizer).__name__, Front if optimizer.several else Result
    if not isinstance(found, kind):
        raise PluginError(f"optimizer {name} gave {type(found).__name__}; expected a {kind.__name__}")
    given = found.solutions if isinstance(found, Result) else found.points if isinstance(found, Front) else ()
    if not given or found.status not in get_args(Status):
        raise PluginError(f"optimizer {name} gave {len(given)} programs with status {found.status!r}")
    for settings in (np.asarray(each.settings) for each in given):
        whole = settings.ndim == 2 and settings.shape[1] == problem.d and problem.held < len(settings) <= problem.n
        if not whole or not np.isfinite(settings).all():
            raise PluginError(
                f"optimizer {name} gave settings of shape {settings.shape}; expected up to ({problem.n}, {problem.d}), "
                "all of them finite"
            )
        wrong = np.flatnonzero(~problem.stand.axes.allows(settings[problem.held :], _TOLERANCE)) + problem.held + 1
        if len(wrong):
            raise PluginError(
                f"optimizer {name} gave positions that the stand can't take: {', '.join(map(str, wrong))}"
            )


def _interrupted(problem: Problem, account: Account) -> Found:
    """The best so far."""
    said = f"interrupted after {account.seconds:.1f} s; this is the best"
    canonical = problem.restrictions.canonical
    if account.best is None:
        return account.front_result("interrupted", f"{said} front so far", canonical)
    best = Solution(canonical(account.best.settings), account.best.loss)
    return account.result("interrupted", f"{said} program so far", (best,))


def _order_matters(optimizer: Optimizer[Any], problem: Problem) -> CompatibilityError:
    return CompatibilityError(
        "optimizer {name} looks at one position at a time on this stand, but what model {model} reads depends on their "
        "order; use {gradient} on a stand without steps",
        name=type(optimizer).__name__,
        model=problem.model.called,
        gradient=Option("optimizer", "gradient", "Gradient()"),
    )


def _check_objectives(optimizer: Optimizer[Any], problem: Problem) -> None:
    """Raise CompatibilityError where several objectives meet an optimizer of one, or one of several."""
    name, several = type(optimizer).__name__, len(problem.singles) > 1
    if optimizer.several and not several:
        raise CompatibilityError(
            "optimizer {name} takes several objectives, got {got} alone; give two or more, as in {example}, "
            "or use {other}",
            name=name,
            got=problem.criterion.label,
            example=Option("objectives", ["d", "a"], "Objectives([D(), A()])"),
            other=Option("optimizer", "gradient", "Gradient()"),
        )
    if several and not optimizer.several:
        raise CompatibilityError(
            "optimizer {name} takes one criterion, got the objectives {got}; for several use {one} or {other}, "
            "or multiply them to a product",
            name=name,
            got=problem.criterion.label,
            one=Option("optimizer", "scalarized", "Scalarized()"),
            other=Option("optimizer", "nsga2", "NSGA2()"),
        )


def refuse_steps(optimizer: Optimizer[Any], problem: Problem, instead: Option) -> None:
    """Raise CompatibilityError where the stand stops at steps only."""
    if problem.stand.axes.stepped:
        raise CompatibilityError(
            "optimizer {name} moves angles continuously, but stand {stand} stops at steps only; use {instead}, "
            "or leave the step out",
            name=type(optimizer).__name__,
            stand=type(problem.stand).__name__,
            instead=instead,
        )
