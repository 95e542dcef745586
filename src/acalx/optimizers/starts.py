"""Programs at which searches begin."""

from __future__ import annotations

import numpy as np

from acalx.arrays import Array
from acalx.problem import Problem

__all__ = ["regular_starts"]


def regular_starts(problem: Problem, rng: np.random.Generator, count: int) -> Array:
    """Random programs, singular ones drawn again a few times."""
    programs = problem.random(rng, count)
    for _ in range(20):
        singular = ~np.isfinite(problem.loss(programs))
        if not singular.any():
            break
        programs[singular] = problem.random(rng, int(singular.sum()))
    return programs
