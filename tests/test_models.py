from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import parts
from acalx.bounds import certify
from acalx.errors import ArgumentError, CompatibilityError
from acalx.models import (
    Compared,
    Comparison,
    GyroRateTable,
    Joined,
    Magnitude,
    Model,
    Platform,
    Projection,
    ScalarAccel,
    ScalarAccelQuadratic,
    VectorAccel,
)
from acalx.numerics.arrays import Array
from acalx.optimizers import Gradient
from acalx.problem import Problem
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import VECTORS, Stimulus
from acalx.sensors import AccelTriad, PlatformAccel, PlatformGyro
from acalx.stands import RateTable
from acalx.testing import check_model

STANDS = [*parts.STANDS, *parts.FURTHER_STANDS]


@pytest.mark.parametrize("model", parts.MODELS, ids=repr)
def test_contract(model: Model) -> None:
    fitting = [stand for stand in STANDS if parts.fits(model, stand)]
    assert fitting, "no stand of the tests provides what the model needs"
    for stand in fitting:
        check_model(model, stand)


@pytest.mark.parametrize("model", parts.MODELS, ids=repr)
def test_degree_is_that_of_the_rows_along_a_line(model: Model) -> None:
    """On x + t y the rows are polynomials in t: differences of one order more vanish."""
    if model.degree is None:
        pytest.skip("no polynomials")
    rng, t = np.random.default_rng(0), np.arange(model.degree + 2.0)
    widths = {name: 3 if name in VECTORS else 1 for name in model.needs}
    lines = {name: rng.standard_normal(k) + np.outer(t, rng.standard_normal(k)) for name, k in widths.items()}
    rows = model.regressors(Stimulus(**lines))
    scale = np.abs(rows).max()
    np.testing.assert_allclose(np.diff(rows, model.degree + 1, axis=0) / scale, 0.0, atol=1e-12)
    assert np.abs(np.diff(rows, model.degree, axis=0)).max() > 1e-6 * scale


def test_regressors_of_the_triad() -> None:
    x, y, z = 0.48, -0.6, 0.64
    rows = ScalarAccel().regressors(Stimulus(specific_force=np.array([[x, y, z]])))
    np.testing.assert_allclose(rows, [[[x, y, z, x * x, y * y, z * z, x * y, x * z, z * y]]], rtol=1e-15)


@pytest.mark.parametrize("comparison", [Projection(), Magnitude()], ids=repr)
def test_regressors_are_the_derivative_of_both_residuals(comparison: Comparison) -> None:
    model = Compared(AccelTriad(), comparison)
    stimulus = parts.FULL.stimulus(parts.FULL.axes.random(np.random.default_rng(2), (20,)))
    unit = 1e-6 * np.eye(9)

    def j(parameters: Array) -> Array:
        spread = Stimulus(specific_force=np.broadcast_to(stimulus["specific_force"], (9, 20, 3)))
        return model.residual(np.zeros(9), model.readings(parameters, spread), spread)[0]

    numerical = (j(unit) - j(-unit)) / 2e-6
    np.testing.assert_allclose(model.regressors(stimulus)[:, 0, :], numerical.T, atol=1e-9)


def test_perfect_triad_reads_the_vertical() -> None:
    stimulus = parts.FULL.stimulus(parts.FULL.axes.random(np.random.default_rng(3), (7,)))
    model = ScalarAccel()
    measurement = model.readings(np.zeros(9), stimulus)
    np.testing.assert_allclose(measurement, stimulus["specific_force"], atol=1e-15)
    np.testing.assert_allclose(model.linearized(np.zeros(9), measurement, stimulus)[0], 0.0, atol=1e-15)


def test_groups() -> None:
    groups = [parameter.group for parameter in ScalarAccel().parameters]
    assert groups == ["bias"] * 3 + ["scale"] * 3 + ["nonorthogonality"] * 3
    assert ScalarAccel().smallest_n == 9


class Gyro(Model):
    """Two outputs in a position, and a stimulus that a two-axis table does not provide."""

    parameters = tuple(Parameter(name, "drift", "rad/s") for name in "abc")
    needs = ("angular_rate",)
    outputs = 2

    def regressors(self, stimulus: Stimulus) -> Array:
        assert "angular_rate" in stimulus
        rate = stimulus["angular_rate"]
        return np.stack([rate, rate[..., ::-1] ** 2], axis=-2)


def test_model_that_needs_what_the_stand_lacks_is_refused_with_both_names() -> None:
    with pytest.raises(CompatibilityError, match=r"model Gyro needs the angular rate, which stand TwoAxis does not"):
        Problem(parts.FULL, Gyro(), parts.D(), 9)


def test_default_derivative_of_several_outputs() -> None:
    rate = np.random.default_rng(4).standard_normal((2, 5, 3))
    derivative = Gyro().derivative(Stimulus(angular_rate=rate))["angular_rate"]
    expected = np.zeros((2, 5, 2, 3, 3))
    for k in range(3):
        expected[..., 0, k, k] = 1.0
        expected[..., 1, 2 - k, k] = 2.0 * rate[..., k]
    np.testing.assert_allclose(derivative, expected, atol=1e-9)
    assert Gyro().smallest_n == 2


def test_the_plain_triad_is_part_of_the_quadratic_one() -> None:
    stimulus = parts.FULL.stimulus(parts.FULL.axes.random(np.random.default_rng(5), (30,)))
    rows = ScalarAccelQuadratic().regressors(stimulus)
    np.testing.assert_allclose(rows[..., :9], ScalarAccel().regressors(stimulus), rtol=1e-15)
    np.testing.assert_allclose(rows[:, 0, 9:], stimulus["specific_force"] ** 3, rtol=1e-12)


def test_gyro_on_a_table_reads_in_degrees_per_second() -> None:
    stand = RateTable(latitude_deg=0.0)
    stimulus = stand.stimulus(np.radians([[30.0, 0.0, 40.0]]))
    rows = GyroRateTable().regressors(stimulus)[0]
    expected = [1.0, 20.0, 0.0, 40.0 * 0.75**0.5, 0.5, 0.0, 0.75**0.5]
    np.testing.assert_allclose(rows[0, :7], expected, atol=1e-12)
    assert not rows[0, 7:].any()


def test_a_gyro_at_one_rate_alone_can_not_tell_scale_from_g_sensitivity() -> None:
    for rates, unseen in (((40.0, 40.0), 9), ((-40.0, 40.0), 0)):
        angles = RateTable().axes.random(np.random.default_rng(0), (40,))
        angles[:, 2] = np.radians(np.resize(rates, 40))
        information = GyroRateTable().information(RateTable().stimulus(angles))
        assert len(information.inestimable()) == unseen


def test_joined_models_need_parameters_of_their_own() -> None:
    with pytest.raises(ArgumentError, match="joined models have the same parameters: accel_x_bias"):
        Joined([PlatformAccel(), PlatformAccel()])
    for given in ([], [1], PlatformAccel()):
        with pytest.raises(ArgumentError, match="give a list of one or more models"):
            Joined(given)  # type: ignore[arg-type]


def test_four_positions_of_a_tetrahedron_are_proved_optimal_for_the_vector_triad() -> None:
    corners = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]) / 3**0.5
    problem = Problem(parts.FULL, VectorAccel(), parts.D(), 4)
    program = parts.FULL.aim(corners)
    loss = float(problem.loss(program))
    assert loss == pytest.approx(-3 * np.log(256 / 27), abs=1e-12)  # three times 4 (4 / 3)^3
    assert certify(problem, program).optimal
    searched = Gradient().solve(problem, np.random.default_rng(0))
    assert searched.best.loss == pytest.approx(loss, abs=1e-9)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: PlatformGyro("w"), "axis='w': an axis is x, y or z"),
        (
            lambda: PlatformGyro(second_order=["IS", "IX"]),
            "there is no term 'IX'; the terms are II, OO, SS, IO, IS, OS",
        ),
        (lambda: PlatformGyro(second_order=["IS"]), r"second_order=\['IS'\]: give two different terms"),
        (lambda: PlatformGyro(second_order=["IS", "IS"]), "give two different terms"),
        (lambda: PlatformGyro(second_order="IS"), "give two different terms"),
        (lambda: PlatformGyro(noise_deg_h=0), "noise_deg_h=0: a standard deviation is a positive number"),
        (lambda: PlatformAccel(noise_g=True), "noise_g=True: "),
        (lambda: PlatformAccel(axis=1), "axis=1: "),
        (lambda: Platform(second_order=["SS", "XX"]), "there is no term 'XX'"),
        (lambda: Platform(sensors=["gyro"]), r"sensors=\['gyro'\]: give one or both of gyros, accels"),
        (lambda: Platform(sensors=[]), "give one or both"),
        (lambda: Platform(gyro_noise_deg_h=[1, 2]), r"gyro_noise_deg_h=\[1, 2\]: give one number, or three"),
        (lambda: Platform(accel_noise_g=[1, 2, -3]), "accel_noise_g=-3: a standard deviation is a positive number"),
        (lambda: VectorAccel(noise_g=float("nan")), "noise_g=nan: "),
        (lambda: GyroRateTable(noise_deg_s="x"), "noise_deg_s='x': "),
    ],
)
def test_bad_options(make: Callable[[], Model], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        make()


@pytest.mark.parametrize("groups", [("bias", "scale", "nonorthogonality"), ("bias", "scale"), ("nonorthogonality",)])
def test_magnitude_at_is_zero_at_the_truth_and_its_rows_are_the_derivative(groups: tuple[str, ...]) -> None:
    model, rng = ScalarAccel(groups), np.random.default_rng(5)
    truth = 0.05 * rng.standard_normal((4, len(model.parameters)))
    stimulus = parts.FULL.stimulus(parts.FULL.axes.random(rng, (4, 20)))
    measurement = model.readings(truth, stimulus)
    np.testing.assert_allclose(model.residual(truth, measurement, None)[0], 0.0, atol=1e-14)
    at = truth + 0.02
    rows = model.residual(at, measurement, None)[1]
    for k in range(truth.shape[1]):
        step = 1e-6 * np.eye(truth.shape[1])[k]
        difference = (
            model.residual(at - step, measurement, None)[0] - model.residual(at + step, measurement, None)[0]
        ) / 2e-6
        np.testing.assert_allclose(rows[..., k], difference, atol=1e-8)


@pytest.mark.parametrize("groups", [(), ("bias", "drift"), "bias", None, 3])
def test_groups_that_are_none_are_refused(groups: object) -> None:
    with pytest.raises(ArgumentError, match=r"groups=.*: give one or more of bias, scale, nonorthogonality"):
        ScalarAccel(groups)  # type: ignore[arg-type]


def test_six_faces_carry_a_model_without_nonorthogonality() -> None:
    model = ScalarAccel(groups=["scale", "bias"])
    assert [parameter.group for parameter in model.parameters] == ["bias"] * 3 + ["scale"] * 3
    faces = Stimulus(specific_force=parts.FACES.astype(float))
    assert not model.information(faces).singular
    assert ScalarAccel().information(faces).inestimable() == [
        "nonorthogonality_xy",
        "nonorthogonality_xz",
        "nonorthogonality_zy",
    ]
