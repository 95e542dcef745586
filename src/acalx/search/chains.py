"""Chains of searches by exchange: the best programs are changed a little and exchanged anew.

Source: Lourenco, Martin, Stuetzle, Iterated Local Search (2003).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from acalx.numerics.arrays import Array
from acalx.problem import Problem
from acalx.search.account import Account
from acalx.search.descent import descend
from acalx.search.settle import settle
from acalx.search.starts import regular_starts
from acalx.search.swaps import Candidates, descend_swaps, nearest

__all__ = ["Chain"]

# Programs that differ by less in loss are taken for the same one.
_SAME = 1e-9
# At most so many positions of a program are changed at a time.
_MOST_CHANGED = 3
# How well descent without steps is converged before its end is rounded.
_COARSE = 1e-4
_STEPS = 300


@dataclass(frozen=True)
class Chain:
    """A chain of searches; options as those of `acalx.optimizers.Exchange`.

    Parameters
    ----------
    starts : int
        Half of them random programs, half minima without steps, rounded.
    elite : int
        So many of the best programs are changed in each round.
    copies : int
        So many changed copies of each.
    patience : int
        It ends after so many rounds without a better program.
    agreement : float
        Gains in loss that are less don't count.
    """

    starts: int
    elite: int
    copies: int
    patience: int
    agreement: float

    def run(
        self, problem: Problem, candidates: Candidates | None, rng: np.random.Generator, account: Account
    ) -> tuple[Array, Array]:
        """The best programs (k, n, d) of a chain and their losses (k,), ascending.

        Parameters
        ----------
        problem : Problem
        candidates : Candidates or None
            What positions are exchanged for; None: one setting at a time.
        rng : numpy Generator
        account : Account
        """
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
