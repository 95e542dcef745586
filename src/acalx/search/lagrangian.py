"""The one augmented Lagrangian, by which ceilings of criteria and goals of losses are held.

A criterion with ceilings (see `acalx.criteria.Ceiling`) has kinks just at its minima; there log t
of each ceiling joins the variables and is held above what it is the maximum of. Goals (see
`acalx.search.aims`) bring one more variable, by how much they are exceeded. What is minimized for
given multipliers is smooth.

Source: Bertsekas, Constrained Optimization and Lagrange Multiplier Methods (1982), chapter 2;
for the matrix inequality of E: Kocvara and Stingl, Optim. Methods Softw. 18 (2003) 317.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from acalx.criteria import Ceiling
from acalx.criteria.answers import gradient_of, loss_of
from acalx.numerics.arrays import Array
from acalx.problem import Objective
from acalx.quantities.information import Information
from acalx.search.aims import Aims
from acalx.search.landscape import Bounds

__all__ = ["Lagrangian", "Multipliers"]

# Limits of log t, far outside any loss that occurs, so that no step overflows.
_LOG_RANGE = 60.0
_FIRST_PENALTY = 10.0
_LARGEST_PENALTY = 1e6
_GROWTH = 10.0


@dataclass
class Multipliers:
    """What holds ceilings and goals of s runs.

    Parameters
    ----------
    ceilings : list of arrays (s, ...)
        Multipliers, one array a ceiling.
    goals : array (s, k)
        Multipliers of the goals of the k losses; no columns where no run has goals.
    penalty : array (s,)
        Of the ceilings.
    """

    ceilings: list[Array]
    goals: Array
    penalty: Array

    def select(self, index: np.ndarray) -> Self:
        """Those of some of the runs."""
        ceilings = [multiplier[index] for multiplier in self.ceilings]
        return type(self)(ceilings, self.goals[index], self.penalty[index])

    def put(self, index: np.ndarray, source: Self) -> None:
        """Bring those of some of the runs up to date."""
        for multiplier, new in zip(self.ceilings, source.ceilings, strict=True):
            multiplier[index] = new
        self.goals[index], self.penalty[index] = source.goals, source.penalty

    def stiffen(self, index: np.ndarray) -> None:
        """Larger penalties for some of the runs."""
        self.penalty[index] = np.minimum(self.penalty[index] * _GROWTH, _LARGEST_PENALTY)

    def loosen(self) -> None:
        """The first penalties again."""
        self.penalty[:] = _FIRST_PENALTY


class Lagrangian:
    """What is minimized over angles, log t of each ceiling and, where there are goals, their excess.

    Variables (s, v) are laid out in this order.

    Parameters
    ----------
    objectives : sequence of Objective
        One criterion or k of them, of the same response.
    restrictions : Bounds
    shape : (n, d)
        Of a program.
    """

    def __init__(self, objectives: Sequence[Objective], restrictions: Bounds, shape: tuple[int, int]) -> None:
        self.objectives, self.restrictions, self.shape = objectives, restrictions, shape
        self.response = objectives[0].response
        self.angles = shape[0] * shape[1]
        terms = [objective.criterion.terms() for objective in objectives]
        self.ceilings: list[Ceiling] = [ceiling for each in terms for _, ceiling in each.ceilings]
        self.smooth = [(k, weight, part) for k, each in enumerate(terms) for weight, part in each.smooth]
        owners = [(k, weight) for k, each in enumerate(terms) for weight, _ in each.ceilings]
        # how much of each ceiling is in each loss, (k, c)
        self.shares = np.array([[weight * (k == owner) for owner, weight in owners] for k in range(len(terms))])

    def begin(self, starts: Array, aims: Aims) -> tuple[Array, Multipliers]:
        """Variables (s, v) at programs (s, n, d), and multipliers that hold nothing yet."""
        information = self.response.information(starts)
        s, k = len(starts), len(self.objectives)
        columns = [starts.reshape(s, -1), *(loss_of(ceiling, information)[:, None] for ceiling in self.ceilings)]
        goals = np.empty((s, 0))
        if aims.goals is not None:
            columns.append(np.zeros((s, 1)))
            goals = np.where(aims.goals.sought[:, None], np.full((1, k), 1.0 / k), 0.0)
        ceilings = [ceiling.start(information.parameters, (s,)) for ceiling in self.ceilings]
        return np.concatenate(columns, axis=-1), Multipliers(ceilings, goals, np.full(s, _FIRST_PENALTY))

    def limits(self, lower: Array, upper: Array, aims: Aims) -> tuple[Array, Array]:
        """Limits (s, v) of the variables, from those of the angles (s, n d)."""
        excess = [] if aims.goals is None else [np.inf]
        floors = np.array([*(max(ceiling.log_floor, -_LOG_RANGE) for ceiling in self.ceilings), *(-e for e in excess)])
        tops = np.array([_LOG_RANGE] * len(self.ceilings) + excess)
        lower, upper = (
            np.concatenate([limit, np.broadcast_to(rest, (len(limit), len(rest)))], axis=-1)
            for limit, rest in ((lower, floors), (upper, tops))
        )
        return lower, upper

    def settings(self, x: Array) -> Array:
        """Programs (s, n, d) of variables (s, v)."""
        return np.asarray(x[:, : self.angles].reshape(-1, *self.shape))

    def sizes(self, count: int) -> Array:
        """What is about as much of each of so many variables, (count,)."""
        found = np.ones(count)
        found[: self.angles] = np.tile(self.restrictions.sizes, self.shape[0])
        return found

    def _log_t(self, x: Array) -> Array:
        return x[:, self.angles : self.angles + len(self.ceilings)]

    def project(self, x: Array, allowed: Array) -> Array:
        """Variables (s, v) with their programs moved back to where the restrictions permit them."""
        x = x.copy()
        moved = self.restrictions.project(self.settings(x), self.settings(allowed))
        x[:, : self.angles] = moved.reshape(len(x), -1)
        return x

    def losses(self, information: Information) -> Array:
        """Losses (s, k) by each criterion."""
        return np.stack([loss_of(objective.criterion, information) for objective in self.objectives], axis=-1)

    def _smoothed(self, information: Information, log_t: Array) -> Array:
        """Losses (s, k) with log t in the place of the maxima."""
        losses: Array = log_t @ self.shares.T
        for k, weight, criterion in self.smooth:
            losses[:, k] += weight * loss_of(criterion, information)
        return losses

    def value_and_gradient(self, x: Array, aims: Aims, held: Multipliers) -> tuple[Array, Array]:
        """Value (s,) and gradient (s, v) for given multipliers; +inf where singular or not permitted."""
        settings, log_t = self.settings(x), self._log_t(x)
        at = self.response.at(settings)
        with np.errstate(invalid="ignore", over="ignore"):  # a run may creep up to a singular program
            losses = self._smoothed(at.information, log_t)
            value, slopes, by_excess = _weighed(losses, x[:, -1], aims, held)
            gradient = np.zeros(at.information.matrix.shape)
            for k, weight, criterion in self.smooth:
                gradient += weight * slopes[:, k, None, None] * gradient_of(criterion, at.information)
            by_log = slopes @ self.shares
            for k, ceiling in enumerate(self.ceilings):
                more, by_matrix, slope, _ = ceiling.hold(at.information, log_t[:, k], held.ceilings[k], held.penalty)
                value, gradient = value + more, gradient + by_matrix
                by_log[:, k] += slope
        barred = at.information.singular
        if self.restrictions.active:
            barred = barred | ~self.restrictions.permits(settings)
        value = np.where(barred, np.inf, value)
        gradient = np.where(barred[:, None, None], 0.0, gradient)
        return value, np.concatenate([at.pull(gradient).reshape(len(x), -1), by_log, *by_excess], axis=-1)

    def update(
        self, x: Array, information: Information, aims: Aims, held: Multipliers
    ) -> tuple[Multipliers, Array, Array]:
        """The next multipliers; by how much goals are missed, (s,); and losses (s, k) as the variables have them."""
        log_t, goals, miss = self._log_t(x), held.goals, np.zeros(len(x))
        with np.errstate(invalid="ignore", over="ignore"):
            smoothed = self._smoothed(information, log_t)
            if aims.goals is not None:
                exceeded = aims.goals.exceeded(smoothed) - x[:, -1:]
                slack = np.maximum(exceeded, -held.goals / aims.goals.penalty)
                miss = np.where(aims.goals.sought, np.abs(np.nan_to_num(slack)).max(axis=-1), 0.0)
                goals = np.maximum(held.goals + aims.goals.penalty * exceeded, 0.0)
            ceilings = [
                ceiling.hold(information, log_t[:, k], held.ceilings[k], held.penalty)[-1]
                for k, ceiling in enumerate(self.ceilings)
            ]
        return Multipliers(ceilings, goals, held.penalty), miss, smoothed


def _weighed(losses: Array, excess: Array, aims: Aims, held: Multipliers) -> tuple[Array, Array, list[Array]]:
    """What aims make of losses (s, k): value (s,), slopes by the losses (s, k), with goals by the excess (s, 1) too."""
    value = (aims.weights * losses).sum(axis=-1)
    goals = aims.goals
    if goals is None:
        return value, aims.weights, []
    sought, penalty = goals.sought, goals.penalty
    following = np.maximum(held.goals + penalty * (goals.exceeded(losses) - excess[:, None]), 0.0)
    value = excess * sought + value
    value += (following**2 - held.goals**2).sum(axis=-1) / (2.0 * penalty)
    by_excess = sought - following.sum(axis=-1)
    return value, aims.weights + following / goals.rates, [by_excess[:, None]]
