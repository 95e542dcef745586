"""Many starts, exact gradients."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.arrays import Array
from acalx.optimizers.agreement import distinct_solutions, fewest_starts, judge
from acalx.optimizers.base import Account, Optimizer, Result, Status, refuse_steps
from acalx.optimizers.options import require_count, require_positive
from acalx.optimizers.settle import settle
from acalx.optimizers.starts import regular_starts
from acalx.problem import Problem

__all__ = ["Gradient"]


@final
@dataclass(frozen=True)
class Gradient(Optimizer):
    """Descends by exact gradients from random programs, several at a time.

    It ends early when the starts agree: when, from the number of different minima that they
    led to, the expected number of minima not seen yet is below one half, and the best of
    them was found at least three times.

    Parameters
    ----------
    starts : int
        Most starts.
    batch : int
        Starts that descend together at first; where they don't agree, their number doubles.
        On stands with limits, and for criteria with kinks, it begins with more.
    agreement : float
        Losses that differ by less are the same minimum. A difference of 1e-5 in the loss of D
        is one of 0.00006 % in standard deviations for nine parameters.
    tolerance : float
        A descent ends where no component of the gradient is larger, in loss per radian.
    iterations : int
        Most steps of a descent.

    See `acalx.optimizers.agreement` for the rule for ending.
    """

    starts: int = 200
    batch: int = 8
    agreement: float = 1e-5
    tolerance: float = 1e-7
    iterations: int = 2000

    def __post_init__(self) -> None:
        for name in ("starts", "batch", "iterations"):
            require_count(name, getattr(self, name))
        for name in ("agreement", "tolerance"):
            require_positive(name, getattr(self, name))

    def check(self, problem: Problem) -> None:
        """Refuses stands with steps."""
        refuse_steps(self, problem, "optimizer=exchange")

    def search(self, problem: Problem, rng: np.random.Generator, account: Account) -> Result:
        """Batches of starts until they agree."""
        settings: list[Array] = []
        losses = np.empty(0)
        status: Status = "ok"
        largest = max(self.batch, problem.chunk)
        fewest = min(fewest_starts(problem), self.starts)
        while True:
            # as many again as before: a large stack costs far less than many small ones
            count = min(max(self.batch, fewest - len(losses), len(losses)), self.starts - len(losses), largest)
            account.fraction = len(losses) / self.starts
            descent = settle(
                problem,
                regular_starts(problem, rng, count),
                account=account,
                tolerance=self.tolerance,
                iterations=self.iterations,
            )
            settings += list(descent.settings)
            losses = np.concatenate([losses, descent.loss])
            verdict = judge(losses, self.agreement)
            if verdict.settled and len(losses) >= fewest:
                message = f"stopped early, the starts agree: {verdict}"
                break
            if len(losses) >= self.starts:
                message = f"all starts used: {verdict}"
                status = "limit"
                break
        return Result(
            status,
            message,
            distinct_solutions(problem, settings, losses, self.agreement),
            account.evaluations,
            account.seconds,
            account.history,
        )
