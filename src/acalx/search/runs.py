"""A stack of runs, each with an aim of its own: rounds of smooth minimization, and multipliers between them.

Every run that has gone through them is at a point where some weighted sum of the gradients is
zero, even where it misses its goal a little. One criterion is the case of one loss without goals.

Source: Bertsekas, Constrained Optimization and Lagrange Multiplier Methods (1982), chapter 2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from acalx.numerics.arrays import Array
from acalx.numerics.bfgs import minimize_stack
from acalx.numerics.curvature import Curvature, curvature
from acalx.search.account import Account
from acalx.search.aims import Aims
from acalx.search.lagrangian import Lagrangian, Multipliers

__all__ = ["Runs"]

_ROUNDS = 25
# Penalties grow where a gap is not at most so much of the one before.
_SHRINK = 0.25
# Losses with log t in the place of the maxima are as close to the losses themselves, in tolerances.
_GAP = 10.0


@dataclass
class _State:
    """Where runs are: variables, multipliers, and what one round learns that helps the next."""

    x: Array
    held: Multipliers
    curvature: Curvature

    def take(self, index: np.ndarray) -> _State:
        return _State(self.x[index], self.held.select(index), self.curvature.take(index))


class Runs:
    """A stack of runs, begun at programs or at the ends of earlier runs.

    Parameters
    ----------
    lagrangian : Lagrangian
    aims : Aims
    account : Account
    starts : array (s, n, d), in rad
    limits : (array (s, n d), array (s, n d)), optional
        Those of the restrictions around the starts unless they are given.

    Attributes
    ----------
    settings : array (s, n, d), in rad
    losses : array (s, k)
        Of the best program of each run.
    merit : array (s,)
        What its aim makes of them; inf where a run never had a regular program.
    converged : array (s,) of bool
        Which runs hold their ceilings and goals.
    """

    def __init__(
        self,
        lagrangian: Lagrangian,
        aims: Aims,
        account: Account,
        starts: Array,
        limits: tuple[Array, Array] | None = None,
        *,
        state: _State | None = None,
    ) -> None:
        self.lagrangian, self.aims, self.account = lagrangian, aims, account
        restrictions = lagrangian.restrictions
        self.settings = starts.copy()
        self.losses = np.stack([objective.loss(starts) for objective in lagrangian.objectives], axis=-1)
        if restrictions.active:
            self.losses[~restrictions.permits(starts)] = np.inf
        with np.errstate(invalid="ignore"):
            merit = aims.merit(self.losses)
        self.merit = np.where(np.isfinite(self.losses).all(axis=-1), merit, np.inf)
        self.converged = np.zeros(len(starts), dtype=bool)
        if state is None:
            x, held = lagrangian.begin(starts, aims)
            state = _State(x, held, curvature(*x.shape))
        self.state = state
        if aims.goals is not None:
            with np.errstate(invalid="ignore"):
                state.x[:, -1] = np.nan_to_num(aims.goals.excess(self.losses), posinf=0.0)
        self.lower, self.upper = lagrangian.limits(*(limits or restrictions.limits_around(starts)), aims)

    def again(self, index: np.ndarray, aims: Aims) -> Runs:
        """Runs with other aims that go on from where some of these ended; with goals if these have any."""
        state = self.state.take(index)
        if self.lagrangian.ceilings:  # what held them firmly there would hold them fast here
            state.held.loosen()
            state.curvature = curvature(*state.x.shape)
        return Runs(self.lagrangian, aims, self.account, self.settings[index], state=state)

    def descend(self, tolerance: float, iterations: int, agreement: float | None = None) -> Runs:
        """Rounds until goals and ceilings are held.

        Parameters
        ----------
        tolerance : float
            Of the gradient in a round, in loss per radian.
        iterations : int
            Most steps of a round.
        agreement : float, optional
            By how much the merit may still change from one round to the next; as the tolerance
            where it is left out.
        """
        agreement = tolerance if agreement is None else agreement
        lagrangian, state = self.lagrangian, self.state
        going = np.flatnonzero(np.isfinite(self.merit))
        gap = np.full(len(self.merit), np.inf)
        previous = np.full(len(self.merit), np.inf)
        for _ in range(_ROUNDS):
            if not len(going):
                break
            self._round(going, tolerance, iterations)
            x, aims, held = state.x[going], self.aims.select(going), state.held.select(going)
            settings = lagrangian.settings(x)
            information = lagrangian.response.at(settings).information
            losses = lagrangian.losses(information)
            following, miss, smoothed = lagrangian.update(x, information, aims, held)
            state.held.put(going, following)
            with np.errstate(invalid="ignore"):
                merit = aims.merit(losses)
                new_gap = np.abs(losses - smoothed).max(axis=-1)
                settled = (miss <= (aims.goals.tolerance if aims.goals else 0.0)) & (new_gap < _GAP * tolerance)
                if lagrangian.ceilings:
                    settled &= np.abs(merit - previous[going]) < agreement
            self._keep(going, settings, losses, merit)
            state.held.stiffen(going[new_gap > _SHRINK * gap[going]])
            gap[going], previous[going] = new_gap, merit
            self.converged[going[settled]] = True
            going = going[~settled & np.isfinite(merit)]
        return self

    def _keep(self, going: np.ndarray, settings: Array, losses: Array, merit: Array) -> None:
        """The best program of each run, and of all where they share one criterion."""
        if len(self.lagrangian.objectives) == 1:
            self.account.keep(settings, merit)
        better = merit < self.merit[going]
        where = going[better]
        self.settings[where], self.losses[where], self.merit[where] = settings[better], losses[better], merit[better]

    def _round(self, going: np.ndarray, tolerance: float, iterations: int) -> None:
        """Minimize the Lagrangian for fixed multipliers."""
        lagrangian, state = self.lagrangian, self.state

        def objective(x: Array, index: np.ndarray) -> tuple[Array, Array]:
            self.account.evaluations += len(x)
            members = going[index]
            return lagrangian.value_and_gradient(x, self.aims.select(members), state.held.select(members))

        known = state.curvature.take(going)
        minima = minimize_stack(
            objective,
            state.x[going],
            self.lower[going],
            self.upper[going],
            tolerance=tolerance,
            iterations=iterations,
            project=lagrangian.project if lagrangian.restrictions.active else None,
            known=known,
            sizes=lagrangian.sizes(state.x.shape[-1]),
        )
        state.curvature.put(going, known)
        state.x[going] = minima.x
