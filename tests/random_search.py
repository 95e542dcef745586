"""An optimizer as its author writes it, in a module of their own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.optimizers import Optimizer
from acalx.options import require_count
from acalx.problem import Problem
from acalx.search.account import Account
from acalx.search.ending import result_of
from acalx.search.result import Result
from acalx.search.settle import settle
from acalx.search.starts import regular_starts


@final
@dataclass(frozen=True)
class RandomSearch(Optimizer[Result]):
    """Draws programs and polishes the best of them."""

    draws: int = 200
    polished: int = 8

    def __post_init__(self) -> None:
        for name in ("draws", "polished"):
            require_count(name, getattr(self, name))

    def search(self, problem: Problem, rng: np.random.Generator, account: Account) -> Result:
        programs = regular_starts(problem, rng, self.draws)
        losses = problem.loss(programs)
        account.see(programs, losses)
        best = programs[np.argsort(losses, kind="stable")[: self.polished]]
        ends = settle(problem, best, account=account)
        message = f"the best {len(best)} of {self.draws} random programs polished"
        return result_of(problem, account, ends.settings, ends.loss, status="ok", message=message, agreement=1e-5)
