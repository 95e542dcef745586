"""Descent from many starts at once to local minima of a problem, kinks included.

A smooth criterion is minimized as it is; one with ceilings, which has kinks just at its minima,
in rounds of smooth minimization (see `acalx.search.runs`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from acalx.numerics.arrays import Array
from acalx.numerics.bfgs import minimize_stack
from acalx.search.account import Account
from acalx.search.aims import Aims
from acalx.search.lagrangian import Lagrangian
from acalx.search.landscape import Landscape
from acalx.search.runs import Runs

__all__ = ["Descent", "descend"]


@dataclass(frozen=True, eq=False)
class Descent:
    """Local minima that starts led to.

    Parameters
    ----------
    settings : array (s, n, d), in rad
    loss : array (s,)
    converged : array (s,) of bool
    """

    settings: Array
    loss: Array
    converged: np.ndarray


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
        return _held(problem, starts, (lower, upper), account, tolerance, iterations)
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
        sizes=np.tile(problem.restrictions.sizes, shape[1]),
    )
    return Descent(minima.x.reshape(shape), minima.loss, minima.converged)


def _held(
    problem: Landscape,
    starts: Array,
    limits: tuple[Array, Array],
    account: Account,
    tolerance: float,
    iterations: int,
) -> Descent:
    """Local minima of a criterion with ceilings."""
    lagrangian = Lagrangian((problem.objective,), problem.restrictions, (starts.shape[1], starts.shape[2]))
    runs = Runs(lagrangian, Aims(np.ones((len(starts), 1))), account, starts, limits)
    account.see(starts, runs.merit)
    runs.descend(tolerance, iterations)
    return Descent(runs.settings, runs.merit, runs.converged)
