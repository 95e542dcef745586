"""One program for everything at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from acalx.optimizers import Optimizer
from acalx.problem import Problem
from acalx.schemes.base import Composed, Scheme
from acalx.search.account import Watch

__all__ = ["Joint"]


@final
@dataclass(frozen=True)
class Joint(Scheme):
    """One program, optimized for all the parameters of the model at once.

    It is the best that a criterion can have; the other schemes are there to compare with, and
    for criteria or searches that take one kind of sensors at a time.
    """

    def smallest_n(self, problem: Problem) -> int:
        """What the model needs, and more than are fixed."""
        return max(problem.model.smallest_n, problem.held + 1)

    def solve(
        self, problem: Problem, optimizer: Optimizer[Any], rng: np.random.Generator, watch: Watch | None = None
    ) -> Composed:
        """The optimizer's program for the whole problem."""
        return Composed(optimizer.solve(problem, rng, watch))
