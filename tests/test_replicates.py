"""Positions are replicates of each other by what the sensor feels, whatever the units and sizes of the quantities."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from acalx.criteria import D
from acalx.models import GyroTurns, Model, ScalarAccel, as_model
from acalx.models.gyro_rate_table import GyroRateTable
from acalx.numerics.arrays import Array
from acalx.optimizers import Gradient
from acalx.problem import Problem
from acalx.sensors import IMU, AccelTemperature
from acalx.stands import Chamber, RateTable, Stand, Turntable, TwoAxis, TwoAxisRateTable

HERE = [30.0, 50.0]
CASES: list[tuple[Stand, Any, list[float], list[float], bool]] = [
    # position, what is added to it, whether it is the same one then; in the units of files
    (Chamber(), AccelTemperature(), [*HERE, 20.0], [0, 0, 0.1], True),
    (Chamber(), AccelTemperature(), [*HERE, 20.0], [0, 0, 1.0], True),
    (Chamber(), AccelTemperature(), [*HERE, 20.0], [0, 0, 5.0], False),
    (Chamber(), AccelTemperature(), [*HERE, 20.0], [2.0, 0, 0], False),
    (Chamber(temperature_degC=(20, 25)), AccelTemperature(), [*HERE, 20.0], [0, 0, 0.05], True),
    (Chamber(temperature_degC=(20, 25)), AccelTemperature(), [*HERE, 20.0], [0, 0, 1.0], False),
    (RateTable(), GyroRateTable(), [*HERE, 20.0], [0, 0, 0.1], True),
    (RateTable(), GyroRateTable(), [*HERE, 20.0], [0, 0, 2.0], False),
    (RateTable(), GyroRateTable(), [*HERE, 20.0], [2.0, 0, 0], False),
    (Turntable(), GyroTurns(), [180.0, *HERE], [0.01, 0, 0], True),
    (Turntable(), GyroTurns(), [180.0, *HERE], [20.0, 0, 0], False),
    (TwoAxisRateTable(), IMU(), [*HERE, 20.0, 30.0], [0, 0, 0.01, 0], True),
    (TwoAxisRateTable(), IMU(), [*HERE, 20.0, 30.0], [0, 0, 10.0, 0], False),
    (TwoAxisRateTable(averaging_s=0.1), IMU(), [*HERE, 0.0, 0.0], [0.5, 0, 0, 0], True),
    (TwoAxisRateTable(averaging_s=10), IMU(), [*HERE, 0.0, 0.0], [0.5, 0, 0, 0], True),
    (TwoAxisRateTable(averaging_s=10), IMU(), [*HERE, 0.0, 0.0], [2.0, 0, 0, 0], False),
    (TwoAxis(), ScalarAccel(), HERE, [0.99, 0.0], True),
    (TwoAxis(), ScalarAccel(), HERE, [1.01, 0.0], False),
    (TwoAxis(alpha1_deg=(20, 40), alpha2_deg=(40, 60)), ScalarAccel(), HERE, [0.99, 0.0], True),
    (TwoAxis(alpha1_deg=(20, 40), alpha2_deg=(40, 60)), ScalarAccel(), HERE, [1.01, 0.0], False),
]


def problem_of(stand: Stand, sensor: Any, n: int = 30) -> Problem:
    model: Model = as_model(sensor)
    return Problem(stand, model, D(), n, replicates=False)


@pytest.mark.parametrize(("stand", "sensor", "here", "more", "same"), CASES, ids=str)
def test_a_degree_in_what_is_felt(stand: Stand, sensor: Any, here: Array, more: Array, same: bool) -> None:
    both = stand.axes.read(np.array([here, np.add(here, more)]))
    found = problem_of(stand, sensor).restrictions.alike(both, both)
    assert found.tolist() == [[True, same], [same, True]]


@pytest.mark.parametrize(
    "stand", [RateTable(rate_step_deg_s=10, step_deg=30), Chamber(temperature_step_degC=5, step_deg=30)]
)
def test_stops_of_a_stand_with_steps_differ(stand: Stand) -> None:
    restrictions = problem_of(stand, AccelTemperature() if isinstance(stand, Chamber) else GyroRateTable()).restrictions
    stops = [setting.stops()[:2] for setting in stand.settings]
    further = np.array([[s[0] for s in stops[:-1]] + [stops[-1][k]] for k in range(2)])
    assert not restrictions.alike(further[:1], further[1:]).any()


def test_what_no_stand_tells_and_is_zero_then_does_not_count() -> None:
    problem = problem_of(RateTable(), IMU(arms=()))
    programs = problem.restrictions.random(np.random.default_rng(0), 2)
    assert programs.shape == (2, problem.n, 3)
    assert np.isfinite(problem.loss(programs)).all()
    same = problem.restrictions.alike(programs[0], programs[0])
    np.testing.assert_array_equal(same, np.eye(problem.n, dtype=bool))


def test_a_design_on_a_rate_table_has_positions_that_differ() -> None:
    problem = problem_of(RateTable(), GyroRateTable(), 14)
    best = Gradient(starts=8).solve(problem, np.random.default_rng(0)).best.settings
    near = problem.restrictions.alike(best, best)
    np.fill_diagonal(near, val=False)
    assert not near.any()
