"""Where what parts say of themselves meets what they do: degrees, tables, blocks, units, motions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from acalx import IMU, D, Problem, TwoAxis, TwoAxisRateTable
from acalx.bounds import bound
from acalx.errors import ArgumentError, CompatibilityError, DataError, PluginError, SingularError
from acalx.estimation import Readings, calibrate, read_readings
from acalx.models import Angle, Compared, Joined, Magnitude, Outputs, VectorAccel, as_model
from acalx.models.numerical import numerical_derivative
from acalx.numerics.arrays import Array
from acalx.planning.itinerary import Itinerary
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus
from acalx.recording.calibration import Corrected
from acalx.sensors import (
    AccelArray,
    AccelMagnetometer,
    AccelTriad,
    Channel,
    GyroTriad,
    MagnetometerTriad,
    Polynomial,
    Sensor,
    Term,
)
from acalx.simulation import ErrorSources, simulate
from acalx.stands import RateTable, Rotary, Setting, Turning, Turntable
from acalx.stands.fields import limits, step
from acalx.stands.turns import UP, Vector
from acalx.testing import check_sensor, check_stand
from command import assert_refused, run

RNG = np.random.default_rng(0)
ANY = TwoAxis().axes.random(RNG, (12,))
TURNED = TwoAxis().stimulus(ANY)


# ---------------------------------------------------------------- what a stand says of its degrees


@dataclass(frozen=True)
class Damped(Rotary):
    """A table on which a third setting weakens what is felt, as no polynomial does."""

    turns: ClassVar[Mapping[str, str]] = {"alpha1": "-y", "alpha2": "x"}
    surroundings: ClassVar[Mapping[str, Vector]] = {"specific_force": UP}
    alpha1_deg: Sequence[float] = limits(0.0, 360.0)
    alpha2_deg: Sequence[float] = limits(0.0, 360.0)

    @cached_property
    def settings(self) -> tuple[Setting, ...]:
        return (*self.angles, Setting("depth", 0.0, 2.0, None, False))

    def stimulus(self, settings: Array) -> Stimulus:
        felt = super().stimulus(settings)["specific_force"]
        return Stimulus(specific_force=felt * np.exp(-(settings[..., 2:] ** 2)))


@dataclass(frozen=True)
class Boasting(Damped):
    """The same, which says that it is of degree one."""

    frequencies: ClassVar[tuple[int, ...]] = (1, 1, 1)


def test_a_degree_that_nobody_said_proves_nothing() -> None:
    assert Damped().frequencies is None
    assert bound(Problem(Damped(), VectorAccel(), D(), 8)).status == "computed"


def test_a_degree_that_is_wrong_is_refused() -> None:
    with pytest.raises(PluginError, match=r"Boasting\.frequencies: what is felt is no polynomial .* in depth"):
        bound(Problem(Boasting(), VectorAccel(), D(), 8))
    with pytest.raises(AssertionError, match="frequencies are the degrees of the stimulus"):
        check_stand(Boasting())


def test_derivatives_of_further_settings_are_numerical() -> None:
    problem = Problem(Damped(), VectorAccel(), D(), 8)
    settings = problem.restrictions.random(np.random.default_rng(1), 1)
    _, gradient = problem.loss_and_gradient(settings)
    shift = np.zeros_like(settings)
    shift[0, 3, 2] = 1e-5
    expected = (problem.loss(settings + shift) - problem.loss(settings - shift)) / 2e-5
    assert gradient[0, 3, 2] == pytest.approx(float(expected[0]), rel=1e-5)


# ---------------------------------------------------------------- what a sensor says of its products


@dataclass(frozen=True)
class Tabled(Sensor):
    """One accelerometer whose table, and what it is without errors, may be wrong."""

    slope: float = 1.0
    ideally: float = 1.0

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return (Parameter("bias", "bias", "g"), Parameter("scale", "scale", "1"))

    @property
    def channels(self) -> tuple[Channel, ...]:
        return (Channel("ax", "g", 1e-3),)

    @property
    def needs(self) -> Mapping[str, str]:
        return {"specific_force": "g"}

    @property
    def table(self) -> Any:
        return ((0, 0, 1.0, ()), (0, 1, self.slope, (("specific_force", 0),)))

    @property
    def ideal(self) -> Any:
        return ((0, self.ideally, (("specific_force", 0),)),)

    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        force = stimulus["specific_force"][..., 0]
        return np.asarray(parameters[..., None, 0] + (1.0 + parameters[..., None, 1]) * force)[..., None]


@pytest.mark.parametrize(("wrong", "name"), [(Tabled(slope=7.0), "table"), (Tabled(ideally=1.5), "ideal")])
def test_products_that_are_not_those_of_the_readings_are_refused(wrong: Tabled, name: str) -> None:
    check_sensor(Tabled(), TwoAxis())
    assert np.isfinite(Problem(TwoAxis(), Tabled(), D(), 6).loss(ANY[:6]))
    with pytest.raises(PluginError, match=rf"Tabled\.{name} is not the derivative of the readings"):
        Problem(TwoAxis(), wrong, D(), 6)
    with pytest.raises(AssertionError, match=r"table|ideal"):
        check_sensor(wrong, TwoAxis())


@dataclass(frozen=True)
class Unseen(Polynomial):
    """A parameter that nothing shows stands beside one that is shown."""

    nominal_scale: float = 0.0

    @property
    def channels(self) -> tuple[Channel, ...]:
        return (Channel("ax", "g", 1e-2),)

    @property
    def terms(self) -> tuple[Term, ...]:
        return (
            Term(None, "fx", 1.0 - self.nominal_scale),
            Term(Parameter("bias", "bias", "g")),
            Term(Parameter("scale", "scale", "1", nominal=self.nominal_scale), "fx"),
        )


def test_what_no_product_shows_is_as_well_known_as_before() -> None:
    sensor = Tabled()
    model = Compared(sensor, prior={"bias": 0.1, "scale": 0.1})
    entries = [entry for entry in sensor.table if entry[1] == 0]

    @dataclass(frozen=True)
    class Half(Tabled):
        @property
        def table(self) -> Any:
            return tuple(entries)

        def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
            return np.asarray(super().readings(parameters * np.array([1.0, 0.0]), stimulus))

    information = Compared(Half(), prior={"bias": 0.1, "scale": 0.1}).information(TURNED)
    assert information.standard_deviations[1] == pytest.approx(0.1)
    assert information.log_det == pytest.approx(math.log(12 * 1e6 + 100.0) + math.log(100.0))
    assert model.information(TURNED).standard_deviations[1] < 0.01


def test_nominal_values_that_are_not_zero_keep_the_table() -> None:
    """Of readings with parameters in products rows do not depend on them."""
    plain, shifted = as_model(Unseen()), as_model(Unseen(nominal_scale=1.0))
    assert shifted.degree == 1
    np.testing.assert_allclose(shifted.information(TURNED).matrix, plain.information(TURNED).matrix)


def test_a_sensor_with_biases_alone_can_be_designed_for() -> None:
    problem = Problem(TwoAxis(), Compared(AccelTriad(groups=("bias",), noise_g=1e-3)), D(), 4)
    loss, gradient = problem.loss_and_gradient(ANY[None, :4])
    assert np.isfinite(loss)
    assert not gradient.any()


def test_the_fewest_positions_are_those_of_the_block_that_needs_most() -> None:
    arms = ("xx", "xy", "xz")
    model = as_model(IMU(arms=arms))
    assert model.smallest_n == 8
    assert as_model(IMU()).smallest_n == 8
    known = Compared(IMU(arms=arms), prior={"accel_bias": 0.1, "accel_scale": 0.1})
    assert known.smallest_n == 7


# ---------------------------------------------------------------- joined models


def test_joined_readings_in_another_unit_are_refused_like_those_of_one() -> None:
    triad = Compared(AccelTriad(noise_g=1e-3, matrix="triangular"), Magnitude())
    means = 9.80665 * TURNED["specific_force"] + 1e-3 * RNG.standard_normal((12, 3))
    with pytest.raises(DataError, match=r"mean magnitude is 9\.8"):
        calibrate(Readings("one", means), triad)
    with pytest.raises(DataError, match=r"mean magnitude is 9\.8"):
        calibrate(Readings("two", np.hstack([means, means])), Joined({"a": triad, "b": triad}))


@dataclass(frozen=True)
class InMeters(Polynomial):
    """A triad that takes what it feels in m/s^2."""

    @property
    def needs(self) -> Mapping[str, str]:  # type: ignore[override]
        return {"specific_force": "m/s^2"}

    @property
    def senses(self) -> tuple[str, ...]:
        return ("specific_force",)

    letter: str = "f"

    @property
    def channels(self) -> tuple[Channel, ...]:
        return tuple(Channel(f"a{axis}", *self.needs.values(), 1e-2) for axis in "xyz")

    @property
    def terms(self) -> tuple[Term, ...]:
        (unit,) = self.needs.values()
        biases = (Term(Parameter(f"bias_{axis}", "bias", unit), "", 1.0, k) for k, axis in enumerate("xyz"))
        return (*(Term(None, self.letter + axis, 1.0, k) for k, axis in enumerate("xyz")), *biases)


def test_what_was_felt_keeps_its_unit_in_joined_models() -> None:
    alone = Compared(InMeters(), Magnitude())
    joined = Joined({"a": alone})
    means = 9.80665 * TURNED["specific_force"]
    for model in (alone, joined):
        felt = model.felt(model.nominal, means, None)
        assert felt is not None
        np.testing.assert_allclose(felt.in_units({"specific_force": "g"})["specific_force"], TURNED["specific_force"])


# ---------------------------------------------------------------- noise


@dataclass(frozen=True)
class Drifting(Tabled):
    """Noise that positions share, or that depends on what is felt, written for one program alone."""

    wrong: str = field(default="correlation")

    def correlation(self, times: Array) -> Array | None:
        if self.wrong != "correlation":
            return None
        return np.asarray(np.exp(-np.abs(np.subtract.outer(times, times))))

    def deviations(self, stimulus: Stimulus) -> Array:
        if self.wrong != "deviations":
            return np.array([1e-3])
        return np.asarray(1e-3 + np.abs(stimulus["specific_force"][:, :1]))


@pytest.mark.parametrize("wrong", ["correlation", "deviations"])
def test_noise_of_one_program_alone_is_refused(wrong: str) -> None:
    with pytest.raises(PluginError, match=rf"Drifting\.{wrong} has shape"):
        Problem(TwoAxis(), Drifting(wrong=wrong), D(), 6)


@pytest.mark.parametrize("dip", [90.0, -90.0])
def test_parallel_vectors_have_no_angle(dip: float) -> None:
    together = as_model(AccelMagnetometer())
    assert together.outputs == 6
    with pytest.raises(CompatibilityError, match=r"angle between parallel vectors .* dip_deg"):
        Problem(TwoAxis(dip_deg=dip), Compared(AccelMagnetometer(), Angle()).sensor and pair(), D(), 14)


def pair() -> Compared:
    from acalx.models import Together

    parts = [Magnitude("specific_force"), Magnitude("magnetic_field"), Angle()]
    return Compared(AccelMagnetometer(), Together(parts))


def test_what_has_no_solution_is_nan_beside_what_has_one() -> None:
    from acalx.sensors.base import _solved

    matrix = np.stack([np.eye(2), np.ones((2, 2)), np.full((2, 2), np.nan)])
    found = _solved(matrix, np.ones((3, 2)))
    np.testing.assert_array_equal(found[0], [1.0, 1.0])
    assert np.isnan(found[1:]).all()


# ---------------------------------------------------------------- motions


def test_a_turn_has_to_be_taken_back() -> None:
    table = Turntable()
    settings = np.tile([math.pi, 0.3, 0.4], (3, 1))
    visit = Itinerary(table, settings)
    assert visit.travel == pytest.approx(2.0 * math.pi)
    assert visit.seconds == pytest.approx(2.0 * math.pi / table.speeds[0])


def test_a_reading_ends_where_its_rate_has_brought_it() -> None:
    table = TwoAxisRateTable(averaging_s=2.0)
    settings = np.array([[0.5, 0.6, 0.1, -0.2], [0.6, 0.4, 0.0, 0.0]])
    np.testing.assert_allclose(table.ends(settings)[0], [0.6, 0.4, 0.1, -0.2])
    np.testing.assert_allclose(table.starts(settings)[0], [0.4, 0.8, 0.1, -0.2])
    assert Itinerary(table, settings).travel == pytest.approx(0.0)


@dataclass(frozen=True)
class Spindle(Turning):
    """A vertical axis of which nothing is known of the Earth."""

    turns: ClassVar[Mapping[str, str]] = {"spin": "z"}
    surroundings: ClassVar[Mapping[str, Vector]] = {"specific_force": UP}
    spin_deg: Sequence[float] = limits(0.0, 360.0)
    spin_rate_deg_s: Sequence[float] = limits(-90.0, 90.0)
    spin_rate_step_deg_s: float | None = step()


def test_a_turning_stand_need_not_know_the_earth() -> None:
    check_stand(Spindle())
    felt = Spindle().stimulus(np.array([[0.0, 0.5]]))
    assert set(felt) == {"specific_force", "angular_rate", "angular_acceleration"}


def test_numerical_derivatives_of_means_are_those_in_the_samples() -> None:
    stand, model = TwoAxisRateTable(), as_model(Plugged())
    stimulus = stand.stimulus(stand.axes.random(np.random.default_rng(2), (2, 5)))
    found = model.derivative(stimulus)
    expected = numerical_derivative(model.regressors, stimulus, model.needs)
    for name in model.needs:
        np.testing.assert_allclose(found[name], expected[name], atol=1e-7 * np.abs(expected[name]).max())


@dataclass(frozen=True)
class Plugged(Sensor):
    """A sensor without a table, with products of what is felt."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return (Parameter("bias", "bias", "g"), Parameter("square", "square", "1/g"), Parameter("cross", "cross", "g"))

    @property
    def channels(self) -> tuple[Channel, ...]:
        return (Channel("ax", "g", 1e-3),)

    @property
    def needs(self) -> Mapping[str, str]:
        return {"specific_force": "g", "angular_rate": "deg/s"}

    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        force, rate = stimulus["specific_force"], stimulus["angular_rate"] / 100.0
        bias, square, cross = (parameters[..., None, k] for k in range(3))
        read = force[..., 0] + bias + square * force[..., 0] ** 2 + cross * force[..., 1] * rate[..., 2]
        return np.asarray(read)[..., None]


# ---------------------------------------------------------------- options and messages


def test_arms_are_a_set_in_one_order() -> None:
    assert IMU(arms=("xy", "xx", "xx")) == IMU(arms=("xx", "xy"))


def test_one_triad_is_no_array() -> None:
    with pytest.raises(ArgumentError, match="triads=1: give 2 or more"):
        AccelArray(triads=1)


def test_a_length_in_a_unit_that_nobody_knows_is_refused() -> None:
    @dataclass(frozen=True)
    class Teslas(InMeters):
        @property
        def needs(self) -> Mapping[str, str]:  # type: ignore[override]
            return {"magnetic_field": "uT"}

        letter: str = "b"

        @property
        def senses(self) -> tuple[str, ...]:
            return ("magnetic_field",)

    with pytest.raises(CompatibilityError, match="takes the magnetic field in uT, in which its length is not known"):
        Compared(Teslas(), Magnitude())
    Compared(Teslas(), Magnitude(varies=True))
    Compared(Teslas(), Outputs())


@pytest.mark.parametrize(
    ("found", "message", "key"),
    [
        (Corrected(5, 1.01, "g"), "5 readings corrected; their mean magnitude is 1.01 g", "mean_magnitude_g"),
        (Corrected(5, 1.01, "field"), "their mean magnitude is 1.01 field", "mean_magnitude_field"),
        (Corrected(5, 9.8, "g"), "far from 1 g", "mean_magnitude_g"),
        (Corrected(5, None, "deg/s"), "5 readings corrected", "mean_magnitude_g"),
    ],
)
def test_corrected_readings_are_said_in_their_unit(found: Corrected, message: str, key: str) -> None:
    assert message in found.message
    assert found.entries == {"n": 5, key: found.magnitude}


# ---------------------------------------------------------------- noises that are estimated


FREE = IMU(arms=())


def test_a_unit_has_the_same_noises_within_another_model() -> None:
    alone, joined = as_model(FREE).noises, Joined({"i": FREE}).noises
    assert not joined.shared
    np.testing.assert_array_equal(joined.parameters, alone.parameters)
    assert joined.parameters.tolist() == [15.0, 21.0]


def test_models_within_models_keep_their_noises_apart() -> None:
    triads = {"a": AccelTriad(noise_g=1e-4), "g": GyroTriad(noise_deg_s=1e-3)}
    flat = Joined(triads).noises
    nested = Joined({name: Joined({"only": sensor}) for name, sensor in triads.items()}).noises
    np.testing.assert_array_equal(nested.of_outputs, flat.of_outputs)
    assert nested.of_outputs.tolist() == [0, 0, 0, 1, 1, 1]


@pytest.mark.parametrize("n", [6, 12])
def test_intervals_cover_where_parameters_show_in_several_noises(n: int) -> None:
    common = [f"misalignment_{own}{other}" for own in "xyz" for other in "xyz" if own != other]
    model = Joined(
        {"a": AccelTriad("full", noise_g=1e-4), "m": MagnetometerTriad("full", noise_field=1e-3)}, common=common
    )
    stand = TwoAxis(dip_deg=60)
    program = stand.axes.random(np.random.default_rng(5), (n,))
    noise_alone = ErrorSources({}, 1.0, setting_rad=0.0, gravity=0.0)
    (outcome,) = simulate(program, stand, model, noise_alone, trials=2000).outcomes.values()
    assert (outcome.coverage > 0.93).all()
    assert (outcome.coverage < 0.97).all()
    np.testing.assert_allclose(outcome.deviations, outcome.predicted, rtol=0.06)


@pytest.mark.parametrize(("channel", "size"), [(0, 30.0), (4, 30.0), (1, 1000.0)])
def test_a_gross_error_is_named_where_there_are_several_noises(channel: int, size: float) -> None:
    stand, model = TwoAxisRateTable(), as_model(FREE)
    rng = np.random.default_rng(3)
    felt = stand.stimulus(stand.axes.random(rng, (14,)))
    means = model.readings(model.nominal, felt)
    noise = np.array([one.noise for one in model.channels])
    means = means + noise * rng.standard_normal(means.shape)
    assert calibrate(Readings("clean", means, stimulus=felt), model).outlying == []
    means[4, channel] += size * noise[channel]
    assert 5 in calibrate(Readings("spoilt", means, stimulus=felt), model).outlying


# ---------------------------------------------------------------- steps of differences


@pytest.mark.parametrize("slow", [0.2, 1.0, 10.0])
def test_a_slow_position_beside_fast_ones_has_the_right_gradient(slow: float) -> None:
    model = Compared(GyroTriad("triangular", g_sensitivity=False), Magnitude(varies=True))
    problem = Problem(RateTable(rate_deg_s=(-1000, 1000)), model, D(), 14)
    settings = problem.restrictions.random(np.random.default_rng(7), 1)
    settings[0, 3, 2] = math.radians(slow)
    _, gradient = problem.loss_and_gradient(settings)
    shift = np.zeros_like(settings)
    shift[0, 3, 2] = 1e-3 * math.radians(slow)
    near, far = (problem.loss(settings + m * shift) - problem.loss(settings - m * shift) for m in (1, 2))
    expected = float((8.0 * near[0] - far[0]) / (12.0 * shift[0, 3, 2]))
    assert gradient[0, 3, 2] == pytest.approx(expected, rel=1e-4, abs=1e-6)


def test_a_gradient_does_not_depend_on_the_programs_beside_it() -> None:
    problem = Problem(TwoAxisRateTable(), as_model(Plugged()), D(), 6)
    settings = problem.restrictions.random(np.random.default_rng(8), 4)
    settings[1:, :, 2:] *= 0.01
    _, together = problem.loss_and_gradient(settings)
    for k in range(4):
        np.testing.assert_array_equal(problem.loss_and_gradient(settings[k : k + 1])[1][0], together[k])


@dataclass(frozen=True)
class Waving(Sensor):
    """A parameter that matters at a scale of its own, which nobody has told."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return (Parameter("bias", "bias", "g"), Parameter("delay", "delay", "s", nominal=1e-9))

    @property
    def channels(self) -> tuple[Channel, ...]:
        return (Channel("ax", "g", 1e-3),)

    @property
    def needs(self) -> Mapping[str, str]:
        return {"specific_force": "g"}

    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        force = stimulus["specific_force"][..., 0]
        return np.asarray(parameters[..., None, 0] + force * (1.0 + np.sin(1e4 * parameters[..., None, 1])))[..., None]


def test_a_parameter_of_a_small_scale_has_the_right_derivative() -> None:
    sensor = Waving()
    found = sensor.by_parameters(sensor.nominal, TURNED)[..., 0, 1]
    np.testing.assert_allclose(found, 1e4 * math.cos(1e-5) * TURNED["specific_force"][..., 0], rtol=1e-8, atol=1e-6)


# ---------------------------------------------------------------- units of products, and of settings


@dataclass(frozen=True)
class Plain(Polynomial):
    """One axis, written without a thought of units: a channel, a bias and a scale."""

    letter: str = "wx"
    unit: str = "deg/s"
    factor: float = 1.0
    nominal_scale: float = 0.0

    @property
    def channels(self) -> tuple[Channel, ...]:
        return (Channel("x", self.unit, 0.01),)

    @property
    def terms(self) -> tuple[Term, ...]:
        scale = Parameter("scale", "scale", "1", nominal=self.nominal_scale)
        ideal = () if self.nominal_scale else (Term(None, self.letter, self.factor),)
        return (*ideal, Term(Parameter("bias", "bias", self.unit)), Term(scale, self.letter, self.factor))


@pytest.mark.parametrize("nominal", [0.0, 1.0])
@pytest.mark.parametrize(
    ("letter", "unit", "quantity", "most"),
    [("wx", "deg/s", "angular_rate", 100.0), ("fx", "m/s^2", "specific_force", 9.80665), ("fx", "g", "", 1.0)],
)
def test_products_are_in_the_unit_of_the_channel_that_reads_them(
    letter: str, unit: str, quantity: str, most: float, nominal: float
) -> None:
    sensor = Plain(letter, unit, nominal_scale=nominal)
    assert list(sensor.needs.values()) == [unit]
    stand = TwoAxisRateTable(averaging_s=0.0)
    settings = np.array([[[0.0, 0.0, math.radians(100.0), 0.0], [math.pi / 2.0, math.pi / 2.0, 0.0, 0.0]]])
    read = as_model(sensor).readings(sensor.nominal, stand.stimulus(settings))
    assert np.abs(read).max() == pytest.approx(most, rel=1e-4)


def test_a_factor_may_bring_what_stands_give_into_the_unit_of_a_channel() -> None:
    assert as_model(Plain("fx", "m/s^2", 9.80665)).needs == {"specific_force": "g"}
    with pytest.raises(PluginError, match=r"reads 57\.3 times the angular rate in earth_rate, where 0\.004178"):
        as_model(Plain(factor=57.3))


@dataclass(frozen=True)
class Doubled(Plain):
    """It says the unit itself, and the factor as if it had not."""

    needs: ClassVar[Mapping[str, str]] = {"angular_rate": "deg/s"}  # type: ignore[assignment]


def test_a_factor_beside_a_unit_that_makes_it_wrong_is_refused() -> None:
    with pytest.raises(PluginError, match=r"channel x in deg/s reads 57\.3 times the angular rate in deg/s, where 1"):
        as_model(Doubled(factor=57.3))


def test_a_channel_that_there_is_not_is_refused() -> None:
    @dataclass(frozen=True)
    class Third(Plain):
        @property
        def terms(self) -> tuple[Term, ...]:
            return (*super().terms, Term(Parameter("late", "bias", "deg/s"), "wx", 1.0, 3))

    with pytest.raises(PluginError, match="a product of channel 3, but there are 1, counted from 0"):
        as_model(Third())


def test_readings_along_a_motion_are_corrected_by_that() -> None:
    sensor = IMU()
    stand, model = TwoAxisRateTable(), as_model(sensor)
    rng = np.random.default_rng(11)
    felt = stand.stimulus(stand.axes.random(rng, (20,)))
    scatter = np.array([one.scatter or 0.01 for one in model.parameters])
    truth = model.nominal + scatter * rng.standard_normal(len(scatter))
    found = model.corrected(truth, model.readings(truth, felt), felt)
    np.testing.assert_allclose(found, model.readings(model.nominal, felt), atol=1e-9)


def test_axes_the_other_way_round_are_named() -> None:
    triad = VectorAccel(noise_g=1e-4)
    means = -TURNED["specific_force"] + 1e-4 * RNG.standard_normal((12, 3))
    found = calibrate(Readings("turned", means, stimulus=Stimulus(specific_force=TURNED["specific_force"])), triad)
    assert any("scale_x, scale_y, scale_z below -1" in remark for remark in found.remarks())


HALL = """
import math
from dataclasses import dataclass
from acalx import Channel, Parameter, Polynomial, Setting, Stand, Stimulus, Term
from acalx.quantities.units import Unit

KILOPASCAL = Unit("kPa", "kPa", "kilopascals", 1000.0)


@dataclass(frozen=True)
class Vessel(Stand):
    @property
    def settings(self):
        return (Setting("pressure", 1e4, 2e5, None, False, KILOPASCAL),)

    def stimulus(self, settings):
        return Stimulus({"pressure": settings / 1e3}, units={"pressure": "kPa"})


@dataclass(frozen=True)
class Gauge(Polynomial):
    needs = {"pressure": "kPa"}
    usual = {"criterion": "d", "errors": "usual", "optimizer": "gradient", "n": 6}

    @property
    def channels(self):
        return (Channel("p", "kPa", 0.1),)

    @property
    def terms(self):
        one = (("pressure", 0),)
        return (
            Term(None, one),
            Term(Parameter("bias", "bias", "kPa", scatter=1.0)),
            Term(Parameter("scale", "scale", "1", scatter=0.01), one),
        )
"""


def test_settings_in_a_unit_of_somebody_s_own_go_the_whole_way(tmp_path: Path) -> None:
    (tmp_path / "hall.py").write_text(HALL, encoding="utf-8")
    own = ("model=custom", "model._target_=hall.Gauge", "stand=custom", "stand._target_=hall.Vessel", "figures=false")
    designed = run(tmp_path, *own, "optimizer.starts=2", "certificate=false", into="d")
    assert designed.status == 0, designed.err
    rows = designed.rows("program.csv")
    assert {round(float(row["pressure_kPa"])) for row in rows} == {10, 200}
    program = f"program={designed.directory / 'program.csv'}"
    evaluated = run(tmp_path, *own, program, "certificate=false", into="e", entry="evaluate")
    assert evaluated.status == 0, evaluated.err
    simulated = run(tmp_path, *own, program, "trials=200", into="s", entry="simulate")
    assert simulated.status == 0, simulated.err
    text = [
        ["pressure_kPa", "p"],
        *([row["pressure_kPa"], str(1.01 * float(row["pressure_kPa"]) + 0.5)] for row in rows),
    ]
    (tmp_path / "read.csv").write_text("\n".join(map(",".join, text)), encoding="utf-8")
    calibrated = run(tmp_path, *own, "data=read.csv", into="c", entry="calibrate")
    assert calibrated.status == 0, calibrated.err
    corrected = run(tmp_path, "apply=c", "data=read.csv", into="a", entry="calibrate")
    assert corrected.status == 0, corrected.err
    (tmp_path / "alone.csv").write_text("p\n10\n20\n", encoding="utf-8")
    alone = run(tmp_path, "apply=c", "data=alone.csv", into="b", entry="calibrate")
    assert_refused(alone, "corrected by what is known of each position", "pressure_kPa")


def test_what_is_colder_than_anything_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "cold.csv"
    path.write_text("temperature_K,ax,ay,az\n-20,1,0,0\n20,0,1,0\n", encoding="utf-8")
    with pytest.raises(DataError, match="temperature_K: -20 K is below absolute zero"):
        read_readings(path, quantities={"temperature": "degC"})


def test_a_remedy_is_one_that_there_is() -> None:
    means = np.concatenate([TURNED["specific_force"][:1] + 1e-4 * RNG.standard_normal((6, 3))])
    known = Stimulus(specific_force=np.repeat(TURNED["specific_force"][:1], 6, axis=0))
    with pytest.raises(SingularError) as found:
        calibrate(Readings("alike", means, stimulus=known), VectorAccel(noise_g=1e-4))
    assert "groups" not in str(found.value)
