"""Programs rounded from an approximate design, from which descents begin."""

from __future__ import annotations

import numpy as np

from acalx.numerics.arrays import Array
from acalx.problem import Problem
from acalx.search.result import ApproximateDesign
from acalx.weights import efficient_rounding, random_roundings

__all__ = ["roundings"]

# So many random roundings are looked at for each one that is taken.
_DRAWS = 8
# and its angles are moved by so much, in rad, as a standard deviation.
_SHAKE = 0.1


def roundings(problem: Problem, design: ApproximateDesign, rng: np.random.Generator, count: int) -> Array:
    """So many programs (s, n, d) near a design: the efficient rounding first, then the best of many random ones.

    The angles of all but the first are moved a little. Where fewer positions than support points
    make some of them singular, random programs take their places.
    """
    settings, weights = design.merged()
    free = problem.n - problem.held
    efficient = efficient_rounding(weights, free)
    drawn = random_roundings(rng, weights, free, _DRAWS * count)
    numbers = np.arange(len(weights))
    programs = settings[[np.repeat(numbers, counts) for counts in (efficient, *drawn)]]
    programs = problem.restrictions.apart(problem.restrictions.completed(programs), rng)
    order = np.argsort(problem.loss(programs[1:]), kind="stable") + 1
    programs = programs[np.concatenate([[0], order])[:count]]
    programs[1:] = _shaken(problem, rng, programs[1:])
    # with fewer positions than points some roundings can't estimate all the parameters
    singular = ~np.isfinite(problem.loss(programs))
    programs[singular] = problem.restrictions.random(rng, int(singular.sum()))
    return np.asarray(programs)


def _shaken(problem: Problem, rng: np.random.Generator, programs: Array) -> Array:
    """Angles moved a little: on the symmetric points of a design a descent can end on a saddle."""
    lower, upper = problem.restrictions.limits_around(programs)
    moved = programs + rng.normal(0.0, _SHAKE, programs.shape)
    moved = np.clip(moved, lower.reshape(programs.shape), upper.reshape(programs.shape))
    return problem.restrictions.project(moved, programs)
