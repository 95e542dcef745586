"""Exchange of positions for candidates: for tables with steps, and wherever positions come from a list."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.numerics.arrays import Array
from acalx.optimizers.base import Optimizer
from acalx.options import require_count, require_positive
from acalx.problem import Problem
from acalx.search.account import Account
from acalx.search.descent import descend
from acalx.search.ending import result_of
from acalx.search.result import Result, Status
from acalx.search.settle import settle
from acalx.search.starts import regular_starts
from acalx.search.swaps import Candidates, candidates_of, descend_swaps, nearest

__all__ = ["Exchange"]

# Programs that differ by less in loss are taken for the same one.
_SAME = 1e-9
# At most so many positions of a program are changed at a time.
_MOST_CHANGED = 3
# How well descent without steps is converged before its end is rounded.
_COARSE = 1e-4
_STEPS = 300


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
        ends: list[tuple[Array, Array]] = []
        status: Status = "ok"
        while True:
            account.fraction = len(ends) / self.chains
            ends.append(self._chain(problem, candidates, rng, account))
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

    def _chain(
        self, problem: Problem, candidates: Candidates | None, rng: np.random.Generator, account: Account
    ) -> tuple[Array, Array]:
        """The best programs (k, n, d) of a chain and their losses (k,)."""
        starts = self._starts(problem, candidates, rng, account)
        settings, losses = self._best(*self._exchanged(problem, starts, candidates, account))
        idle = 0
        while idle < self.patience and np.isfinite(losses).all():
            before = losses.min()
            new = self._changed(problem, settings, rng)
            more, more_losses = self._exchanged(problem, new, candidates, account)
            # each of the elite is followed by its own copies only, so that not all become alike
            own = more_losses.reshape(len(losses), -1)
            best = own.argmin(axis=1) + np.arange(len(losses)) * self.copies
            better = more_losses[best] < losses - _SAME
            settings[better], losses[better] = more[best[better]], more_losses[best[better]]
            idle = 0 if losses.min() < before - self.agreement else idle + 1
        if not all(setting.step is not None for setting in problem.stand.settings):
            polished = settle(problem, settings, account=account)
            return self._best(polished.settings, polished.loss)
        return settings, losses

    def _starts(
        self, problem: Problem, candidates: Candidates | None, rng: np.random.Generator, account: Account
    ) -> Array:
        random = regular_starts(problem, rng, self.starts)
        half = self.starts // 2
        return np.concatenate([self._rounded(problem, random[:half], candidates, account), random[half:]])

    def _rounded(self, problem: Problem, starts: Array, candidates: Candidates | None, account: Account) -> Array:
        """Minima of the stand without its steps, rounded to candidates."""
        limits = problem.restrictions.limits_around(starts, hold=[False] * problem.d)
        unseen = Account()  # these programs are not on the stand's stops
        descent = descend(problem, starts, account=unseen, limits=limits, tolerance=_COARSE, iterations=_STEPS)
        account.evaluations += unseen.evaluations
        return nearest(problem, descent.settings, candidates)

    def _exchanged(
        self, problem: Problem, starts: Array, candidates: Candidates | None, account: Account
    ) -> tuple[Array, Array]:
        if candidates is None:  # steps so fine that the way there is better gone without them
            starts = self._rounded(problem, starts, candidates, account)
        descent = descend_swaps(problem, starts, candidates, account=account)
        return descent.settings, descent.loss

    def _best(self, settings: Array, losses: Array) -> tuple[Array, Array]:
        """The elite, each program once; where none is regular, any one."""
        order = np.argsort(losses, kind="stable")
        order = order[: max(1, int(np.isfinite(losses).sum()))]
        new = np.diff(losses[order], prepend=-np.inf) > _SAME
        order = order[new][: self.elite]
        return settings[order], losses[order]

    def _changed(self, problem: Problem, settings: Array, rng: np.random.Generator) -> Array:
        """Copies with some positions drawn anew."""
        programs = np.repeat(settings, self.copies, axis=0)
        free = problem.n - problem.held
        changed = np.minimum(rng.integers(1, _MOST_CHANGED + 1, len(programs)), free)
        ranks = rng.random((len(programs), free)).argsort(axis=1)
        which = np.zeros((len(programs), problem.n), dtype=bool)
        which[:, problem.held :] = ranks < changed[:, None]
        programs[which] = problem.stand.axes.random(rng, (int(which.sum()),))
        return problem.restrictions.apart(programs, rng)
