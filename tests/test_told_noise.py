"""Noise that is told or not, and priors, which take one that is: in one unit from design to calibration."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acalx.criteria import D
from acalx.errors import ArgumentError, DataError
from acalx.estimation import Readings, calibrate
from acalx.models import GyroRateTable, Model, ScalarAccel, VectorAccel
from acalx.models.scalar_accel_quadratic import ScalarAccelQuadratic
from acalx.models.scalar_magnetometer import ScalarMagnetometer
from acalx.problem import Problem
from acalx.simulation import ErrorSources, simulate
from acalx.stands import RateTable, Stand, TwoAxis
from command import run

# Option of the noise, one that such sensors have, stand.
KINDS: list[tuple[Any, str, float, Stand]] = [
    (ScalarAccel, "noise_g", 1e-3, TwoAxis()),
    (ScalarAccelQuadratic, "noise_g", 1e-3, TwoAxis()),
    (ScalarMagnetometer, "noise_field", 2e-3, TwoAxis(dip_deg=65.0)),
    (VectorAccel, "noise_g", 1e-3, TwoAxis()),
    (GyroRateTable, "noise_deg_s", 0.01, RateTable()),
]
each_kind = pytest.mark.parametrize(("kind", "option", "noise", "stand"), KINDS)
USUAL = ErrorSources(parameters={}, setting_rad=0.0, gravity=0.0, noise=1.0)


def prior_of(model: Model) -> dict[str, float]:
    return {parameter.name: 0.1 * float(parameter.scatter or 0.01) for parameter in model.parameters}


@each_kind
def test_a_prior_takes_a_noise_that_is_told(kind: Any, option: str, noise: float, stand: Stand) -> None:
    with pytest.raises(ArgumentError, match=rf"^prior=\{{'bias': 0.01\}}: .* must be told too, as in {option}="):
        kind(prior={"bias": 0.01})
    assert kind(prior={}).prior_information.sum() == 0.0
    assert kind(prior={"bias": 0.01}, **{option: 1.0}).prior_information.any()
    with pytest.raises(ArgumentError, match=f"{option}=-1: a standard deviation is a positive number"):
        kind(**{option: -1})


@each_kind
def test_noise_that_is_not_told_is_one(kind: Any, option: str, noise: float, stand: Stand) -> None:
    felt = stand.stimulus(stand.axes.random(np.random.default_rng(0), (12,)))
    plain, one, told = kind(), kind(**{option: 1.0}), kind(**{option: noise})
    rows = plain.regressors(felt)
    np.testing.assert_array_equal(rows, one.regressors(felt))
    np.testing.assert_allclose(told.regressors(felt), rows / noise, rtol=1e-12)
    for name, value in told.derivative(felt).items():
        np.testing.assert_allclose(value, plain.derivative(felt)[name] / noise, rtol=1e-12, atol=1e-9)
    gradient = np.random.default_rng(1).standard_normal(rows.shape)
    for name, value in told.pull(felt, gradient).items():
        np.testing.assert_allclose(value, plain.pull(felt, gradient)[name] / noise, rtol=1e-9, atol=1e-9)
    readings = told.readings(told.nominal + 1e-3, felt)
    np.testing.assert_array_equal(readings, plain.readings(told.nominal + 1e-3, felt))
    for of in ("residual", "linearized"):
        left, own = (getattr(model, of)(model.nominal + 1e-4, readings, felt) for model in (plain, told))
        for a, b in zip(left, own, strict=True):
            np.testing.assert_allclose(b, a / noise, rtol=1e-9, atol=1e-9)


@each_kind
def test_a_prior_is_rows_of_its_own(kind: Any, option: str, noise: float, stand: Stand) -> None:
    plain = kind(**{option: noise})
    prior = prior_of(plain)
    informed = kind(prior=prior, **{option: noise})
    program = stand.axes.random(np.random.default_rng(3), (5,))
    felt = stand.stimulus(program)
    p = len(plain.parameters)
    rows = kind().regressors(felt).reshape(-1, p) / noise
    whole = np.concatenate([rows, np.diag([1.0 / prior[one.name] for one in plain.parameters])])
    np.testing.assert_allclose(informed.information(felt).matrix, whole.T @ whole, rtol=1e-10, atol=1e-6)
    loss = float(Problem(stand, informed, D(), 5).loss(program))
    assert loss == pytest.approx(-np.linalg.slogdet(whole.T @ whole)[1], abs=1e-6)


@each_kind
def test_simulation_agrees_with_design(kind: Any, option: str, noise: float, stand: Stand) -> None:
    plain = kind(**{option: noise})
    informed = kind(prior=prior_of(plain), **{option: noise})
    program = stand.axes.random(np.random.default_rng(3), (7,))
    outcome = simulate(program, stand, informed, USUAL, trials=2000, seed=1).outcomes["program"]
    assert outcome.moments.failed == 0
    designed = informed.information(stand.stimulus(program)).standard_deviations
    np.testing.assert_allclose(outcome.predicted, designed, rtol=1e-9)
    assert np.sqrt(np.mean((outcome.deviations / designed) ** 2)) == pytest.approx(1.0, abs=0.05)


def test_calibration_weighs_a_prior_in_the_same_units() -> None:
    stand, rng = TwoAxis(), np.random.default_rng(5)
    model = ScalarAccel(noise_g=1e-3, prior={"bias": 1e-3, "scale": 1e-3, "nonorthogonality": 1e-3})
    felt = stand.stimulus(stand.axes.random(rng, (6,)))
    truth = 1e-3 * rng.standard_normal(9)
    means = model.readings(truth, felt) + 1e-3 * rng.standard_normal((6, 3))
    found = calibrate(Readings("six", means, stimulus=felt), model, noise=1.0)
    expected = model.information(felt).standard_deviations
    np.testing.assert_allclose(found.estimate.standard_errors, expected, rtol=0.02)
    assert found.noise == pytest.approx(1e-3)
    with pytest.raises(DataError, match=r"six: 6 residuals of 6 positions do not tell the noise .*: give noise=1.0"):
        calibrate(Readings("six", means, stimulus=felt), model)


def test_the_command_line_says_the_remedy_and_simulates_with_the_noise_that_is_told(tmp_path: Path) -> None:
    refused = run(tmp_path, "model=scalar_accel", "model.prior={bias: 0.01}", "n=6", into="refused")
    assert refused.status != 0
    assert "model.noise_g=0.0001" in refused.err
    told = ("program=icosahedron_12", "model.noise_g=1e-3", "trials=200", "figures=false")
    found = run(tmp_path, *told, entry="simulate", into="told")
    assert found.status == 0, found.err
