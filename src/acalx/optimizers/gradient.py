"""Many starts, exact gradients."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.errors import Option
from acalx.optimizers.base import Optimizer, refuse_steps
from acalx.options import require_count, require_positive
from acalx.problem import Problem
from acalx.search.account import Account
from acalx.search.ending import result_of
from acalx.search.result import Result
from acalx.search.starts import descend_from_many

__all__ = ["Gradient"]


@final
@dataclass(frozen=True)
class Gradient(Optimizer[Result]):
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

    See `acalx.search.agreement` for the rule for ending.
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
        refuse_steps(self, problem, Option("optimizer", "exchange", "Exchange()"))

    def search(self, problem: Problem, rng: np.random.Generator, account: Account) -> Result:
        """Batches of starts until they agree."""
        ends = descend_from_many(
            problem,
            rng,
            account,
            starts=self.starts,
            batch=self.batch,
            agreement=self.agreement,
            tolerance=self.tolerance,
            iterations=self.iterations,
        )
        how = "stopped early, the starts agree" if ends.settled else "all starts used"
        return result_of(
            problem,
            account,
            ends.settings,
            ends.losses,
            status="ok" if ends.settled else "limit",
            message=f"{how}: {ends.verdict}",
            agreement=self.agreement,
        )
