"""Descent from many starts at once to local minima of a problem, kinks included.

A smooth criterion is minimized as it is. One with ceilings (see `acalx.criteria.Ceiling`) has
kinks just at its minima; there log t of each ceiling joins the variables, and an augmented
Lagrangian holds it above what it is the maximum of, so that everything minimized is smooth.

Source: Bertsekas, Constrained Optimization and Lagrange Multiplier Methods (1982), chapter 2;
for the matrix inequality of E: Kocvara and Stingl, Optim. Methods Softw. 18 (2003) 317.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from acalx.criteria import Ceiling
from acalx.criteria.answers import gradient_of, loss_of
from acalx.numerics.arrays import Array
from acalx.numerics.bfgs import minimize_stack
from acalx.numerics.curvature import curvature
from acalx.problem import Objective
from acalx.quantities.information import Information
from acalx.search.account import Account

__all__ = ["Descent", "descend"]

_FIRST_PENALTY = 10.0
_LARGEST_PENALTY = 1e6
_GROWTH = 10.0
_ROUNDS = 25
# Limits of log t, far outside any loss that occurs, so that no step overflows.
_LOG_RANGE = 60.0


@dataclass(frozen=True)
class Descent:
    """Local minima that starts led to.

    Parameters
    ----------
    settings : array (s, n, d), in rad
    loss : array (s,)
    converged : array (s,) of bool
    multipliers : tuple of arrays (s, ...)
        Those of the ceilings of the criterion, as the last round left them.
    """

    settings: Array
    loss: Array
    converged: np.ndarray
    multipliers: tuple[Array, ...] = ()


class Bounds(Protocol):
    """What keeps descent where programs may be: see `acalx.problem.Restrictions`."""

    @property
    def active(self) -> bool: ...
    def limits_around(self, settings: Array) -> tuple[Array, Array]:
        """Bounds (s, n d) of the variables around programs (s, n, d), infinite where there are none."""

    def permits(self, settings: Array) -> np.ndarray: ...
    def project(self, settings: Array, allowed: Array) -> Array: ...


class Landscape(Protocol):
    """What descent needs of a problem: how good programs are, and which there are."""

    @property
    def objective(self) -> Objective: ...
    @property
    def restrictions(self) -> Bounds: ...
    def loss(self, settings: Array) -> Array: ...
    def loss_and_gradient(self, settings: Array) -> tuple[Array, Array]: ...


def descend(
    problem: Landscape,
    starts: Array,
    *,
    account: Account,
    tolerance: float = 1e-7,
    iterations: int = 2000,
    limits: tuple[Array, Array] | None = None,
) -> Descent:
    """Local minima from starts (s, n, d) in rad; none ends above its start or outside the limits.

    The limits (s, n d) are those of the problem around the starts unless others are given.
    """
    lower, upper = limits or problem.restrictions.limits_around(starts)
    if problem.objective.criterion.terms().ceilings:
        return _Held(problem, starts, lower, upper, account).run(tolerance, iterations)
    shape = starts.shape

    def objective(x: Array, index: np.ndarray) -> tuple[Array, Array]:
        settings = x.reshape(-1, *shape[1:])
        loss, gradient = problem.loss_and_gradient(settings)
        account.see(settings, loss)
        return loss, gradient.reshape(x.shape)

    def project(x: Array, allowed: Array) -> Array:
        settings, others = x.reshape(-1, *shape[1:]), allowed.reshape(-1, *shape[1:])
        return problem.restrictions.project(settings, others).reshape(x.shape)

    minima = minimize_stack(
        objective,
        starts.reshape(len(starts), -1),
        lower,
        upper,
        tolerance=tolerance,
        iterations=iterations,
        project=project if problem.restrictions.active else None,
    )
    return Descent(minima.x.reshape(shape), minima.loss, minima.converged)


class _Held:
    """Rounds of smooth minimization with ceilings held by multipliers."""

    def __init__(self, problem: Landscape, starts: Array, lower: Array, upper: Array, account: Account) -> None:
        self.problem, self.account = problem, account
        self.terms = problem.objective.criterion.terms()
        self.ceilings: list[Ceiling] = [ceiling for _, ceiling in self.terms.ceilings]
        self.weights = np.array([weight for weight, _ in self.terms.ceilings])
        self.shape = starts.shape
        self.angles = starts[0].size
        floors = np.array([max(ceiling.log_floor, -_LOG_RANGE) for ceiling in self.ceilings])
        stack = (len(starts), len(floors))
        self.lower = np.concatenate([lower, np.broadcast_to(floors, stack)], axis=-1)
        self.upper = np.concatenate([upper, np.full(stack, _LOG_RANGE)], axis=-1)
        self.response = problem.objective.response
        information = self.response.information(starts)
        logs = [loss_of(ceiling, information) for ceiling in self.ceilings]
        self.x = np.concatenate([starts.reshape(len(starts), -1), np.stack(logs, axis=-1)], axis=-1)
        self.multipliers = [ceiling.start(information.parameters, (len(starts),)) for ceiling in self.ceilings]
        self.penalty = np.full(len(starts), _FIRST_PENALTY)
        self.curvature = curvature(*self.x.shape)  # what one round learns helps the next
        self.best = starts.copy()
        self.loss = problem.loss(starts)
        account.see(starts, self.loss)
        self.converged = np.zeros(len(starts), dtype=bool)

    def run(self, tolerance: float, iterations: int) -> Descent:
        going = np.flatnonzero(np.isfinite(self.loss))
        gap = np.full(len(self.loss), np.inf)
        previous = np.full(len(self.loss), np.inf)
        for _ in range(_ROUNDS):
            if not len(going):
                break
            self._round(going, tolerance, iterations)
            settings = self.x[going, : self.angles].reshape(-1, *self.shape[1:])
            at = self.response.at(settings)
            loss = loss_of(self.problem.objective.criterion, at.information)
            with np.errstate(invalid="ignore", over="ignore"):  # a run may have crept up to a singular program
                lagrangian = self._value_and_update(at.information, going)
                new_gap = np.abs(loss - lagrangian)
                settled = (new_gap < 10 * tolerance) & (np.abs(loss - previous[going]) < tolerance)
            self.account.keep(settings, loss)
            better = loss < self.loss[going]
            self.best[going[better]] = settings[better]
            self.loss[going[better]] = loss[better]
            slow = new_gap > 0.25 * gap[going]
            self.penalty[going[slow]] = np.minimum(self.penalty[going[slow]] * _GROWTH, _LARGEST_PENALTY)
            gap[going], previous[going] = new_gap, loss
            self.converged[going[settled]] = True
            going = going[~settled & np.isfinite(loss)]
        return Descent(self.best, self.loss, self.converged, tuple(self.multipliers))

    def _round(self, going: np.ndarray, tolerance: float, iterations: int) -> None:
        """Minimize the Lagrangian for fixed multipliers."""

        def objective(x: Array, index: np.ndarray) -> tuple[Array, Array]:
            settings = x[:, : self.angles].reshape(-1, *self.shape[1:])
            at = self.response.at(settings)
            self.account.evaluations += len(x)
            log_t = x[:, self.angles :]
            value = log_t @ self.weights
            slopes = np.broadcast_to(self.weights, log_t.shape).copy()
            gradient = np.zeros(at.information.matrix.shape)
            for weight, criterion in self.terms.smooth:
                value = value + weight * loss_of(criterion, at.information)
                gradient = gradient + weight * gradient_of(criterion, at.information)
            members = going[index]
            singular = at.information.singular
            if self.problem.restrictions.active:
                singular = singular | ~self.problem.restrictions.permits(settings)
            with np.errstate(invalid="ignore", over="ignore"):
                for k, ceiling in enumerate(self.ceilings):
                    more, by_matrix, slope, _ = ceiling.hold(
                        at.information, log_t[:, k], self.multipliers[k][members], self.penalty[members]
                    )
                    value, gradient = value + more, gradient + by_matrix
                    slopes[:, k] += slope
            value = np.where(singular, np.inf, value)
            gradient = np.where(singular[:, None, None], 0.0, gradient)
            by_angle = at.pull(gradient).reshape(len(x), -1)
            return value, np.concatenate([by_angle, slopes], axis=-1)

        def project(x: Array, allowed: Array) -> Array:
            x = x.copy()
            settings, others = (part[:, : self.angles].reshape(-1, *self.shape[1:]) for part in (x, allowed))
            x[:, : self.angles] = self.problem.restrictions.project(settings, others).reshape(len(x), -1)
            return x

        known = self.curvature.take(going)
        minima = minimize_stack(
            objective,
            self.x[going],
            self.lower[going],
            self.upper[going],
            tolerance=tolerance,
            iterations=iterations,
            project=project if self.problem.restrictions.active else None,
            known=known,
        )
        self.curvature.put(going, known)
        self.x[going] = minima.x

    def _value_and_update(self, information: Information, going: np.ndarray) -> Array:
        """The loss with log t in the place of the maxima; moves the multipliers on."""
        log_t = self.x[going, self.angles :]
        value = log_t @ self.weights
        for weight, criterion in self.terms.smooth:
            value = value + weight * loss_of(criterion, information)
        for k, ceiling in enumerate(self.ceilings):
            *_, following = ceiling.hold(information, log_t[:, k], self.multipliers[k][going], self.penalty[going])
            self.multipliers[k][going] = following
        return np.asarray(value)
