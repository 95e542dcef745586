"""The front of several objectives by gradient alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from acalx.errors import Option
from acalx.optimizers.base import Optimizer, refuse_steps
from acalx.options import require_count, require_points, require_positive
from acalx.problem import Problem
from acalx.search.account import Account
from acalx.search.ending import front_of
from acalx.search.front import FrontSearch
from acalx.search.result import Front
from acalx.search.starts import regular_starts

__all__ = ["Scalarized"]


@final
@dataclass(frozen=True)
class Scalarized(Optimizer[Front]):
    """Front of several objectives: each point is where descent meets a goal of its own.

    The ends are as good under their objective as `Gradient` alone finds. Between them goals are
    spread evenly and reached by descent, also where the front is not convex and no weighted
    sum of the objectives comes. All points descend together.

    Parameters
    ----------
    points : int
        Most points of the front; of k > 2 objectives the largest even lattice with no more.
    seeds : int
        Random programs from which goals are tried too, beside the ends.
    starts, batch, agreement, tolerance, iterations
        Of the search under each objective alone, as for `Gradient`.

    Source: Pascoletti and Serafini, J. Optim. Theory Appl. 42 (1984) 499; Das and Dennis, SIAM J.
    Optim. 8 (1998) 631.
    """

    points: int = 50
    seeds: int = 14
    starts: int = 200
    batch: int = 8
    agreement: float = 1e-5
    tolerance: float = 1e-7
    iterations: int = 2000

    several: ClassVar[bool] = True

    def __post_init__(self) -> None:
        require_points("points", self.points)
        for name in ("seeds", "starts", "batch", "iterations"):
            require_count(name, getattr(self, name))
        for name in ("agreement", "tolerance"):
            require_positive(name, getattr(self, name))

    def check(self, problem: Problem) -> None:
        """Refuses stands with steps, and fewer points than objectives."""
        refuse_steps(self, problem, Option("optimizer", "nsga2", "NSGA2()"))
        require_points("points", self.points, len(problem.singles))

    def search(self, problem: Problem, rng: np.random.Generator, account: Account) -> Front:
        """Ends, then goals between them."""
        search = FrontSearch(self.points, self.starts, self.batch, self.agreement, self.tolerance, self.iterations)
        settled = search.run(problem, rng, account, regular_starts(problem, rng, self.seeds))
        count = 0 if account.front is None else len(account.front[1])
        message = f"{count} points on the front" if count > 1 else "the objectives agree: one program is best in all"
        message += "" if settled else "; the starts under one objective alone did not agree"
        return front_of(problem, account, status="ok" if settled else "limit", message=message)
