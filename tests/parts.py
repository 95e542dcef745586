"""The parts that acalx ships, in every variety; each invariant runs over these lists."""

from __future__ import annotations

import numpy as np

from acalx.arrays import Array
from acalx.criteria import A, Criterion, D, E, Inequality, Product
from acalx.models import Model, ScalarAccel
from acalx.optimizers import DifferentialEvolution, Exchange, Gradient, Optimizer
from acalx.problem import Problem
from acalx.stands import Stand, TwoAxis

GROUPS = ("bias", "scale", "nonorthogonality")

D_FAIR = Product([D(), *(Inequality(group) for group in GROUPS)], [1.0, 0.1, 0.1, 0.1])

# Criteria for which one more position never hurts, and those for which it may.
MONOTONE: list[Criterion] = [D(), A(), E(), A() * E() ** 0.5, Product([D(), A(), E()], [1.0, 2.0, 0.3])]
OTHERS: list[Criterion] = [*(Inequality(group) for group in GROUPS), Inequality("bias", floor=0.2), D_FAIR]
CRITERIA = MONOTONE + OTHERS

FULL = TwoAxis()
BAND = TwoAxis(alpha2_deg=(-45, 45))
PATCH = TwoAxis(alpha1_deg=(-60, 100), alpha2_deg=(-40, 50))
UNWRAPPED = TwoAxis(alpha1_deg=(-180, 540), alpha2_deg=(0, 360), periodic=False)
CONTINUOUS: list[Stand] = [FULL, BAND, PATCH, UNWRAPPED]

TABLE_15 = TwoAxis(step_deg=15)
STEPPED: list[Stand] = [
    TABLE_15,
    TwoAxis(step_deg=7),
    TwoAxis(alpha1_deg=(-50, 100), alpha2_deg=(10, 300), step_deg=30),
    TwoAxis(alpha1_deg=(0, 540), step_deg=45, periodic=False),
]
STANDS = CONTINUOUS + STEPPED

MODELS: list[Model] = [ScalarAccel(), ScalarAccel(groups=("bias", "scale"))]

OPTIMIZERS: list[Optimizer] = [Gradient(), DifferentialEvolution(), Exchange()]


def problem(criterion: Criterion | None = None, n: int = 9, stand: Stand = FULL) -> Problem:
    return Problem(stand, ScalarAccel(), criterion or D(), n)


def program(directions: object, stand: Stand = FULL) -> Array:
    """Settings (n, d) for directions of the vertical (n, 3) of any length."""
    vectors = np.asarray(directions, dtype=float)
    return stand.aim(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def icosahedron() -> Array:
    golden = (1 + 5**0.5) / 2
    corners = [(0.0, s, t * golden) for s in (-1, 1) for t in (-1, 1)]
    return np.array([np.roll(corner, k) for corner in corners for k in range(3)])


FACES = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)])
EDGES = np.array([(x, y, 0) for x in (-1, 1) for y in (-1, 1)])
EDGES = np.concatenate([np.roll(EDGES, k, axis=1) for k in range(3)])
