"""Every sensor and comparison of the configuration goes the whole way: design, bound, simulation, calibration."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from acalx.bounds import bound
from acalx.criteria import D
from acalx.estimation import Iterated, Readings, calibrate
from acalx.estimation.residuals import OF_MODEL
from acalx.models import Model, as_model
from acalx.numerics.arrays import Array
from acalx.optimizers import Gradient
from acalx.planning.defaults import usual_n
from acalx.problem import Problem
from acalx.quantities.stimulus import Stimulus
from acalx.simulation import Campaign, ErrorSources, run_campaign
from acalx.stands import Stand
from acalx.validation import validate
from configured import names, part

TRIALS, BLOCKS = 2000, 4
NAMES = names("model")


@cache
def model_of(name: str) -> Model:
    return as_model(part("model", name))


@cache
def stand_of(name: str) -> Stand:
    return part("stand", str(model_of(name).usual.get("stand", "two_axis")))


def errors_of(model: Model) -> ErrorSources:
    """Sensors that differ as their make does, with the noise that the model says; of 1 a thousandth of it."""
    options: dict[str, Any] = {"parameters": {}, "setting_rad": 0.0, "gravity": 0.0}
    noise = 1e-4 if all(channel.noise == 1.0 for channel in model.channels) else 1.0
    return ErrorSources(**options, noise=noise)


@cache
def program_of(name: str) -> Array:
    """A good program with about six residuals more than parameters."""
    model = model_of(name)
    n = max(-(-(len(model.parameters) + 6) // model.outputs), model.smallest_n + 1)
    problem = Problem(stand_of(name), model, D(), n)
    return Gradient(starts=8).solve(problem, np.random.default_rng(0)).program


@pytest.mark.parametrize("name", NAMES)
def test_readings_without_noise_give_the_parameters_exactly(name: str) -> None:
    model, rng = model_of(name), np.random.default_rng(1)
    known = stand_of(name).stimulus(program_of(name))
    truth = model.nominal + 0.05 * rng.standard_normal(len(model.parameters))
    readings = model.readings(truth, known)
    found = Iterated().estimate(model, readings, known, start=model.start(readings, known))
    assert found.converged
    np.testing.assert_allclose(found.parameters, truth, atol=1e-9)
    at_once = known  # products of what changes are not those of its means
    if known.weights is not None:
        at_once = Stimulus({name: value[..., 0, :] for name, value in known.items()})
    corrected = model.corrected(truth, model.readings(truth, at_once), at_once)
    np.testing.assert_allclose(corrected, model.readings(model.nominal, at_once), atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_intervals_cover_and_theory_bound_and_simulation_agree(name: str) -> None:
    model, stand, settings = model_of(name), stand_of(name), program_of(name)
    campaign = Campaign(model, stand, settings, errors_of(model), seed=3)
    outcome = run_campaign(campaign, Iterated(), TRIALS, name)
    assert outcome.moments.failed == 0
    groups: dict[str, list[float]] = {}
    for parameter, covered in zip(model.parameters, outcome.coverage, strict=True):
        groups.setdefault(parameter.group, []).append(float(covered))
    for group, covered in groups.items():
        assert 0.935 <= np.mean(covered) <= 0.965, group
    ratio = np.sqrt(np.mean((outcome.deviations / outcome.predicted) ** 2))
    assert abs(ratio - 1.0) < 0.02
    problem = Problem(stand, model, D(), len(settings))
    least = bound(problem)
    assert least.proved == (model.degree is not None and stand.frequencies is not None)
    loss = float(problem.loss(settings))
    assert loss >= least.loss - 1e-9
    assert np.linalg.slogdet(outcome.information.covariance)[1] == pytest.approx(loss, abs=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_a_sensor_is_calibrated_and_validated_from_its_readings(name: str) -> None:
    model, stand, rng = model_of(name), stand_of(name), np.random.default_rng(5)
    settings = np.concatenate([program_of(name)] * 2)
    known = stand.stimulus(settings)
    errors = errors_of(model)
    truth = errors.true_parameters(model, *rng.standard_normal((2, 1, len(model.parameters))))[0]
    noise = errors.noise * model.deviations(known)
    means = model.readings(truth, known) + noise * rng.standard_normal((len(settings), len(model.channels)))
    readings = Readings(name, means, stimulus=known)
    calibration = calibrate(readings, model)
    off = np.abs(calibration.estimate.parameters - truth) / calibration.estimate.standard_errors
    assert off.max() < 5.5
    sizes = {channel.unit: channel.noise for channel in model.channels} | {OF_MODEL: 1.0}
    for unit, size in calibration.noises.items():
        assert size == pytest.approx(errors.noise * sizes[unit], rel=0.6), unit
    assert calibration.corrected is not None
    assert calibration.corrected.shape == means.shape
    validated = validate(readings, model, stand=stand, programs=[], splits=10, turns=1)
    assert validated.medians[f"leave_one_out_rms_{validated.unit}"] < 3.0 * errors.noise
    assert usual_n(model) >= model.smallest_n
