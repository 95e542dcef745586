"""What a sensor leaves to differences, to lengths other than 1, and to noise that positions share comes out right."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest

from acalx.criteria import D
from acalx.errors import CompatibilityError, PluginError
from acalx.estimation import Iterated, Readings, calibrate
from acalx.models import Angle, Compared, Magnitude, Outputs, Projection, Together, as_model
from acalx.models.agreement import Agreement
from acalx.models.sensor_model import SensorModel
from acalx.numerics.arrays import Array
from acalx.problem import Problem
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus, conversion
from acalx.sensors import AccelMagnetometer, AccelTriad, Channel, MagnetometerTriad, Sensor
from acalx.stands import Stand, TwoAxis
from configured import names, part


class Twin(Sensor):
    """A sensor that leaves all derivatives to differences."""

    def __init__(self, sensor: Sensor) -> None:
        self.sensor = sensor

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return self.sensor.parameters

    @property
    def channels(self) -> tuple[Channel, ...]:
        return self.sensor.channels

    @property
    def needs(self) -> Mapping[str, str]:
        return self.sensor.needs

    @property
    def senses(self) -> tuple[str, ...]:
        return self.sensor.senses

    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        return self.sensor.readings(parameters, stimulus)


SENSORS = [name for name in names("model") if isinstance(as_model(part("model", name)), SensorModel)]


@cache
def model_and_stand(name: str) -> tuple[Any, Stand]:
    model: Any = as_model(part("model", name))
    return model, part("stand", str(model.usual.get("stand", "two_axis")))


@pytest.mark.parametrize("name", SENSORS)
def test_a_sensor_that_leaves_derivatives_to_differences_shows_the_same(name: str) -> None:
    model, stand = model_and_stand(name)
    twin = Compared(Twin(model.sensor), model.comparison)
    settings = stand.axes.random(np.random.default_rng(2), (model.smallest_n + 2,))
    felt = stand.stimulus(settings)
    exact, found = model.information(felt).matrix, twin.information(felt).matrix
    size = np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
    assert np.abs((found - exact) / size).max() < 1e-8
    problems = [Problem(stand, each, D(), len(settings)) for each in (model, twin)]
    (loss, gradient), (again, other) = (problem.loss_and_gradient(settings) for problem in problems)
    np.testing.assert_allclose(again, loss, atol=1e-7)
    # each setting by its own size: angles in rad stand beside rates and temperatures
    apart = np.abs(other - gradient).max(axis=0) / np.abs(gradient).max(axis=0)
    assert apart.max() < 1e-5


class Shared(Twin):
    """A triad with a drift that its readings share, 95 % of the variance."""

    def __init__(self, share: float = 0.95) -> None:
        super().__init__(AccelTriad("triangular", noise_g=1e-4))
        self.share = share

    def correlation(self, times: Array) -> Array:
        n = times.shape[-1]
        return np.broadcast_to(self.share + (1.0 - self.share) * np.eye(n), (*times.shape, n))


@pytest.mark.parametrize("comparison", [Magnitude(), Projection(), Outputs()])
def test_noise_that_positions_share_passes_through_the_comparison(comparison: Any) -> None:
    rng, n = np.random.default_rng(5), 15
    sensor, stand = Shared(), TwoAxis()
    model = Compared(sensor, comparison)
    program = stand.axes.random(rng, (n,))
    known = stand.stimulus(program).timed(model.needs, 1.0)
    force = known["specific_force"]
    predicted = np.sqrt(np.diag(np.linalg.inv(model.information(known).matrix)))
    # by generalized least squares on readings that are written out here
    trials = 4000
    shared, own = rng.standard_normal((trials, 1, 3)), rng.standard_normal((trials, n, 3))
    noise = 1e-4 * (np.sqrt(sensor.share) * shared + np.sqrt(1.0 - sensor.share) * own)
    readings = force + noise
    found = Iterated().estimate(model, readings, known, start=model.start(readings, known))
    assert found.converged.all()
    np.testing.assert_allclose(found.parameters.std(axis=0) / predicted, 1.0, atol=0.06)


def test_the_gradient_of_rows_that_hang_together_is_theirs() -> None:
    stand, rng = TwoAxis(), np.random.default_rng(3)
    for comparison in (Magnitude(), Outputs()):
        problem = Problem(stand, Compared(Shared(0.6), comparison), D(), 12)
        program = stand.axes.random(rng, (12,))
        _, gradient = problem.loss_and_gradient(program)
        step = 1e-5 * rng.standard_normal(program.shape)
        above, below = problem.losses(np.stack([program + step, program - step]))[..., 0]
        assert (above - below) / 2 == pytest.approx((gradient * step).sum(), rel=1e-5)


def test_correlations_of_no_noise_are_refused() -> None:
    class Impossible(Shared):
        def correlation(self, times: Array) -> Array:
            n = times.shape[-1]
            return np.broadcast_to(np.eye(n) - 0.9 * (1.0 - np.eye(n)), (*times.shape, n))

    model = Compared(Impossible(), Outputs())
    with pytest.raises(PluginError, match="positive definite"):
        Problem(TwoAxis(), model, D(), 12).losses(TwoAxis().axes.random(np.random.default_rng(0), (12,)))


@dataclass(frozen=True)
class Metric(Sensor):
    """A triad that reads m/s^2."""

    count: int = 1
    senses = ("specific_force",)

    @property
    def needs(self) -> Mapping[str, str]:
        return {"specific_force": "m/s^2"}

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        several = range(self.count)
        biases = [Parameter(f"bias_{k}_{axis}", "bias", "m/s^2") for k in several for axis in "xyz"]
        return (*biases, *(Parameter(f"scale_{k}_{axis}", "scale", "1") for k in several for axis in "xyz"))

    @property
    def channels(self) -> tuple[Channel, ...]:
        return tuple(Channel(f"a{axis}_{k}", "m/s^2", 1e-3) for k in range(self.count) for axis in "xyz")

    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        force = np.concatenate([stimulus["specific_force"]] * self.count, axis=-1)
        bias, scale = np.split(parameters[..., None, :], 2, axis=-1)
        return bias + (1.0 + scale) * force


@pytest.mark.parametrize(
    ("count", "comparison"), [(1, Magnitude()), (1, Projection()), (1, Outputs()), (2, Agreement())]
)
def test_a_length_counts_in_the_unit_that_a_sensor_takes(count: int, comparison: Any) -> None:
    rng, sensor, stand = np.random.default_rng(7), Metric(count), TwoAxis()
    model = Compared(sensor, comparison)
    known = stand.stimulus(stand.axes.random(rng, (20,)))
    model.check(known, stand)
    truth = 0.05 * rng.standard_normal(len(sensor.parameters))
    readings = model.readings(truth, known)
    found = Iterated().estimate(model, readings, known, start=model.start(readings, known))
    assert found.converged.all()
    np.testing.assert_allclose(found.parameters, truth, atol=1e-9)
    felt = model.felt(truth, readings, None)
    if felt is not None:
        np.testing.assert_allclose(felt["specific_force"], 9.80665 * known["specific_force"], atol=1e-9)


def test_known_forces_in_another_unit_are_brought_into_that_of_the_sensor() -> None:
    rng, stand = np.random.default_rng(8), TwoAxis()
    plain = stand.stimulus(stand.axes.random(rng, (15,)))
    metric = Stimulus(specific_force=9.80665 * plain["specific_force"], units={"specific_force": "m/s^2"})
    for name in ("scalar_accel", "vector_accel"):
        model: Any = as_model(part("model", name))
        np.testing.assert_allclose(model.regressors(metric), model.regressors(plain), atol=1e-14)
        rows = rng.standard_normal(model.regressors(plain).shape)
        pulled = [model.pull(each, rows)["specific_force"] for each in (plain, metric)]
        np.testing.assert_allclose(9.80665 * pulled[1], pulled[0], atol=1e-12)


def test_names_of_kinds_are_no_units() -> None:
    for kind in ("force", "rate", "field", "time"):
        for unit in ("g", "deg/s", "uT", "s"):
            assert conversion(kind, unit) is None
            assert conversion(unit, kind) is None
    assert conversion("nT", "uT") == pytest.approx(1e-3)
    assert conversion("whatever", "") == 1.0


@pytest.mark.parametrize(
    "comparisons",
    [[Outputs(), Magnitude()], [Magnitude(), Magnitude()], [Magnitude(), Magnitude(varies=True), Projection()]],
)
def test_comparisons_that_follow_from_each_other_are_refused(comparisons: list[Any]) -> None:
    with pytest.raises(CompatibilityError, match="follow from the others"):
        Compared(AccelTriad(), Together(comparisons))


def test_a_pair_with_a_known_angle_needs_no_attitude() -> None:
    stand: Any = part("stand", "magnetic_table")
    rng, sensor = np.random.default_rng(9), AccelMagnetometer()
    lengths = (Magnitude("specific_force"), Magnitude("magnetic_field"))
    model = Compared(sensor, Together([*lengths, Angle(angle_deg=90.0 + stand.dip_deg)]))
    assert model.knows == ()
    known = stand.stimulus(stand.axes.random(rng, (24,)))
    truth = 0.02 * rng.standard_normal(len(sensor.parameters))
    found = calibrate(Readings("pair", sensor.readings(truth, known)), model)
    np.testing.assert_allclose(found.estimate.parameters, truth, atol=1e-9)
    with pytest.raises(CompatibilityError, match="angle"):
        Problem(stand, Compared(sensor, Together([*lengths, Angle(angle_deg=120.0)])), D(), 24)
    attitude = Compared(sensor, Together([*lengths, Angle()]))
    np.testing.assert_allclose(model.information(known).matrix, attitude.information(known).matrix, rtol=1e-9)


def test_a_vector_of_a_pair_by_its_length_starts_where_it_may() -> None:
    rng, stand = np.random.default_rng(10), part("stand", "magnetic_table")
    model = Compared(AccelMagnetometer(), Magnitude("magnetic_field"), prior={"accel_bias": 0.01})
    known = stand.stimulus(stand.axes.random(rng, (30,)))  # type: ignore[attr-defined]
    readings = model.readings(model.nominal, known)
    assert np.isfinite(model.start(readings, None)).all()


def test_a_field_in_microtesla_is_not_read_from_one_in_its_own_strength() -> None:
    class InMicrotesla(Twin):
        @property
        def needs(self) -> Mapping[str, str]:
            return {"magnetic_field": "uT"}

    stand = part("stand", "magnetic_table")
    with pytest.raises(CompatibilityError, match="uT"):
        Problem(stand, Compared(InMicrotesla(MagnetometerTriad())), D(), 9)  # type: ignore[arg-type]
