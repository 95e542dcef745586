"""Which readings are refused for what they can't be, and which right ones are not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from acalx.errors import ArgumentError, DataError
from acalx.estimation import Readings, Unit, calibrate
from acalx.models import Compared, Joined, Model, ScalarAccel, VectorAccel, as_model
from acalx.numerics.arrays import Array
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus
from acalx.sensors import IMU, GyroTriad, PlatformGyro, Polynomial, Sensor, Term
from acalx.stands import TwoAxis, TwoAxisRateTable

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


@pytest.mark.parametrize(
    ("accel", "gyro", "message"),
    [(1.0, 0.0174533, "rad/s"), (9.80665, 1.0, "m/s"), (1.0, 3600.0, "deg/h"), (1.0, 16.4, "16.4")],
)
def test_readings_that_follow_by_another_factor_than_their_unit_says_are_refused(
    accel: float, gyro: float, message: str
) -> None:
    stand, model = TwoAxisRateTable(), as_model(IMU())
    rng = np.random.default_rng(6)
    known = stand.stimulus(stand.axes.random(rng, (24,)))
    truth = 0.01 * rng.standard_normal(len(model.parameters))
    readings = model.readings(truth, known) * np.repeat([accel, gyro], 3)
    with pytest.raises(DataError, match=message):
        calibrate(Readings("unit", readings, stimulus=known), model)
    per = {"g": accel, "deg/s": gyro}
    found = calibrate(Readings("unit", readings, stimulus=known), model, unit=Unit("what it is", per))
    np.testing.assert_allclose(found.estimate.parameters, truth, atol=1e-8)


def test_one_number_is_none_for_channels_in_several_units() -> None:
    with pytest.raises(ArgumentError, match="a number for each"):
        Unit("m/s^2", 9.80665).per_channel(IMU().channels)


def test_what_parts_have_in_common_is_one_and_the_same() -> None:
    one, other = (Parameter("bias", "bias", unit) for unit in ("g", "mg"))

    def sensor(parameter: Parameter) -> Sensor:
        @dataclass(frozen=True)
        class One(Polynomial):
            terms = (Term(parameter), Term(Parameter("scale", "scale", "1"), "fx"))

        return One()

    Joined({"a": sensor(one), "b": sensor(one)}, common=["bias"])
    with pytest.raises(ArgumentError, match="different units"):
        Joined({"a": sensor(one), "b": sensor(other)}, common=["bias"])
