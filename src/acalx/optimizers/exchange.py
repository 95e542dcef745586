"""Exchange of positions for candidates: for tables with steps, and wherever positions come from a list."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from acalx.numerics.arrays import Array
from acalx.optimizers.base import Optimizer
from acalx.options import require_count, require_positive
from acalx.problem import Problem
from acalx.search.account import Account
from acalx.search.chains import Chain
from acalx.search.ending import result_of
from acalx.search.result import Result, Status
from acalx.search.swaps import candidates_of

__all__ = ["Exchange"]


@final
@dataclass(frozen=True)
class Exchange(Optimizer[Result]):
    """Exchanges one position after another for the best candidate, from many starts.

    Candidates are all the stops of the stand. Where a setting has no steps they are a grid, and
    the program found is polished by descent. On very fine steps every start is first a minimum of
    the stand without steps, and then each angle of a position is exchanged by itself. A chain of
    searches begins with starts, half of them random and half minima of the stand without its
    steps, rounded; then its best programs are changed in one to three positions and exchanged
    anew, until that gives nothing better for some rounds. Chains are begun until several end in
    the same program.

    Parameters
    ----------
    chains : int
        Most chains.
    agree : int
        So many chains with the same best loss end the search.
    agreement : float
        Losses that differ by less are the same.
    starts : int
        Starts of a chain.
    elite : int
        So many of the best programs are changed in each round.
    copies : int
        So many changed copies of each.
    patience : int
        A chain ends after so many rounds without a better program.
    candidates : int
        Points of the grid where a setting has no steps.

    Source: Cook and Nachtsheim, Technometrics 22 (1980) 315; Meyer and Nachtsheim, Technometrics 37
    (1995) 60; changes of the best: Lourenco, Martin, Stuetzle, Iterated Local Search (2003).
    """

    by_position: ClassVar[bool] = True
    chains: int = 3
    agree: int = 2
    agreement: float = 1e-6
    starts: int = 100
    elite: int = 10
    copies: int = 4
    patience: int = 12
    candidates: int = 2000

    def __post_init__(self) -> None:
        for name in ("chains", "agree", "starts", "elite", "copies", "patience", "candidates"):
            require_count(name, getattr(self, name))
        require_positive("agreement", self.agreement)

    def search(self, problem: Problem, rng: np.random.Generator, account: Account) -> Result:
        """Chains until enough of them agree."""
        candidates = candidates_of(problem, self.candidates)
        chain = Chain(self.starts, self.elite, self.copies, self.patience, self.agreement)
        ends: list[tuple[Array, Array]] = []
        status: Status = "ok"
        while True:
            account.fraction = len(ends) / self.chains
            ends.append(chain.run(problem, candidates, rng, account))
            best = np.array([losses.min(initial=np.inf) for _, losses in ends])
            same = int((best <= best.min() + self.agreement).sum())
            if same >= self.agree:
                message = f"stopped early: {same} of {len(ends)} chains of exchanges agree on the best loss"
                break
            if len(ends) == self.chains or not np.isfinite(best.min()):
                message = f"all chains used: {same} of {len(ends)} reached the best loss"
                status = "limit"
                break
        settings, losses = (np.concatenate(parts) for parts in zip(*ends, strict=True))
        return result_of(problem, account, settings, losses, status=status, message=message, agreement=self.agreement)
