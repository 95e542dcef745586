"""Local minima of a problem on any stand: the polish that ends every search."""

from __future__ import annotations

import math

import numpy as np

from acalx.numerics.arrays import Array
from acalx.numerics.compass import creep
from acalx.problem import Problem
from acalx.search.account import Account
from acalx.search.descent import Descent, descend
from acalx.search.swaps import Candidates, candidates_of, descend_swaps

__all__ = ["settle"]

# Points of the grid that stands for settings without steps beside others that have them.
_GRID = 2000
# So many of the best programs creep along the edges of what is allowed, so many times.
_CREEPING = 4
_ROUNDS = 2
_RADIUS = math.radians(2.0)
_GAIN = 1e-9


def settle(
    problem: Problem,
    starts: Array,
    *,
    account: Account,
    tolerance: float = 1e-7,
    iterations: int = 2000,
    candidates: Candidates | None = None,
) -> Descent:
    """Local minima from starts (s, n, d) in rad; none ends above its start or where the stand can't be.

    Along gradients where angles can be set anywhere; by exchange where they stop at steps, and
    then along the gradients of the others, if there are any.
    """
    stepped = [setting.step is not None for setting in problem.stand.settings]
    if any(stepped):
        swapped = descend_swaps(problem, starts, candidates or candidates_of(problem, _GRID), account=account)
        if all(stepped):
            return swapped
        starts = swapped.settings
    descent = descend(problem, starts, account=account, tolerance=tolerance, iterations=iterations)
    if problem.replicates and all(zone.exact for zone in problem.stand.zones):
        return _around_boxes(problem, descent, account, tolerance, iterations)
    return _along_edges(problem, descent, account, tolerance, iterations)


def _around_boxes(problem: Problem, descent: Descent, account: Account, tolerance: float, iterations: int) -> Descent:
    """Descend again where the limits around the end are others than around the start: past a corner of a box."""
    for _ in range(_ROUNDS if problem.stand.zones else 0):
        again = descend(problem, descent.settings, account=account, tolerance=tolerance, iterations=iterations)
        lowered = bool((again.loss < descent.loss - _GAIN).any())
        descent = again
        if not lowered:
            break
    return descent


def _along_edges(problem: Problem, descent: Descent, account: Account, tolerance: float, iterations: int) -> Descent:
    """Let the positions of the best programs creep where gradients jam, one after another."""
    settings, losses = descent.settings.copy(), descent.loss.copy()
    best = np.argsort(losses)[:_CREEPING]
    best = best[np.isfinite(losses[best])]
    if not len(best):
        return descent
    for _ in range(_ROUNDS):
        before = losses[best].copy()
        for position in range(problem.held, problem.n):
            settings[best], losses[best] = _creep_one(problem, settings[best], losses[best], position)
        again = descend(problem, settings[best], account=account, tolerance=tolerance, iterations=iterations)
        settings[best], losses[best] = again.settings, again.loss
        account.see(settings[best], losses[best])
        if not (losses[best] < before - _GAIN).any():
            break
    return Descent(settings, losses, descent.converged)


def _creep_one(problem: Problem, settings: Array, losses: Array, position: int) -> tuple[Array, Array]:
    lower, upper = (
        limit.reshape(settings.shape)[:, position] for limit in problem.restrictions.limits_around(settings)
    )

    def function(points: Array, index: np.ndarray) -> Array:
        programs = np.repeat(settings[index][:, None], points.shape[1], axis=1)
        programs[:, :, position] = points
        return np.where(problem.restrictions.permits(programs, clearance=True), problem.loss(programs), np.inf)

    moved = settings.copy()
    moved[:, position], losses = creep(function, settings[:, position], losses, lower, upper, radius=_RADIUS)
    return moved, losses
