"""How searches end: what was found, each program once and as it is written, with the account of the search."""

from __future__ import annotations

from collections.abc import Iterable

from acalx.numerics.arrays import Array
from acalx.problem import Problem
from acalx.search.account import Account
from acalx.search.agreement import distinct_solutions
from acalx.search.regularity import no_regular_program
from acalx.search.result import ApproximateDesign, Front, Result, Status, Survey

__all__ = ["front_of", "result_of"]


def result_of(
    problem: Problem,
    account: Account,
    settings: Iterable[Array],
    losses: Iterable[float],
    *,
    status: Status,
    message: str,
    agreement: float,
    sort: bool = True,
    gain: float | None = None,
    survey: Survey | None = None,
    design: ApproximateDesign | None = None,
) -> Result:
    """The end of a search for one criterion.

    Parameters
    ----------
    problem : Problem
    account : Account
    settings, losses
        Programs (n, d) in rad and their losses, in any order; those as good as the best are kept.
    status : str
        ``ok``, or ``limit`` where a limit ended the search before it could be trusted.
    message : str
        Why it ended.
    agreement : float
        Losses that differ by less are as good.
    sort : bool
        Whether positions are sorted by their angles: where their order has no meaning.
    gain, survey, design
        As of `Result`.
    """
    solutions = distinct_solutions(problem, settings, losses, agreement, sort=sort)
    return account.result(status, message, solutions, gain=gain, survey=survey, design=design)


def front_of(problem: Problem, account: Account, *, status: Status, message: str) -> Front:
    """The end of a search for several objectives: the front that the account holds.

    Raises
    ------
    NoProgramError
        Where it holds none, since no program was regular.
    """
    if account.front is None:
        raise no_regular_program(problem)
    return account.front_result(status, message, problem.restrictions.canonical)
