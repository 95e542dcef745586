"""Which readings are refused for what they can't be, and which right ones are not."""

from __future__ import annotations

import numpy as np
import pytest

from acalx.errors import DataError
from acalx.estimation import Readings, Unit, calibrate
from acalx.models import Compared, Model, ScalarAccel, VectorAccel
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus
from acalx.sensors import GyroTriad, PlatformGyro
from acalx.stands import TwoAxis

RNG = np.random.default_rng(0)
TURNED = TwoAxis().stimulus(TwoAxis().axes.random(RNG, (12,)))
WITH_RATE = TURNED.made({**TURNED, "angular_rate": 0.1 * RNG.standard_normal((12, 3))})
FIVE_G = TURNED.made({**TURNED, "specific_force": 5.0 * TURNED["specific_force"]})


def read(model: Model, known: Stimulus, noise: float) -> Array:
    clean = model.readings(model.nominal, known)
    return np.asarray(clean + noise * RNG.standard_normal(clean.shape))


def test_known_forces_of_a_centrifuge_are_no_wrong_unit() -> None:
    means = read(VectorAccel(), FIVE_G, 1e-4)
    found = calibrate(Readings("centrifuge", means, stimulus=FIVE_G), VectorAccel())
    assert found.noise == pytest.approx(1e-4, rel=0.5)
    with pytest.raises(DataError, match=r"mean magnitude is 49\.0.*, but 5 g should read 5 g.*m/s\^2"):
        calibrate(Readings("centrifuge", 9.80665 * means, stimulus=FIVE_G), VectorAccel())
    with pytest.raises(DataError, match=r"mean magnitude is 5.*, but 1 g should read 1 g"):
        calibrate(means, ScalarAccel())


def test_a_drift_that_hardly_changes_is_a_reading() -> None:
    """10 deg/h, of which the g-sensitivity of 0.001 deg/h is all that the attitude shows."""
    model = Compared(PlatformGyro(axis="x"))
    known = Stimulus({name: WITH_RATE[name] for name in model.needs})
    truth = model.nominal + np.array([10.0, *(1e-3 * RNG.standard_normal(len(model.parameters) - 1))])
    means = np.asarray(model.readings(truth, known)) + 1e-5 * RNG.standard_normal((12, 1))
    assert 0.0 < np.ptp(means) < 1e-2
    found = calibrate(Readings("drift", means, stimulus=known), model)
    np.testing.assert_allclose(found.estimate.parameters, truth, atol=1e-4)


@pytest.mark.parametrize("model", [ScalarAccel(), VectorAccel(), Compared(GyroTriad())])
def test_readings_that_are_all_the_same_are_refused(model: Model) -> None:
    with pytest.raises(DataError, match="all 12 positions read the same"):
        calibrate(Readings("stuck", np.full((12, 3), 0.577), stimulus=WITH_RATE), model)


def test_an_offset_does_not_make_positions_alike() -> None:
    known = Stimulus(specific_force=TURNED["specific_force"])
    means = 32768.0 + 16.0 * read(ScalarAccel(), known, 1e-4)
    found = calibrate(means, ScalarAccel(), unit=Unit("counts", 16.0, offset=32768.0))
    assert found.noise == pytest.approx(1e-4, rel=0.8)
