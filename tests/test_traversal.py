from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest

from acalx.criteria import A, D, Inequality
from acalx.criteria.answers import loss_of
from acalx.errors import AcalxError, ArgumentError, CompatibilityError
from acalx.models import GyroRateTable, Platform, ScalarAccel
from acalx.optimizers import Traversal
from acalx.problem import Problem
from acalx.programs import find_program
from acalx.programs.sequences import regular_sequences
from acalx.quantities.information import Information
from acalx.search.result import Result
from acalx.sensors import PlatformGyro
from acalx.stands import PlatformGimbals, RateTable, TwoAxis
from acalx.testing import check_optimizer

GYROS = Platform(sensors=["gyros"])
GIMBALS = PlatformGimbals()


def solve(optimizer: Traversal, problem: Problem) -> Result:
    return optimizer.solve(problem, np.random.default_rng(0))


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        ("both", [(5, 5), (95, 50), (185, 95), (275, 140), (365, 185), (455, 230)]),
        ("turn", [(5, 5), (95, 5), (95, 50), (185, 50), (185, 95), (275, 95)]),
        ("raster", [(5, 5), (5, 50), (5, 95), (5, 140), (5, 185), (5, 230)]),
    ],
)
def test_rules(rule, expected):
    np.testing.assert_array_equal(regular_sequences(rule, np.array([5, 5]), np.array([90, 45]), 6), expected)


def test_raster_goes_on_to_the_next_line():
    lines = regular_sequences("raster", np.zeros(2), np.array([90.0, 120.0]), 13)
    np.testing.assert_array_equal(lines[:, 0], [0, 0, 0, 90, 90, 90, 180, 180, 180, 270, 270, 270, 0])
    np.testing.assert_array_equal(lines[:, 1], [0, 120, 240] * 4 + [0])


@pytest.mark.parametrize("problem", [Problem(GIMBALS, GYROS, D(), 16), Problem(TwoAxis(), ScalarAccel(), A(), 12)])
def test_contract(problem):
    check_optimizer(Traversal(), problem)


def test_the_landscape_is_that_of_every_sequence():
    problem = Problem(GIMBALS, PlatformGyro(), D(), 16)
    survey = solve(Traversal(), problem).survey
    assert survey.losses.shape == (144, 9)
    assert survey.numbers.tolist() == list(range(8, 17))
    assert survey.names == ("start_gamma_deg", "start_alpha_deg", "step_gamma_deg", "step_alpha_deg")
    assert set(survey.sequences[:, 0]) == set(range(0, 180, 5))
    np.testing.assert_array_equal(survey.sequences[:, 0], survey.sequences[:, 1])
    for row, column in [(0, 0), (7, 8), (50, 3), (143, 5)]:
        start, step = np.split(survey.sequences[row], 2)
        n = int(survey.numbers[column])
        angles = np.radians(regular_sequences("turn", start, step, n))
        matrix = problem.information(angles).matrix / n
        information = Information(matrix, problem.parameters)
        expected = np.inf if information.singular else -information.log_det
        assert survey.losses[row, column] == pytest.approx(float(expected), abs=1e-8)


@pytest.mark.parametrize("criterion", [D(), A(), A() * Inequality("gyro_first_order") ** 0.1])
def test_the_winner_is_the_best_per_measurement(criterion):
    problem = Problem(GIMBALS, GYROS, criterion, 16)
    result = solve(Traversal("raster"), problem)
    row, column = result.survey.best
    assert result.survey.losses[row, column] == pytest.approx(result.survey.losses.min(), abs=1e-9)
    n = len(result.best.settings)
    assert n == result.survey.numbers[column]
    matrix = problem.information(result.best.settings).matrix / n
    loss = float(loss_of(criterion, Information(matrix, problem.parameters)))
    assert loss == pytest.approx(result.survey.losses.min(), abs=1e-8)
    assert f"{n} positions" in result.message


@pytest.mark.parametrize(("rule", "name"), [("turn", "platform_turn_16"), ("raster", "platform_raster_16")])
def test_regular_programs_by_name_are_the_winners(rule, name):
    problem = Problem(GIMBALS, Platform(), D(), 16)
    named = problem.loss(find_program(name).settings_for(GIMBALS))
    assert solve(Traversal(rule), problem).best.loss == pytest.approx(float(named), abs=1e-9)


def test_fewer_positions_may_win_and_the_shortest_of_equals_counts():
    """One round of 8 positions is as good per measurement as two."""
    problem = Problem(GIMBALS, Platform(sensors=["accels"]), D(), 16)
    survey = solve(Traversal("both", steps_deg=[45.0], n_from=8), problem).survey
    np.testing.assert_allclose(survey.losses[:, 0], survey.losses[:, -1], atol=1e-9)
    ends = replace(survey, numbers=survey.numbers[[0, -1]], losses=survey.losses[:, [0, -1]])
    assert ends.best[1] == 0
    assert len(solve(Traversal(), problem).best.settings) == 15


def test_the_gyros_take_less_than_a_second():
    problem = Problem(GIMBALS, GYROS, D(), 16)
    solve(Traversal(), problem)
    started = time.perf_counter()
    result = solve(Traversal(), problem)
    assert time.perf_counter() - started < 1.0
    assert result.evaluations == 144 * 9


def test_finer_and_independent_sequences_are_no_worse():
    problem = Problem(GIMBALS, PlatformGyro(), D(), 10)
    plain = solve(Traversal(), problem).survey.losses.min()
    finer = solve(Traversal(starts_deg=[0, 360, 15], independent_starts=True, steps_deg=[30, 45, 90]), problem)
    assert finer.survey.losses.shape == (24 * 24 * 9, 3)
    assert finer.survey.losses.min() <= plain


def test_limits_of_the_stand_leave_sequences_out():
    stand = PlatformGimbals(gamma_deg=(0, 200), alpha_deg=(0, 200))
    result = solve(Traversal(), Problem(stand, Platform(sensors=["accels"]), D(), 8))
    assert stand.axes.allows(result.best.settings).all()
    assert np.isinf(result.survey.losses).any()
    narrow = PlatformGimbals(gamma_deg=(0, 60))
    with pytest.raises(AcalxError, match=r"leave the limits or stops of the stand, gamma_deg=\[0, 60\], .*steps_deg"):
        solve(Traversal(), Problem(narrow, PlatformGyro(), D(), 16))


@pytest.mark.parametrize("model", [PlatformGyro(), GYROS])
def test_a_rule_that_comes_back_to_the_same_attitude_is_told_with_the_remedy(model):
    with pytest.raises(AcalxError) as caught:
        solve(Traversal("both", steps_deg=[90.0]), Problem(GIMBALS, model, D(), 16))
    for part in ("rule=both", "the same attitude after 4 positions", "gyro_x", "choose rule='turn' or rule='raster'"):
        assert part in str(caught.value)


def test_what_does_not_fit_is_refused():
    with pytest.raises(CompatibilityError, match="Traversal steps angles, but stand RateTable also sets rate_deg_s"):
        solve(Traversal(), Problem(RateTable(), GyroRateTable(), D(), 10))
    for n_from in (7, 17):
        with pytest.raises(ArgumentError, match=rf"n_from={n_from}: must be from 8, .* PlatformGyro need, to n=16"):
            solve(Traversal(n_from=n_from), Problem(GIMBALS, PlatformGyro(), D(), 16))
    fine = Traversal(starts_deg=[0, 180, 0.1], independent_starts=True)
    with pytest.raises(ArgumentError, match=r"12,960,000 sequences are too many.*wider steps"):
        solve(fine, Problem(GIMBALS, PlatformGyro(), D(), 16))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"rule": "spiral"}, "rule='spiral': there is no such rule; the rules are both, turn, raster"),
        ({"starts_deg": [0, 180]}, r"give from, up to and step, as in starts_deg=\[0, 180, 5\]"),
        ({"starts_deg": [180, 0, 5]}, "give from, up to and step"),
        ({"starts_deg": 5}, "starts_deg=5: give a list of degrees"),
        ({"steps_deg": []}, r"steps_deg=\[\]: give a list"),
        ({"steps_deg": [45, 0]}, "none of them 0"),
        ({"steps_deg": [45, 45]}, "different steps"),
        ({"steps_deg": [45, "x"]}, "steps_deg: x is not a finite number"),
        ({"independent_starts": 1}, "independent_starts=1: must be true or false"),
        ({"n_from": 8.5}, "n_from=8.5: must be a whole number"),
    ],
)
def test_bad_options(arguments, message):
    with pytest.raises(ArgumentError, match=message):
        Traversal(**arguments)
