"""The optimizer that suits the stand."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from acalx.optimizers.base import Account, Optimizer, Result
from acalx.optimizers.exchange import Exchange
from acalx.optimizers.gradient import Gradient
from acalx.problem import Problem

__all__ = ["Auto"]


@final
@dataclass(frozen=True)
class Auto(Optimizer):
    """One optimizer for stands with steps and another for the others.

    Parameters
    ----------
    stepped : Optimizer
        Where any of the settings stops at steps only.
    continuous : Optimizer
    """

    stepped: Optimizer = field(default_factory=Exchange)
    continuous: Optimizer = field(default_factory=Gradient)

    def choose(self, problem: Problem) -> Optimizer:
        """The one for a problem."""
        return self.stepped if problem.stand.stepped else self.continuous

    def check(self, problem: Problem) -> None:
        """What the chosen one refuses."""
        self.choose(problem).check(problem)

    def search(self, problem: Problem, rng: np.random.Generator, account: Account) -> Result:
        """The search of the chosen one, which is named in the message."""
        chosen = self.choose(problem)
        result = chosen.search(problem, rng, account)
        return replace(result, message=f"{type(chosen).__name__}: {result.message}")
