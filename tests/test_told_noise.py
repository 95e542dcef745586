"""What is said of the noise that a model tells: where standard deviations are for it, and where readings have more."""

from __future__ import annotations

import numpy as np
import pytest

from acalx.estimation import Readings, calibrate
from acalx.models import Model, ScalarAccel, as_model
from acalx.reporting.tables import units_line
from acalx.sensors import IMU
from acalx.stands import TwoAxisRateTable
from parts import MODELS

STAND = TwoAxisRateTable()
FELT = STAND.stimulus(STAND.axes.random(np.random.default_rng(1), (30,)))


def remarks(model: Model, times: float, noise: float | None = None) -> list[str]:
    clean, rng = model.readings(model.nominal, FELT), np.random.default_rng(2)
    sizes = np.array([channel.noise for channel in model.channels])
    known = None if all(channel.noise == 1.0 for channel in model.channels) else FELT
    means = clean + times * sizes * rng.standard_normal(clean.shape)
    return calibrate(Readings("readings", means, stimulus=known), model, noise=noise).remarks()


def test_noise_far_above_what_is_told_is_questioned() -> None:
    found = [each for each in remarks(as_model(IMU()), 30.0) if "far above" in each]
    assert len(found) == 1
    assert "in g " in found[0]
    assert "in deg/s " in found[0]
    assert not any("far above" in each for each in remarks(as_model(IMU()), 1.0))
    # of known noise chi-square says it
    known = remarks(as_model(IMU()), 30.0, noise=1.0)
    assert not any("far above" in each for each in known)
    assert any("chi-square" in each for each in known)


def test_noise_that_nobody_told_is_not_questioned() -> None:
    assert not any("far above" in each for each in remarks(ScalarAccel(), 1e-3))
    assert any("far above" in each for each in remarks(ScalarAccel(noise_g=1e-5), 1e-3 / 1e-5))


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.called)
def test_standard_deviations_say_for_what_noise_they_are(model: Model) -> None:
    line = units_line(model.parameters, model.channels)
    for channel in model.channels:
        assert f"{channel.noise:.4g} {channel.unit}" in line.partition("; for a noise of ")[2]
