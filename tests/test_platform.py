"""Self-calibration of an inertial platform: stand, models, programs, and the figures of the study."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acalx.bounds import certify
from acalx.criteria import D
from acalx.errors import AcalxError, ArgumentError, CompatibilityError
from acalx.models import GyroRateTable, Joined, Model, Platform, ScalarAccel, as_model
from acalx.numerics.arrays import Array
from acalx.optimizers import Gradient
from acalx.planning.metrics import best_published, figures_of_merit
from acalx.problem import Problem
from acalx.programs import find_program
from acalx.quantities.information import Information
from acalx.sensors import PlatformAccel, PlatformGyro, Sensor
from acalx.stands import PlatformGimbals, RateTable, TwoAxis

EAST, NORTH = PlatformGimbals(), PlatformGimbals(azimuth_deg=0)
PAIRS = [("IS", "SS"), ("IS", "OS"), ("II", "SS")]
RIGHT_ANGLES = np.radians(list(itertools.product(range(0, 360, 90), repeat=2)))


def rotation(axis: int, angle: float) -> Array:
    """Of the axes by an angle about one of them."""
    c, s = math.cos(angle), math.sin(angle)
    matrix = np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
    return np.roll(matrix, (axis, axis), axis=(0, 1))


def log_det(model: Model | Sensor, stand: PlatformGimbals, angles: Array) -> float:
    return float(as_model(model).information(stand.stimulus(angles)).log_det)


def rank(model: Model | Sensor, stand: PlatformGimbals, angles: Array) -> int:
    return int(np.linalg.matrix_rank(as_model(model).regressors(stand.stimulus(angles))[:, 0, :], tol=1e-9))


# ---------------------------------------------------------------- the stand


@given(st.floats(-9, 9), st.floats(-9, 9), st.floats(-360, 360), st.floats(-90, 90))
def test_attitude_is_a_turn_about_the_outer_and_then_the_inner_axis(gamma, alpha, azimuth, latitude):
    stand = PlatformGimbals(azimuth_deg=azimuth, latitude_deg=latitude)
    stimulus = stand.stimulus(np.array([[gamma, alpha]]))
    psi, phi = math.radians(azimuth), math.radians(latitude)
    earth = np.array([0.0, math.cos(phi), math.sin(phi)])  # east, north, up
    # at gamma = alpha = 0 the x axis lies along the outer one, at an azimuth from north to the east
    attitude = rotation(2, alpha) @ rotation(0, gamma) @ rotation(2, math.pi / 2 - psi)
    np.testing.assert_allclose(stimulus["specific_force"][0], attitude @ [0, 0, 1], atol=1e-14)
    np.testing.assert_allclose(stimulus["angular_rate"][0], attitude @ earth, atol=1e-14)


def test_outer_axis_east_is_as_in_the_facts():
    g, a, phi = 0.7, 2.1, math.radians(34.25)
    sg, cg, sa, ca = math.sin(g), math.cos(g), math.sin(a), math.cos(a)
    matrix = np.array([[ca, sa * cg, sa * sg], [-sa, ca * cg, ca * sg], [0, -sg, cg]])
    stimulus = EAST.stimulus(np.array([[g, a]]))
    np.testing.assert_allclose(stimulus["specific_force"][0], matrix[:, 2], atol=1e-15)
    np.testing.assert_allclose(stimulus["angular_rate"][0], matrix @ [0, math.cos(phi), math.sin(phi)], atol=1e-15)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"latitude_deg": 91}, "latitude_deg=91: must be a number of degrees from -90 to 90"),
        ({"azimuth_deg": "east"}, "azimuth_deg='east': must be a number of degrees from -360 to 360"),
        ({"gamma_deg": (9, 1)}, r"gamma_deg=\[9, 1\]: the lower bound must be below"),
        ({"alpha_deg": 5}, "alpha_deg=5: give a lower and an upper limit in degrees"),
        ({"step_deg": 0}, "step_deg=0: a step must be a positive number of degrees"),
        ({"periodic": 1}, "periodic=1: must be true or false"),
    ],
)
def test_bad_gimbals(arguments, message):
    with pytest.raises(ArgumentError, match=message):
        PlatformGimbals(**arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"rate_deg_s": (5, 5)}, r"rate_deg_s=\[5, 5\]: the lower bound must be below"),
        ({"rate_deg_s": 5}, "rate_deg_s=5: give a lower and an upper limit in degrees per second"),
        ({"rate_step_deg_s": "x"}, "rate_step_deg_s='x': a step is a number of degrees per second"),
        ({"rate_deg_s": (1, 4), "rate_step_deg_s": 10}, r"holds no multiple of the step of 10 degrees per second"),
        ({"latitude_deg": math.nan}, "latitude_deg=nan: "),
    ],
)
def test_bad_rate_tables(arguments, message):
    with pytest.raises(ArgumentError, match=message):
        RateTable(**arguments)


# ---------------------------------------------------------------- the models


@given(st.integers(0, 2**32 - 1), st.sampled_from(PAIRS), st.sampled_from([1, 7, 40]))
@settings(max_examples=40)
def test_information_of_the_platform_is_that_of_its_sensors(seed, pair, stack):
    rng = np.random.default_rng(seed)
    noise = rng.uniform(0.1, 10.0, 6)
    platform = Platform(second_order=pair, gyro_noise_deg_h=list(noise[:3]), accel_noise_g=list(noise[3:]))
    singles: list[Model] = [as_model(PlatformGyro(axis, pair, noise[k])) for k, axis in enumerate("xyz")]
    singles += [as_model(PlatformAccel(axis, noise[3 + k])) for k, axis in enumerate("xyz")]
    stimulus = EAST.stimulus(EAST.axes.random(rng, (stack, 9)))
    whole = platform.information(stimulus)
    blocks = np.zeros((stack, 36, 36))
    first = 0
    for model in singles:
        last = first + len(model.parameters)
        blocks[:, first:last, first:last] = model.information(stimulus).matrix
        first = last
    np.testing.assert_allclose(whole.matrix, blocks, rtol=1e-12, atol=1e-12)
    rows = Information.from_regressors(platform.regressors(stimulus), platform.parameters)
    np.testing.assert_allclose(rows.matrix, blocks, rtol=1e-12, atol=1e-10)
    total = sum(model.information(stimulus).log_det for model in singles)
    finite = np.isfinite(total)
    np.testing.assert_allclose(whole.log_det[finite], total[finite], rtol=1e-9)
    joined = Joined(singles)
    np.testing.assert_array_equal(joined.information(stimulus).matrix, whole.matrix)
    assert joined.parameters == platform.parameters


def test_groups_and_smallest_numbers():
    platform = Platform()
    sizes = {group: len(members) for group, members in platform.information(EAST.stimulus(RIGHT_ANGLES)).groups.items()}
    assert sizes == {
        "gyro_bias": 3,
        "gyro_first_order": 9,
        "gyro_second_order": 6,
        "gyro_misalignment": 6,
        "accel_bias": 3,
        "accel_scale": 3,
        "accel_misalignment": 6,
    }
    assert (platform.outputs, platform.smallest_n, platform.degree) == (6, 8, 2)
    assert (as_model(PlatformGyro()).smallest_n, as_model(PlatformAccel()).smallest_n) == (8, 4)
    with pytest.raises(ArgumentError, match="n=7: the 36 parameters of Platform need 8 positions or more"):
        Problem(EAST, platform, D(), 7)
    with pytest.raises(CompatibilityError, match="model Platform needs the angular rate, which stand TwoAxis does not"):
        Problem(TwoAxis(), platform, D(), 9)


def test_a_group_of_one_has_no_inequality():
    information = as_model(PlatformGyro()).information(EAST.stimulus(EAST.axes.random(np.random.default_rng(0), (12,))))
    metrics = figures_of_merit(information)
    assert "gyro_bias" in metrics["theta"]
    assert set(metrics["inequality"]) == {"gyro_first_order", "gyro_second_order", "gyro_misalignment"}


# ---------------------------------------------------------------- what can be estimated


@pytest.mark.parametrize("pair", PAIRS)
def test_outer_axis_north_hides_a_combination_of_two_gyros(pair):
    angles = EAST.axes.random(np.random.default_rng(0), (500,))
    assert [rank(PlatformGyro(axis, pair), EAST, angles) for axis in "xyz"] == [8, 8, 8]
    assert [rank(PlatformGyro(axis, pair), NORTH, angles) for axis in "xyz"] == [7, 7, 8]


@pytest.mark.parametrize(("pair", "expected"), list(zip(PAIRS, (7, 6, 8), strict=True)))
def test_right_angles_alone_are_not_enough_for_every_pair(pair, expected):
    assert [rank(PlatformGyro(axis, pair), EAST, RIGHT_ANGLES) for axis in "xyz"] == [expected] * 3


def test_the_message_names_what_the_outer_axis_north_hides():
    with pytest.raises(AcalxError) as caught:
        Gradient().solve(Problem(NORTH, Platform(), D(), 16), np.random.default_rng(0))
    for part in (
        "no program of 16 positions within gamma_deg=[0, 360], alpha_deg=[0, 360]",
        "with azimuth_deg=0.0, latitude_deg=34.25",
        "gyro_x_S",
        "gyro_x_misalignment_S",
        "gyro_y_O",
        "gyro_y_misalignment_O",
        "change one of azimuth_deg=0.0, latitude_deg=34.25",
    ):
        assert part in str(caught.value)
    assert "gyro_z" not in str(caught.value)


def test_at_a_pole_misalignments_look_like_first_order_terms():
    pole = PlatformGimbals(latitude_deg=90)
    information = as_model(PlatformGyro()).information(pole.stimulus(pole.axes.random(np.random.default_rng(0), (50,))))
    assert len(information.inestimable()) == 2
    with pytest.raises(AcalxError, match=r"gyro_x_misalignment_O.*change one of azimuth_deg=90.0, latitude_deg=90.0"):
        Gradient().solve(Problem(pole, PlatformGyro(), D(), 9), np.random.default_rng(0))


# ---------------------------------------------------------------- programs


def test_reference_program_has_the_determinant_of_the_facts():
    angles = find_program("platform_reference_16").settings_for(EAST)
    gyros = sum(log_det(PlatformGyro(axis), EAST, angles) for axis in "xyz")
    accels = sum(log_det(PlatformAccel(axis), EAST, angles) for axis in "xyz")
    assert gyros + accels == pytest.approx(54.03, abs=0.005)
    assert log_det(Platform(), EAST, angles) == pytest.approx(gyros + accels, abs=1e-9)
    deviations = Platform(gyro_noise_deg_h=0.001).information(EAST.stimulus(angles)).standard_deviations[:8]
    assert deviations[0] == pytest.approx(4e-4, rel=0.02)  # deg/h
    arc_seconds = np.degrees(deviations[6:] / 15.041) * 3600
    assert (arc_seconds >= 5).all()
    assert (arc_seconds <= 10).all()


def test_the_best_published_program_of_a_platform_is_the_reference():
    assert best_published(Problem(EAST, Platform(), D(), 16)).name == "platform_reference_16"
    assert best_published(Problem(TwoAxis(), ScalarAccel(), D(), 16)) is None


@pytest.mark.parametrize(("n", "least", "efficiency"), [(13, 47.17, 0.996), (16, 54.77, 0.9997)])
def test_joint_programs_reach_the_determinant_and_are_bounded(n, least, efficiency):
    problem = Problem(EAST, Platform(), D(), n)
    best = Gradient(starts=24).solve(problem, np.random.default_rng(0)).best
    assert -best.loss >= least
    certificate = certify(problem, best.settings)
    assert efficiency <= certificate.efficiency <= 1.0
    assert "polynomial" in certificate.bound.method
    assert certificate.bound.proved


def test_a_rate_table_uses_the_whole_of_its_rate():
    problem = Problem(RateTable(), GyroRateTable(), D(), 10)
    result = Gradient(starts=8).solve(problem, np.random.default_rng(0))
    rates = np.degrees(result.best.settings[:, 2])
    np.testing.assert_allclose(np.abs(rates), 50.0, atol=1e-6)
    assert {-50.0, 50.0} == set(np.round(rates, 6))
