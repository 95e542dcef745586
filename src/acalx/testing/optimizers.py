"""The contract of an optimizer, for one criterion or for several objectives."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from acalx.numerics.arrays import Array
from acalx.optimizers.base import Optimizer
from acalx.problem import Problem
from acalx.search.account import Account
from acalx.search.pareto import nondominated
from acalx.search.result import Found, Front, Result
from acalx.testing.rules import require, require_close, require_shape

__all__ = ["check_optimizer", "interrupt", "require_program"]


def check_optimizer(optimizer: Optimizer[Any], problem: Problem, *, restricted: bool = False, seed: int = 0) -> None:
    """Check an optimizer on a problem that it takes: its result, its account, an interrupt.

    Parameters
    ----------
    optimizer : Optimizer
    problem : Problem
        A small one, with one criterion or several objectives as the optimizer takes them; it is
        solved twice, and begun a third time.
    restricted : bool
        Whether it is solved once more with its first position fixed and no position twice.
    seed : int
        Of the random generator.
    """
    result, again = (optimizer.solve(problem, np.random.default_rng(seed)) for _ in range(2))
    require(result.status in ("ok", "limit"), optimizer, f"status is ok or limit, got {result.status!r}")
    require(bool(result.message), optimizer, "the message says why the search ended")
    require(result.evaluations > 0, optimizer, "evaluations are counted")
    require(isinstance(result, Front) == optimizer.several, optimizer, "several objectives have a front, one has not")
    _check_found(optimizer, problem, result)
    same = _bytes(result) == _bytes(again) and again.evaluations == result.evaluations
    require(same, optimizer, "the same seed gives the same result, bit for bit")
    if isinstance(result, Result):
        _check_history(optimizer, result)
    halted = optimizer.solve(problem, np.random.default_rng(seed), interrupt)
    require(halted.status == "interrupted", optimizer, f"lets an interrupt pass, got status {halted.status!r}")
    _check_found(optimizer, problem, halted)
    if restricted:
        narrower = replace(problem, n=problem.n + 1, fixed=result.program[:1], replicates=False)
        _check_found(optimizer, narrower, optimizer.solve(narrower, np.random.default_rng(seed)))


def interrupt(account: Account) -> None:
    """A watch that ends the search as soon as there is a program."""
    if account.found:
        raise KeyboardInterrupt


def require_program(part: object, problem: Problem, settings: Array, n: int) -> None:
    """Settings are a program of n positions that the problem permits: limits, zones, fixed positions, replicates."""
    require_shape(part, "a solution", settings, (n, problem.d))
    allows = problem.stand.axes.allows(settings[problem.held :])
    require(bool(allows.all()), part, "positions are ones the stand allows")
    if problem.fixed is not None:
        require(np.array_equal(settings[: problem.held], problem.fixed), part, "the fixed positions come first")
    require(bool(problem.restrictions.permits(settings)), part, "no position occurs again where none may")


def _check_found(optimizer: Optimizer[Any], problem: Problem, found: Found) -> None:
    if isinstance(found, Front):
        _check_front(optimizer, problem, found)
    elif isinstance(found, Result):
        _check_solutions(optimizer, problem, found)
    else:
        require(False, optimizer, f"the answer is a Result or a Front, got {type(found).__name__}")


def _check_solutions(optimizer: Optimizer[Any], problem: Problem, result: Result) -> None:
    """Programs that are permitted, the best first, with their losses."""
    losses = [solution.loss for solution in result.solutions]
    require(len(losses) > 0, optimizer, "there is one solution or more")
    require(losses == sorted(losses), optimizer, f"solutions come best first, got losses {losses}")
    for solution in result.solutions:
        n = problem.n if result.survey is None else len(solution.settings)  # a survey is of numbers up to n
        require_program(optimizer, problem, solution.settings, n)
        loss = problem.loss(solution.settings)
        require_close(optimizer, "the loss is that of the program", np.array(solution.loss), loss, 1e-9)


def _check_front(optimizer: Optimizer[Any], problem: Problem, front: Front) -> None:
    """Points that are permitted, none better than another in all, the knee one of them."""
    require(len(front.points) > 0, optimizer, "there is a front")
    losses, settings = front.losses, np.array([point.settings for point in front.points])
    require(len(nondominated(losses)) == len(losses), optimizer, "no point of the front is better than another in all")
    require(bool((np.diff(losses[:, 0]) >= 0).all()), optimizer, "points come by ascending first loss")
    for program in settings:
        require_program(optimizer, problem, program, problem.n)
    require_close(optimizer, "the losses are those of the programs", losses, problem.losses(settings), 1e-9)
    best = front.points[front.knee].settings
    require(np.array_equal(front.program, best), optimizer, "the program to take is the knee")


def _check_history(optimizer: Optimizer[Any], result: Result) -> None:
    """The account was told of every better program."""
    progress = [loss for _, _, loss in result.history]
    falls = all(after < before for before, after in pairwise(progress))
    require(bool(progress) and falls, optimizer, "the history is of a loss that falls")
    rule = "the account saw the best program"
    require_close(optimizer, rule, np.array(progress[-1]), np.array(result.best.loss), 1e-6)


def _bytes(found: Found) -> list[tuple[bytes, bytes]]:
    """Losses and programs of all that was found."""
    if isinstance(found, Front):
        return [(point.losses.tobytes(), point.settings.tobytes()) for point in found.points]
    assert isinstance(found, Result)
    return [(np.float64(s.loss).tobytes(), s.settings.tobytes()) for s in found.solutions]
