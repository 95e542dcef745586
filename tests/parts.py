"""The parts that acalx ships, in every variety; each invariant runs over these lists."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import hydra
import numpy as np
from omegaconf import OmegaConf

from acalx.criteria import A, Criterion, D, E, Inequality, Product, Target
from acalx.errors import CompatibilityError
from acalx.models import Model, Platform, ScalarAccel, as_model
from acalx.numerics.arrays import Array
from acalx.optimizers import DifferentialEvolution, Exchange, Gradient, Optimizer
from acalx.problem import Problem
from acalx.sensors import PlatformAccel, PlatformGyro
from acalx.stands import Chamber, PlatformGimbals, RateTable, Stand, Turntable, TwoAxis, TwoAxisRateTable

GROUPS = ("bias", "scale", "nonorthogonality")

D_FAIR = Product([D(), *(Inequality(group) for group in GROUPS)], [1.0, 0.1, 0.1, 0.1])

# Criteria for which one more position never hurts, and those for which it may.
MONOTONE: list[Criterion] = [D(), A(), E(), A() * E() ** 0.5, Product([D(), A(), E()], [1.0, 2.0, 0.3])]
MONOTONE += [Target({"bias": 0.5, "nonorthogonality": 1.3}), Target({"scale": 2.0})]
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

GIMBALS = PlatformGimbals()
RATE_TABLE = RateTable()
# Stands that provide more than gravity.
FURTHER_STANDS: list[Stand] = [
    TwoAxis(dip_deg=65, field_azimuth_deg=30),
    TwoAxis(alpha1_deg=(-60, 60), dip_deg=-20),
    GIMBALS,
    PlatformGimbals(azimuth_deg=30, latitude_deg=-60),
    PlatformGimbals(gamma_deg=(-90, 90), alpha_deg=(10, 200)),
    PlatformGimbals(step_deg=45),
    RATE_TABLE,
    RateTable(rate_deg_s=(-20, 90), alpha1_deg=(-30, 40)),
    RateTable(rate_step_deg_s=10, step_deg=30),
    TwoAxisRateTable(),
    TwoAxisRateTable(averaging_s=0, outer_deg=(-30, 40), latitude_deg=-10),
    Chamber(),
    Chamber(temperature_degC=(0, 30), temperature_step_degC=10, step_deg=30),
    Turntable(turn_deg=(-90, 720), latitude_deg=50),
]

# Every option of the group, so that a new YAML is enough to be here, and varieties of them.
MODELS: list[Model] = [
    as_model(hydra.utils.instantiate(OmegaConf.load(path), _convert_="all"))
    for path in sorted(Path(str(files("acalx.conf"))).glob("model/*.yaml"))
    if path.stem != "custom"
]
MODELS.sort(key=lambda model: model != ScalarAccel())  # which comes first
MODELS += [
    ScalarAccel(groups=("bias", "scale")),
    as_model(PlatformGyro("y", ("IS", "OS"), noise_deg_h=0.001)),
    as_model(PlatformGyro("z", ("II", "SS"))),
    as_model(PlatformAccel("z", noise_g=1e-7)),
    Platform(sensors=["accels"], accel_noise_g=[1.0, 2.0, 3.0]),
]


def fits(model: Model, stand: Stand) -> bool:
    try:
        model.check(stand.stimulus(stand.axes.bounds[:, 0][None, :]), stand)
    except CompatibilityError:
        return False
    return True


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
