"""Descent of a stack of runs, each with an aim of its own among several objectives.

A run either minimizes a weighted sum of the losses, or seeks the least s for which no loss
exceeds its target by more than s times its rate. The targets may lie anywhere, so goals reach
every part of a front, also where it is not convex and weighted sums don't come. They are held
by an augmented Lagrangian, as are the ceilings of criteria with kinks (see
`acalx.search.descent`); every run that has gone through it is at a point where some
weighted sum of the gradients is zero, even where it misses its goal a little.

Source: Pascoletti and Serafini, J. Optim. Theory Appl. 42 (1984) 499; Bertsekas, Constrained
Optimization and Lagrange Multiplier Methods (1982), chapter 2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from acalx.criteria import Ceiling
from acalx.criteria.answers import gradient_of, loss_of
from acalx.numerics.arrays import Array
from acalx.numerics.bfgs import minimize_stack
from acalx.numerics.curvature import Curvature, curvature
from acalx.problem import Problem
from acalx.quantities.information import Information
from acalx.search.account import Account

__all__ = ["Aims", "Runs"]

_ROUNDS = 20
_FIRST_PENALTY = 10.0
_LARGEST_PENALTY = 1e6
_GROWTH = 10.0
# Penalty of a goal, over the smallest range of a loss; larger ones are stiffer and no closer.
_GOAL_PENALTY = 30.0
# By how much of the smallest range a goal may be missed.
_MISS = 0.003
# Limits of log t, as in descent.
_LOG_RANGE = 60.0


@dataclass(frozen=True)
class Aims:
    """What each of s runs seeks among k losses.

    Parameters
    ----------
    weights : array (s, k)
        Of the losses in what is minimized.
    targets : array (s, k)
        Goals of the losses; +inf where a run has none.
    rates : array (k,)
        How much of each loss an excess s stands for, the smallest of them 1.
    unit : float
        Smallest range of a loss.
    """

    weights: Array
    targets: Array
    rates: Array
    unit: float

    @property
    def has_goal(self) -> np.ndarray:
        """Which runs have goals, (s,)."""
        return np.asarray(np.isfinite(self.targets).all(axis=-1))

    def excess(self, losses: Array) -> Array:
        """Least s for losses (s, k), zero for runs without goals."""
        reached = ((losses - self.targets) / self.rates).max(axis=-1)
        return np.where(self.has_goal, reached, 0.0)

    def merit(self, losses: Array) -> Array:
        """What is minimized, (s,)."""
        return np.asarray(self.excess(losses) + (self.weights * losses).sum(axis=-1))

    def select(self, index: np.ndarray) -> Aims:
        """Of some of the runs."""
        return Aims(self.weights[index], self.targets[index], self.rates, self.unit)


@dataclass
class _State:
    """Where runs are: variables, multipliers and what is known of the curvature."""

    x: Array
    ceilings: list[Array]
    goals: Array
    penalty: Array
    curvature: Curvature

    def take(self, index: np.ndarray) -> _State:
        return _State(
            self.x[index],
            [multiplier[index] for multiplier in self.ceilings],
            self.goals[index],
            self.penalty[index],
            self.curvature.take(index),
        )


class Runs:
    """A stack of runs, begun at programs (s, n, d) or at the ends of earlier runs.

    Attributes
    ----------
    settings : array (s, n, d), in rad
    losses : array (s, k)
        Of the best program of each run.
    merit : array (s,)
        What its aim makes of them; inf where a run never had a regular program.
    """

    def __init__(self, problem: Problem, aims: Aims, account: Account, starts: Array, state: _State | None = None):
        self.problem, self.aims, self.account = problem, aims, account
        self.criteria = [single.objective.criterion for single in problem.singles]
        self.response = problem.response
        self.terms = [criterion.terms() for criterion in self.criteria]
        self.ceilings: list[Ceiling] = [ceiling for terms in self.terms for _, ceiling in terms.ceilings]
        owners = [(k, weight) for k, terms in enumerate(self.terms) for weight, _ in terms.ceilings]
        self.shares = np.array([[weight * (k == owner) for owner, weight in owners] for k in range(len(self.terms))])
        self.angles = starts[0].size
        self.settings, self.losses = starts.copy(), problem.losses(starts)
        self.merit = np.where(np.isfinite(self.losses).all(axis=-1), self._merit(self.losses), np.inf)
        self.state = self._begin(starts) if state is None else state
        self.state.x[:, -1] = np.nan_to_num(aims.excess(self.losses), posinf=0.0)
        lower, upper = problem.restrictions.limits_around(starts)
        floors = np.array([max(ceiling.log_floor, -_LOG_RANGE) for ceiling in self.ceilings] + [-np.inf])
        tops = np.array([_LOG_RANGE] * len(self.ceilings) + [np.inf])
        self.lower, self.upper = (
            np.concatenate([limit, np.broadcast_to(rest, (len(starts), len(rest)))], axis=-1)
            for limit, rest in ((lower, floors), (upper, tops))
        )

    def again(self, index: np.ndarray, aims: Aims) -> Runs:
        """Runs with other aims that go on from where some of these ended."""
        state = self.state.take(index)
        if self.ceilings:  # what held them firmly there would hold them fast here
            state.penalty[:] = _FIRST_PENALTY
            state.curvature = curvature(*state.x.shape)
        return Runs(self.problem, aims, self.account, self.settings[index], state)

    def _merit(self, losses: Array) -> Array:
        with np.errstate(invalid="ignore"):
            return self.aims.merit(losses)

    def _begin(self, starts: Array) -> _State:
        information = self.response.information(starts)
        logs = [loss_of(ceiling, information) for ceiling in self.ceilings]
        columns = [starts.reshape(len(starts), -1), *(log[:, None] for log in logs), np.zeros((len(starts), 1))]
        x = np.concatenate(columns, axis=-1)
        k = len(self.terms)
        return _State(
            x,
            [ceiling.start(self.problem.parameters, (len(starts),)) for ceiling in self.ceilings],
            np.where(self.aims.has_goal[:, None], np.full((1, k), 1.0 / k), 0.0),
            np.full(len(starts), _FIRST_PENALTY),
            curvature(*x.shape),
        )

    def descend(self, tolerance: float, iterations: int) -> Runs:
        """Rounds of smooth minimization, until goals and ceilings are held."""
        going = np.flatnonzero(np.isfinite(self.merit))
        gap = np.full(len(self.merit), np.inf)
        previous = np.full(len(self.merit), np.inf)
        for _ in range(_ROUNDS):
            if not len(going):
                break
            self._round(going, tolerance, iterations)
            settings = self._settings(self.state.x[going])
            information = self.response.information(settings)
            losses = np.stack([loss_of(criterion, information) for criterion in self.criteria], axis=-1)
            merit = self.aims.select(going).merit(losses)
            better = merit < self.merit[going]
            where = going[better]
            self.settings[where], self.losses[where], self.merit[where] = (
                settings[better],
                losses[better],
                merit[better],
            )
            miss, open_gap = self._update(information, losses, going)
            held = (miss < _MISS * self.aims.unit) & (open_gap < 10 * tolerance)
            if self.ceilings:
                with np.errstate(invalid="ignore"):
                    held &= np.abs(merit - previous[going]) < max(tolerance, 1e-6)
            slow = open_gap > 0.25 * gap[going]
            self.state.penalty[going[slow]] = np.minimum(self.state.penalty[going[slow]] * _GROWTH, _LARGEST_PENALTY)
            gap[going], previous[going] = open_gap, merit
            going = going[~held & np.isfinite(merit)]
        return self

    def _settings(self, x: Array) -> Array:
        return np.asarray(x[:, : self.angles].reshape(-1, *self.settings.shape[1:]))

    def _smooth(self, information: Information, log_t: Array) -> Array:
        """Losses (a, k) with log t in the place of the maxima."""
        losses: Array = log_t @ self.shares.T
        for k, terms in enumerate(self.terms):
            for weight, criterion in terms.smooth:
                losses[:, k] += weight * loss_of(criterion, information)
        return losses

    def _gradient(self, information: Information, slopes: Array) -> Array:
        """Gradient (a, p, p) of the smooth parts, for slopes (a, k) with respect to the losses."""
        gradient = np.zeros(information.matrix.shape)
        for k, terms in enumerate(self.terms):
            for weight, criterion in terms.smooth:
                each = weight * slopes[:, k, None, None]
                gradient += each * gradient_of(criterion, information)
        return gradient

    def _goals(self, losses: Array, s: Array, members: np.ndarray) -> tuple[Array, Array]:
        """By how much goals are exceeded, over their rates, and the next multipliers, (a, k)."""
        excess = (losses - self.aims.targets[members]) / self.aims.rates - s[:, None]
        return excess, np.maximum(self.state.goals[members] + self._goal_penalty * excess, 0.0)

    @property
    def _goal_penalty(self) -> float:
        return _GOAL_PENALTY / self.aims.unit

    def _round(self, going: np.ndarray, tolerance: float, iterations: int) -> None:
        """Minimize the Lagrangian for fixed multipliers."""

        def objective(x: Array, index: np.ndarray) -> tuple[Array, Array]:
            members = going[index]
            settings = self._settings(x)
            at = self.response.at(settings)
            self.account.evaluations += len(x)
            log_t, s = x[:, self.angles : -1], x[:, -1]
            has_goal = self.aims.has_goal[members]
            with np.errstate(invalid="ignore", over="ignore"):
                losses = self._smooth(at.information, log_t)
                _, following = self._goals(losses, s, members)
                before = self.state.goals[members]
                value = s * has_goal + (self.aims.weights[members] * losses).sum(axis=-1)
                value += (following**2 - before**2).sum(axis=-1) / (2.0 * self._goal_penalty)
                slopes = self.aims.weights[members] + following / self.aims.rates
                gradient = self._gradient(at.information, slopes)
                by_log = slopes @ self.shares
                for k, ceiling in enumerate(self.ceilings):
                    more, by_matrix, slope, _ = ceiling.hold(
                        at.information, log_t[:, k], self.state.ceilings[k][members], self.state.penalty[members]
                    )
                    value, gradient = value + more, gradient + by_matrix
                    by_log[:, k] += slope
            singular = at.information.singular
            if self.problem.restrictions.active:
                singular = singular | ~self.problem.restrictions.permits(settings)
            value = np.where(singular, np.inf, value)
            gradient = np.where(singular[:, None, None], 0.0, gradient)
            by_angle = at.pull(gradient).reshape(len(x), -1)
            by_s = has_goal - following.sum(axis=-1)
            return value, np.concatenate([by_angle, by_log, by_s[:, None]], axis=-1)

        def project(x: Array, allowed: Array) -> Array:
            x = x.copy()
            x[:, : self.angles] = self.problem.restrictions.project(self._settings(x), self._settings(allowed)).reshape(
                len(x), -1
            )
            return x

        known = self.state.curvature.take(going)
        minima = minimize_stack(
            objective,
            self.state.x[going],
            self.lower[going],
            self.upper[going],
            tolerance=tolerance,
            iterations=iterations,
            project=project if self.problem.restrictions.active else None,
            known=known,
        )
        self.state.curvature.put(going, known)
        self.state.x[going] = minima.x

    def _update(self, information: Information, losses: Array, going: np.ndarray) -> tuple[Array, Array]:
        """Move the multipliers on; by how much goals are missed, and ceilings are off the losses, (a,) each."""
        log_t, s = self.state.x[going, self.angles : -1], self.state.x[going, -1]
        smooth = self._smooth(information, log_t)
        with np.errstate(invalid="ignore"):
            excess, following = self._goals(smooth, s, going)
            slack = np.maximum(excess, -self.state.goals[going] / self._goal_penalty)
            miss = np.where(self.aims.has_goal, 1.0, 0.0)[going] * np.abs(np.nan_to_num(slack)).max(axis=-1)
            self.state.goals[going] = following
            for k, ceiling in enumerate(self.ceilings):
                *_, multiplier = ceiling.hold(
                    information, log_t[:, k], self.state.ceilings[k][going], self.state.penalty[going]
                )
                self.state.ceilings[k][going] = multiplier
            return miss, np.abs(losses - smooth).max(axis=-1)
