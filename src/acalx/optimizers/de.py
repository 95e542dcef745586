"""Differential evolution, by scipy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from acalx.errors import ArgumentError
from acalx.numerics.arrays import Array
from acalx.optimizers.base import Optimizer
from acalx.options import is_number, is_whole, keep, require_count, require_positive, require_switch
from acalx.problem import Problem
from acalx.search.account import Account
from acalx.search.agreement import fewest_starts, judge
from acalx.search.encoding import Encoding
from acalx.search.ending import result_of
from acalx.search.result import Result, Status
from acalx.search.settle import settle

__all__ = ["DifferentialEvolution"]

# The generation whose trial programs are taken as companions: better than random ones, and
# not yet drawn together around one minimum.
_YOUNG = 5
# After so many generations without a program that can estimate all parameters there is none.
_PATIENCE = 50

_BASES = ("best1", "rand1", "randtobest1", "currenttobest1", "best2", "rand2")
_STRATEGIES = tuple(base + crossover for base in _BASES for crossover in ("bin", "exp"))


@final
@dataclass(frozen=True)
class DifferentialEvolution(Optimizer[Result]):
    """scipy's differential evolution, restarted from different populations.

    A whole population is evaluated in one call. Each restart begins with another population
    and ends when the population has drawn together or after `maxiter` generations; its best
    program is then polished by descent along the gradient, or from stop to stop where the stand
    has steps. It ends early when several restarts agree on the best loss and, where there was a polish, a
    better minimum is not to be expected (see `acalx.search.agreement`).

    Parameters
    ----------
    restarts : int
        Most restarts.
    agree : int
        So many restarts with the same best loss end the search.
    agreement : float
        Losses that differ by less are the same.
    popsize : int
        Members of the population for each angle; never fewer than 5 members in all.
    maxiter : int
        Most generations of a restart.
    strategy : str
        One of scipy's strategies.
    mutation : float or pair of float
        Differential weight, 0 to 2; of a pair one is drawn for each generation.
    recombination : float
        Crossover probability. It is high because the angles of a program act together;
        scipy's own default of 0.7 with a mutation of 0.5 to 1 does not converge at nine positions.
    spread : float
        A restart ends when the standard deviation of the population's losses is smaller.
    polish : bool
        Whether descent ends each restart.
    companions : int
        So many programs of the young population are polished beside the best of the old one.
        A population can draw together around a poor minimum; several restarts may around the
        same one. Companions cost little and show that there is a better one.

    Source: Storn and Price, J. Global Optim. 11 (1997) 341; restarts as in Egorov,
    Kiryachenko, Popov (2021).
    """

    restarts: int = 10
    agree: int = 3
    agreement: float = 1e-5
    popsize: int = 5
    maxiter: int = 1000
    strategy: str = "best1bin"
    mutation: float | Sequence[float] = (0.4, 0.7)
    recombination: float = 0.9
    spread: float = 1e-3
    polish: bool = True
    companions: int = 15

    def __post_init__(self) -> None:
        for name in ("restarts", "agree", "popsize", "maxiter"):
            require_count(name, getattr(self, name))
        for name in ("agreement", "spread"):
            require_positive(name, getattr(self, name))
        if self.strategy not in _STRATEGIES:
            raise ArgumentError.of("strategy", self.strategy, f"must be one of {', '.join(_STRATEGIES)}")
        weights = self.mutation if isinstance(self.mutation, Sequence) else (self.mutation,)
        if not all(is_number(w) and 0 <= w < 2 for w in weights) or len(weights) not in (1, 2):
            raise ArgumentError.of("mutation", self.mutation, "must be a number from 0 to 2, or two of them")
        if not is_number(self.recombination) or not 0 <= self.recombination <= 1:
            raise ArgumentError.of("recombination", self.recombination, "must be a number from 0 to 1")
        if not is_whole(self.companions) or self.companions < 0:
            raise ArgumentError.of("companions", self.companions, "must be a whole number, 0 or more")
        require_switch("polish", self.polish)
        keep(self, "mutation")

    def search(self, problem: Problem, rng: np.random.Generator, account: Account) -> Result:
        """Restarts until enough of them agree."""
        encoding = Encoding(problem.restrictions)
        settings, losses = np.empty((0, problem.n, problem.d)), np.empty(0)
        raw = np.empty(0)
        status: Status = "ok"
        while True:
            winner, members = self._evolve(problem, encoding, rng, account, len(raw) / self.restarts)
            raw = np.append(raw, problem.loss(winner))
            ends, end_losses = winner[None], raw[-1:]
            if self.polish and np.isfinite(raw[-1]):
                descent = settle(problem, np.concatenate([ends, members]), account=account)
                ends, end_losses = descent.settings, descent.loss
            settings, losses = np.concatenate([settings, ends]), np.concatenate([losses, end_losses])
            best = int((losses <= losses.min() + self.agreement).sum())
            enough = judge(losses, self.agreement).settled and len(losses) >= fewest_starts(problem)
            counted = f"{best} of {len(losses)} programs from {len(raw)} restarts"
            if len(raw) >= self.agree and best >= self.agree and (enough or not self.polish):
                message = f"stopped early: {counted} agree on the best loss"
                break
            if len(raw) >= self.restarts or not np.isfinite(losses.min()):
                message = f"all restarts used: {counted} reached the best loss"
                status = "limit"
                break
        gain = float(raw.min() - losses.min()) if self.polish and np.isfinite(raw.min()) else None
        return result_of(
            problem, account, settings, losses, status=status, message=message, agreement=self.agreement, gain=gain
        )

    def _evolve(
        self, problem: Problem, encoding: Encoding, rng: np.random.Generator, account: Account, done: float
    ) -> tuple[Array, Array]:
        """One restart: the best program (n, d), and members (k, n, d) of the young population."""
        from scipy.optimize import differential_evolution

        generation = 0
        young = np.empty((0, problem.n, problem.d))

        def losses(columns: Array) -> Array:
            nonlocal young
            settings = encoding.settings(columns.T)
            values = problem.loss(settings)
            if generation == _YOUNG:
                young = settings[np.isfinite(values)][: self.companions]
            account.fraction = done + generation / self.maxiter / self.restarts
            account.see(settings, values)
            return values

        def count(intermediate_result: Any) -> bool:
            nonlocal generation
            generation += 1
            return account.best is None and generation >= _PATIENCE

        outcome = differential_evolution(
            losses,
            encoding.bounds,
            strategy=self.strategy,
            maxiter=self.maxiter,
            popsize=self.popsize,
            tol=0.0,
            atol=self.spread,
            mutation=tuple(self.mutation) if isinstance(self.mutation, Sequence) else self.mutation,
            recombination=self.recombination,
            rng=rng,
            callback=count,
            polish=False,
            init=self._population(problem, encoding, rng) if problem.restrictions.active else "latinhypercube",
            updating="deferred",
            vectorized=True,
            integrality=encoding.integral,
        )
        return encoding.settings(np.asarray(outcome.x)[None])[0], young

    def _population(self, problem: Problem, encoding: Encoding, rng: np.random.Generator) -> Array:
        """First members, permitted programs all: scipy's own would hardly be."""
        count = max(5, self.popsize * len(encoding.bounds))
        return encoding.vectors(problem.restrictions.random(rng, count))
