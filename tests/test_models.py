from __future__ import annotations

import numpy as np
import pytest

import parts
from acalx.arrays import Array
from acalx.errors import ArgumentError, CompatibilityError
from acalx.information import Parameter
from acalx.models import Model, ScalarAccel
from acalx.problem import Problem
from acalx.stands import Stand
from acalx.stimulus import Stimulus
from acalx.testing import check_model


@pytest.mark.parametrize("stand", parts.STANDS, ids=repr)
@pytest.mark.parametrize("model", parts.MODELS, ids=repr)
def test_contract(model: Model, stand: Stand) -> None:
    check_model(model, stand)


def test_regressors_of_the_triad() -> None:
    x, y, z = 0.48, -0.6, 0.64
    rows = ScalarAccel().regressors(Stimulus(specific_force=np.array([[x, y, z]])))
    np.testing.assert_allclose(rows, [[[x, y, z, x * x, y * y, z * z, x * y, x * z, z * y]]], rtol=1e-15)


@pytest.mark.parametrize("residual", ["oriented", "magnitude"])
def test_regressors_are_the_derivative_of_both_residuals(residual: str) -> None:
    model = ScalarAccel()
    stimulus = parts.FULL.stimulus(parts.FULL.random(np.random.default_rng(2), (20,)))
    unit = 1e-6 * np.eye(9)

    def j(parameters: Array) -> Array:
        spread = Stimulus(specific_force=np.broadcast_to(stimulus.specific_force, (9, 20, 3)))
        measurement = model.measurement(parameters, spread)
        if residual == "oriented":
            return model.residual_oriented(measurement, spread)
        return model.residual_magnitude(measurement)

    numerical = (j(unit) - j(-unit)) / 2e-6
    np.testing.assert_allclose(model.regressors(stimulus)[:, 0, :], numerical.T, atol=1e-9)


def test_perfect_triad_reads_the_vertical() -> None:
    stimulus = parts.FULL.stimulus(parts.FULL.random(np.random.default_rng(3), (7,)))
    model = ScalarAccel()
    measurement = model.measurement(np.zeros(9), stimulus)
    np.testing.assert_allclose(measurement, stimulus.specific_force, atol=1e-15)
    np.testing.assert_allclose(model.residual_magnitude(measurement), 0.0, atol=1e-15)


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
        assert stimulus.angular_rate is not None
        rate = stimulus.angular_rate
        return np.stack([rate, rate[..., ::-1] ** 2], axis=-2)


def test_model_that_needs_what_the_stand_lacks_is_refused_with_both_names() -> None:
    with pytest.raises(CompatibilityError, match=r"model Gyro needs the angular rate, which stand TwoAxis does not"):
        Problem(parts.FULL, Gyro(), parts.D(), 9)


def test_default_derivative_of_several_outputs() -> None:
    rate = np.random.default_rng(4).standard_normal((2, 5, 3))
    derivative = Gyro().derivative(Stimulus(angular_rate=rate)).angular_rate
    expected = np.zeros((2, 5, 2, 3, 3))
    for k in range(3):
        expected[..., 0, k, k] = 1.0
        expected[..., 1, 2 - k, k] = 2.0 * rate[..., k]
    np.testing.assert_allclose(derivative, expected, atol=1e-9)
    assert Gyro().smallest_n == 2


@pytest.mark.parametrize("groups", [("bias", "scale", "nonorthogonality"), ("bias", "scale"), ("nonorthogonality",)])
def test_magnitude_at_is_zero_at_the_truth_and_its_rows_are_the_derivative(groups: tuple[str, ...]) -> None:
    model, rng = ScalarAccel(groups), np.random.default_rng(5)
    truth = 0.05 * rng.standard_normal((4, len(model.parameters)))
    stimulus = parts.FULL.stimulus(parts.FULL.random(rng, (4, 20)))
    measurement = model.measurement(truth, stimulus)
    np.testing.assert_allclose(model.magnitude_at(truth, measurement)[0], 0.0, atol=1e-14)
    at = truth + 0.02
    rows = model.magnitude_at(at, measurement)[1]
    for k in range(truth.shape[1]):
        step = 1e-6 * np.eye(truth.shape[1])[k]
        difference = (
            model.magnitude_at(at - step, measurement)[0] - model.magnitude_at(at + step, measurement)[0]
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
