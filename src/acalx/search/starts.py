"""Descents from batches of random programs, until they agree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from acalx.criteria import Criterion
from acalx.numerics.arrays import Array
from acalx.problem import Problem
from acalx.search.account import Account
from acalx.search.agreement import Verdict, fewest_starts, judge
from acalx.search.settle import settle

__all__ = ["Ends", "descend_from_many", "regular_starts"]


@dataclass(frozen=True, eq=False)
class Ends:
    """Where many descents ended.

    Parameters
    ----------
    settings : array (s, n, d), in rad
    losses : array (s,)
    verdict : Verdict
    settled : bool
        Whether they agree; otherwise all starts were used.
    """

    settings: Array
    losses: Array
    verdict: Verdict
    settled: bool


def descend_from_many(
    problem: Problem,
    rng: np.random.Generator,
    account: Account,
    *,
    starts: int,
    batch: int,
    agreement: float,
    tolerance: float,
    iterations: int,
) -> Ends:
    """Batches of starts until they agree, or none can be better; options as those of `acalx.optimizers.Gradient`."""
    settings, losses = np.empty((0, problem.n, problem.d)), np.empty(0)
    largest = max(batch, problem.response.chunk(problem.n))
    floor = least_loss(problem.objective.criterion)
    fewest = min(fewest_starts(problem) if floor == -np.inf else batch, starts)
    while True:
        # as many again as before: a large stack costs far less than many small ones
        count = min(max(batch, fewest - len(losses), len(losses)), starts - len(losses), largest)
        account.fraction = len(losses) / starts
        descent = settle(
            problem,
            regular_starts(problem, rng, count),
            account=account,
            tolerance=tolerance,
            iterations=iterations,
        )
        settings = np.concatenate([settings, descent.settings])
        losses = np.concatenate([losses, descent.loss])
        verdict = judge(losses, agreement)
        settled = (verdict.settled and len(losses) >= fewest) or bool((losses <= floor + 1e-9).any())
        if settled or len(losses) >= starts:
            return Ends(settings, losses, verdict, settled)


def least_loss(criterion: Criterion) -> float:
    """What no loss is below: the floors of a criterion that has floors and nothing else; otherwise -inf."""
    terms = criterion.terms()
    if terms.smooth:
        return -np.inf
    return sum(weight * ceiling.log_floor for weight, ceiling in terms.ceilings)


def regular_starts(problem: Problem, rng: np.random.Generator, count: int) -> Array:
    """Random programs, singular ones drawn again a few times."""
    programs = problem.restrictions.random(rng, count)
    for _ in range(20):
        singular = ~np.isfinite(problem.losses(programs)).all(axis=-1)
        if not singular.any():
            break
        programs[singular] = problem.restrictions.random(rng, int(singular.sum()))
    return programs
