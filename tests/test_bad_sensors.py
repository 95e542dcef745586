"""Sensors, stands, comparisons, priors and times that can't be: one plain message before any work."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import acalx
from acalx import D, Magnitude, Outputs, Parameter, Projection, Stand, Stimulus, TwoAxis
from acalx.errors import AcalxError
from acalx.estimation import Readings, calibrate
from acalx.models import Compared, Comparison
from acalx.numerics.arrays import Array
from acalx.problem import Problem
from acalx.sensors import Channel, Sensor
from acalx.simulation import ErrorSources, simulate
from command import assert_refused, run

FORCE = "specific_force"


@dataclass(frozen=True)
class Good(Sensor):
    """Biases and scales of three accelerometers: nothing is wrong with it."""

    parameters = tuple(
        Parameter(f"{group}_{axis}", group, unit, scatter=0.01)
        for group, unit in (("bias", "g"), ("scale", "1"))
        for axis in "xyz"
    )
    channels = tuple(Channel(f"a{axis}", "g", 1e-3) for axis in "xyz")
    needs = {FORCE: "g"}  # noqa: RUF012
    senses = (FORCE,)

    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        bias, scale = np.split(parameters[..., None, :], 2, axis=-1)
        return np.asarray(bias + (1.0 + scale) * stimulus[FORCE])


def bad(**members: Any) -> Sensor:
    """The same sensor with something else in the place of what it gives."""
    made: Sensor = type("Bad", (Good,), members)()
    return made


def reads(change: Callable[[Array, Array, Stimulus], Any]) -> dict[str, Any]:
    """Readings made of the right ones, the parameters and what is felt."""

    def readings(self: Good, parameters: Array, stimulus: Stimulus) -> Any:
        return change(Good.readings(self, parameters, stimulus), parameters, stimulus)

    return {"readings": readings}


def raised(*_: object) -> Any:
    raise ZeroDivisionError("division by zero")


def moved(what: Array, answer: Array) -> Array:
    what += 1e-3
    return answer


def by_parameters(change: Callable[[Array], Any]) -> dict[str, Any]:
    return {"by_parameters": lambda self, x, s: change(Sensor.by_parameters(self, x, s))}


def by_stimulus(change: Callable[[Array], Any]) -> dict[str, Any]:
    def changed(self: Good, x: Array, s: Stimulus) -> Any:
        return {name: change(value) for name, value in Sensor.by_stimulus(self, x, s).items()}

    return {"by_stimulus": changed}


def noise(*sizes: float) -> dict[str, Any]:
    return {"deviations": lambda self, stimulus: np.array(sizes)}


SHAPE = (
    r"^Bad\.readings has shape \({}\); expected \({}\) from parameters \(.*\) and specific force \(.*\): a number for"
)
NOISE = r"^Bad\.deviations gave {}; a standard deviation is a positive number"
P = Good.parameters
WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "one channel less": (reads(lambda f, x, s: f[..., :2]), SHAPE.format("1, 2", "1, 3")),
    "no channels": (reads(lambda f, x, s: f[..., 0]), SHAPE.format("1,", "1, 3")),
    "wrong for one position": (
        reads(lambda f, x, s: f[..., 0, :] if f.shape[-2] == 1 else f),
        SHAPE.format("3,", "1, 3"),
    ),
    "stacks in a row": (reads(lambda f, x, s: f.reshape(-1, 3)), SHAPE.format("2, 3", "2, 1, 3")),
    "stacks of positions": (
        reads(lambda f, x, s: f if s[FORCE].ndim == 2 else f[0]),
        SHAPE.format("1, 3", "2, 1, 3"),
    ),
    "no stacks of parameters": (
        reads(lambda f, x, s: x[:3] + (1.0 + x[3:]) * s[FORCE]),
        r"^Bad\.readings raised ValueError: operands could not be broadcast .*test_bad_sensors",
    ),
    "nan": (
        reads(lambda f, x, s: f * np.nan),
        r"^Bad\.readings is not finite in a position with the specific force \(",
    ),
    "nan somewhere": (
        reads(lambda f, x, s: np.where(s[FORCE][..., :1] > 0.95, np.nan, f)),
        r"^Bad\.readings is not finite in a position with the specific force \(0\.9.*\): it must be wherever the "
        r"stand goes; mend it, or keep the stand from going there by its limits or forbidden zones",
    ),
    "infinite": (reads(lambda f, x, s: f + np.inf), r"^Bad\.readings is not finite in"),
    "changes parameters": (reads(lambda f, x, s: moved(x, f)), r"^Bad\.readings changed the parameters that it was"),
    "changes what is felt": (reads(lambda f, x, s: moved(s[FORCE], f)), r"^Bad\.readings changed the specific force"),
    "complex": (
        reads(lambda f, x, s: f + 0j),
        r"^Bad\.readings gave an array of complex128; expected an array of real",
    ),
    "a list": (reads(lambda f, x, s: f.tolist()), r"^Bad\.readings gave list; expected an array of real numbers"),
    "nothing": (reads(lambda f, x, s: None), r"^Bad\.readings gave NoneType; expected an array of real numbers"),
    "raises": (reads(raised), r"^Bad\.readings raised ZeroDivisionError: division by zero \(.*bad_sensors.py, line"),
    "asks for more than it needs": (
        reads(lambda f, x, s: f + s["temperature"]),
        r"^Bad\.readings asks for 'temperature', but Bad\.needs names specific_force: name it there too, with its unit",
    ),
    "derivative by a factor": (
        by_parameters(lambda slopes: 1.001 * slopes),
        r"^Bad\.by_parameters is not the derivative of the readings: by \w+ it is [-\d.]+, and [-\d.]+ by differences; "
        "put it right, or leave it out",
    ),
    "derivative of another sign": (
        by_parameters(lambda slopes: slopes * np.where(np.arange(6) == 1, -1.0, 1.0)),
        r"^Bad\.by_parameters is not the derivative of the readings: by bias_y it is -1, and 1 by differences",
    ),
    "derivative of another shape": (
        by_parameters(lambda slopes: slopes[..., :5]),
        r"^Bad\.by_parameters has shape \(2, 3, 5\); expected \(2, 3, 6\): positions, channels, parameters",
    ),
    "derivative the wrong way round": (
        by_parameters(lambda slopes: slopes.swapaxes(-1, -2)),
        r"^Bad\.by_parameters has shape \(2, 6, 3\); expected \(2, 3, 6\)",
    ),
    "derivative nan": (by_parameters(lambda slopes: slopes * np.nan), r"^Bad\.by_parameters is not the .* is nan"),
    "derivative nothing": (by_parameters(lambda slopes: None), r"^Bad\.by_parameters gave NoneType; expected an array"),
    "by what is felt, a factor": (
        by_stimulus(lambda slopes: 0.9 * slopes),
        r"^Bad\.by_stimulus is not the derivative of the readings: by specific force [xyz] it is 0\.9, and 1 by",
    ),
    "by what is felt, another shape": (
        by_stimulus(lambda slopes: slopes[..., :2]),
        r"^Bad\.by_stimulus: specific force has shape \(2, 3, 2\); expected \(2, 3, 3\)",
    ),
    "by nothing that is felt": (
        {"by_stimulus": lambda self, x, s: {}},
        r"^Bad\.by_stimulus must give the derivatives by each of specific_force",
    ),
    "noise zero": (noise(1.0, 0.0, 1.0), NOISE.format("0")),
    "noise negative": (noise(1.0, 1.0, -0.1), NOISE.format(r"-0\.1")),
    "noise nan": (noise(np.nan, 1.0, 1.0), NOISE.format("nan")),
    "noise infinite": (noise(np.inf, 1.0, 1.0), NOISE.format("inf")),
    "noise of two": (noise(1.0, 1.0), r"^Bad\.deviations has shape \(2,\); expected \(3,\), or \(2, 3\)"),
    "noise that is negative somewhere": (
        {"deviations": lambda self, stimulus: stimulus[FORCE][..., :1] + np.full(3, 0.5)},
        NOISE.format(r"-[\d.e-]+"),
    ),
    "noise raises": ({"deviations": raised}, r"^Bad\.deviations raised ZeroDivisionError"),
    "parameter twice": ({"parameters": (*P, P[0])}, "^Bad.parameters: bias_x is there twice; each needs a name"),
    "parameter twice, in groups": (
        {"parameters": (*P, Parameter("bias_x", "offset", "g"))},
        "^Bad.parameters: bias_x is there twice",
    ),
    "no parameters": ({"parameters": ()}, "^Bad has no parameters"),
    "parameters that are none": (
        {"parameters": ("bias",)},
        r"^Bad\.parameters is \('bias',\); give a tuple of Parameter",
    ),
    "nominal nan": (
        {"parameters": (Parameter("a", "a", "g", nominal=np.nan),)},
        "^Bad.parameters: nominal values must",
    ),
    "channel twice": ({"channels": Good.channels[:1] * 3}, "^Bad.channels: ax is there twice"),
    "no channels at all": ({"channels": ()}, "^Bad has no channels"),
    "needs nothing": ({"needs": {}}, "^Bad needs nothing that is felt"),
    "needs without units": (
        {"needs": [FORCE]},
        r"^Bad\.needs is \['specific_force'\]; give each quantity with the unit",
    ),
    "needs a word": ({"needs": FORCE}, r"^Bad\.needs is 'specific_force'; give each quantity with the unit"),
    "needs no unit": ({"needs": {FORCE: None}}, r"^Bad\.needs is .*None.*; give each quantity with the unit"),
    "needs what nobody gives": (
        {"needs": {FORCE: "g", "pressure": "Pa"}},
        "^model Bad needs the pressure, which stand TwoAxis does not provide",
    ),
    "needs another unit": (
        {"needs": {FORCE: "T"}},
        "^model Bad needs the specific force in T, but stand TwoAxis gives it in g: let the stand give it in T"
        "|^Bad takes the specific force in T, in which its length is not known: take it in g",
    ),
    "senses what it does not need": (
        {"senses": ("magnetic_field",)},
        r"^Bad\.senses is \('magnetic_field',\); give a tuple of quantities that its needs name: specific_force",
    ),
    "senses a word": ({"senses": FORCE}, r"^Bad\.senses is 'specific_force'; give a tuple"),
    "correlations of another shape": (
        {"correlation": lambda self, times: np.eye(3)},
        r"^Bad\.correlation has shape \(3, 3\) for 2 times; expected \(2, 2\)",
    ),
    "correlations that can't be": (
        {"correlation": lambda self, times: np.full((2, 2), 2.0)},
        r"^Bad\.correlation gave .* for 2 times; correlations are 1 with themselves",
    ),
    "correlations raise": ({"correlation": raised}, r"^Bad\.correlation raised ZeroDivisionError"),
}

each_wrong = pytest.mark.parametrize(("members", "message"), WRONG.values(), ids=list(WRONG))


def test_nothing_is_wrong_with_the_sensor_that_is_spoiled() -> None:
    for comparison in (Outputs(), Magnitude()):
        assert np.isfinite(Problem(TwoAxis(), Compared(Good(), comparison), D(), 12).loss(ANY))


ANY = TwoAxis().axes.random(np.random.default_rng(1), (12,))


@each_wrong
@pytest.mark.parametrize("comparison", [Outputs(), Magnitude()], ids=["outputs", "magnitude"])
def test_a_bad_sensor_is_refused_before_design(members: dict[str, Any], message: str, comparison: Comparison) -> None:
    with pytest.raises(AcalxError, match=message):
        Problem(TwoAxis(), Compared(bad(**members), comparison), D(), 12)


@each_wrong
def test_a_bad_sensor_is_refused_by_the_other_use_cases(members: dict[str, Any], message: str) -> None:
    program = np.radians(np.stack([np.linspace(0, 350, 36), np.linspace(0, 1750, 36)], axis=-1))
    if "specific force in T" not in message:
        message = re.sub(r"0\\\.9\.\*|\(2, 3\)|\\\(2, 3\\\)$", ".*", message)
    with pytest.raises(AcalxError, match=message):
        acalx.evaluate(program, TwoAxis(), bad(**members), certificate=False)
    with pytest.raises(AcalxError, match=message):
        simulate(program, TwoAxis(), bad(**members), ErrorSources(noise=1.0), trials=10)


KNOWN_TO_READINGS = {name: entry for name, entry in WRONG.items() if "stand" not in entry[1] and "pressure" not in name}


@pytest.mark.parametrize(("members", "message"), KNOWN_TO_READINGS.values(), ids=list(KNOWN_TO_READINGS))
def test_a_bad_sensor_is_refused_before_it_is_calibrated(members: dict[str, Any], message: str) -> None:
    felt = TwoAxis().stimulus(np.radians(np.stack([np.linspace(0, 350, 36), np.linspace(0, 1750, 36)], axis=-1)))
    message = re.sub(r"0\\\.9\.\*|\(2, 3\)|\\\(2, 3\\\)$", ".*", message)
    with pytest.raises(AcalxError, match=message):
        calibrate(Readings("mine", felt[FORCE] + 1e-3, stimulus=felt), bad(**members))


# ---------------------------------------------------------------- stands, comparisons, priors


@dataclass(frozen=True, eq=False)
class OtherStand(Stand):
    """A table that gives something else, or in another unit."""

    gives: str = FORCE
    unit: str = "g"
    settings = TwoAxis().settings

    def stimulus(self, settings: Array) -> Stimulus:
        return Stimulus({self.gives: TwoAxis().stimulus(settings)[FORCE]}, units={self.gives: self.unit})


@pytest.mark.parametrize(
    ("stand", "message"),
    [
        (OtherStand(gives="magnetic_field", unit="field"), "needs the specific force, which stand OtherStand does not"),
        (
            OtherStand(unit="furlong"),
            "needs the specific force in g, but stand OtherStand gives it in furlong: let the",
        ),
        (
            OtherStand(unit=""),
            "needs the specific force in g, but stand OtherStand gives it in a unit that it does not",
        ),
    ],
)
def test_a_stand_that_does_not_give_what_is_needed_is_named(stand: Stand, message: str) -> None:
    with pytest.raises(AcalxError, match=message):
        Problem(stand, Compared(Good()), D(), 12)


def test_units_of_the_same_kind_are_converted() -> None:
    felt = Problem(OtherStand(unit="m/s^2"), Compared(Good()), D(), 12).information(ANY).matrix
    expected = Problem(TwoAxis(), Compared(Good()), D(), 12).information(ANY).matrix
    scale = np.r_[np.ones(3), np.full(3, 1 / 9.80665)]
    np.testing.assert_allclose(felt, expected * np.outer(scale, scale), rtol=1e-9, atol=1e-3)


@pytest.mark.parametrize(
    ("comparison", "message"),
    [
        (
            Magnitude("magnetic_field"),
            "Bad has no magnitude of the magnetic field to compare; its readings give specific",
        ),
        (Projection("angular_rate"), "Bad has no projection of the angular rate to compare"),
        (
            acalx.Angle(),
            "Bad has no angle of the magnetic field to compare.*name one of them, as in quantity='specific_force', or",
        ),
    ],
)
def test_a_comparison_of_what_readings_do_not_have_is_refused(comparison: Comparison, message: str) -> None:
    with pytest.raises(AcalxError, match=message):
        Compared(bad(), comparison)


@pytest.mark.parametrize("size", [-1.0, 0.0, np.nan, np.inf, "small", True, None])
def test_a_prior_that_is_no_standard_deviation_is_refused(size: Any) -> None:
    with pytest.raises(AcalxError, match=r"^prior=\{'bias': .*\}: a standard deviation is a positive number"):
        Compared(Good(), prior={"bias": size})


def test_a_prior_that_names_no_parameter_is_refused() -> None:
    with pytest.raises(AcalxError, match=r"^prior=\{'drift': 1.0\}: give parameters or groups, bias, scale"):
        Compared(Good(), prior={"bias": 1.0, "drift": 1.0})
    with pytest.raises(AcalxError, match=r"^prior=0.1: give standard deviations by parameter or group, as in prior="):
        Compared(Good(), prior=0.1)  # type: ignore[arg-type]


@pytest.mark.parametrize("dwell_s", [-1.0, np.nan, np.inf, "long", None, True])
def test_a_dwell_that_is_no_time_is_refused(dwell_s: Any) -> None:
    with pytest.raises(AcalxError, match=r"^dwell_s=.*: give the seconds in each position"):
        Problem(TwoAxis(), Compared(Good()), D(), 12, dwell_s=dwell_s)
    with pytest.raises(AcalxError, match=r"^dwell_s=.*: give the seconds in each position"):
        acalx.evaluate(ANY, TwoAxis(), Good(), dwell_s=dwell_s)


def test_a_dwell_of_zero_is_refused_where_the_noise_falls_with_it() -> None:
    falls = bad(
        needs={FORCE: "g", "dwell": "s"},
        deviations=lambda self, stimulus: 1e-3 / np.sqrt(stimulus["dwell"]) * np.ones(3),
    )
    Problem(TwoAxis(), Compared(falls), D(), 12)
    message = r"^dwell_s=0.*: give the seconds in each position, more than 0, since what Bad reads depends on them"
    with pytest.raises(AcalxError, match=message):
        Problem(TwoAxis(), Compared(falls), D(), 12, dwell_s=0.0)
    with pytest.raises(AcalxError, match=message):
        acalx.evaluate(ANY, TwoAxis(), falls, dwell_s=0.0)
    with pytest.raises(AcalxError, match=message):
        simulate(ANY, TwoAxis(), falls, ErrorSources(), trials=10, dwell_s=0.0)


# ---------------------------------------------------------------- from the shell

LAB = """
import numpy as np
from acalx import Channel, Parameter, Sensor, Stand, Stimulus, TwoAxis


class Good(Sensor):
    parameters = tuple(Parameter(f"bias_{axis}", "bias", "g") for axis in "xyz")
    channels = tuple(Channel(f"a{axis}", "g", 1e-3) for axis in "xyz")
    needs = {"specific_force": "g"}

    def readings(self, parameters, stimulus):
        return parameters[..., None, :] + stimulus["specific_force"]


class Short(Good):
    def readings(self, parameters, stimulus):
        return super().readings(parameters, stimulus)[..., :2]


class Nan(Good):
    def readings(self, parameters, stimulus):
        return np.nan * super().readings(parameters, stimulus)


class Greedy(Good):
    def readings(self, parameters, stimulus):
        parameters *= 2.0
        return super().readings(parameters, stimulus)


class Falling(Good):
    needs = {"specific_force": "g", "dwell": "s"}

    def deviations(self, stimulus):
        return 1e-3 / np.sqrt(stimulus["dwell"]) * np.ones(3)


class Hot(Good):
    needs = {"specific_force": "g", "temperature": "K"}


class Furlong(Stand):
    settings = TwoAxis().settings

    def stimulus(self, settings):
        return Stimulus(TwoAxis().stimulus(settings), units={"specific_force": "furlong"})
"""
OWN = "model=custom"
SHELL: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "module": ((OWN, "model._target_=lob.Good"), ("Error locating target 'lob.Good': No module named 'lob'",)),
    "class": ((OWN, "model._target_=lab.Goods", "+model.prior={bias: 1}"), ("lab.Goods",)),
    "shape": ((OWN, "model._target_=lab.Short"), ("Short.readings has shape (1, 2); expected (1, 3)", "channel")),
    "nan": ((OWN, "model._target_=lab.Nan"), ("Nan.readings is not finite in a position with the specific force",)),
    "changes": ((OWN, "model._target_=lab.Greedy"), ("Greedy.readings changed the parameters that it was given",)),
    "lacks": ((OWN, "model._target_=lab.Hot"), ("Hot needs the temperature, which stand TwoAxis does not provide",)),
    "unit": (
        (OWN, "model._target_=lab.Hot", "stand=chamber"),
        ("temperature in K, but stand Chamber gives it in degC",),
    ),
    "unit of a stand": (
        (OWN, "model._target_=lab.Good", "stand=custom", "stand._target_=lab.Furlong"),
        ("Good needs the specific force in g, but stand Furlong gives it in furlong: let the stand give it in g",),
    ),
    "dwell": ((OWN, "model._target_=lab.Falling", "dwell_s=0"), ("dwell_s=0: give the seconds", "more than 0")),
    "dwell negative": (("dwell_s=-5",), ("dwell_s=-5: give the seconds in each position",)),
    "dwell text": (("dwell_s=long",), ("dwell_s=long: give the seconds in each position",)),
    "prior": (("model=vector_accel", "model.prior={bias: -0.01}"), ("model.prior={bias: -0.01}", "positive number")),
    "prior of nothing": (("model=imu", "+model.prior={bias: 0.1}"), ("prior",)),
    "prior names none": (
        ("model=accel_magnetometer", "model.prior={drift: 0.1}"),
        ("model.prior={drift: 0.1}", "give parameters or groups, accel_bias"),
    ),
    "comparison": (
        (
            "model=accel_magnetometer",
            "model.comparison.comparisons=[{_target_: acalx.models.Magnitude, quantity: angular_rate}]",
        ),
        ("AccelMagnetometer has no magnitude of the angular rate to compare", "quantity=specific_force", "by Outputs"),
    ),
    "unseen": (
        ("model=accel_magnetometer", "stand=magnetic_table", "stand.field_azimuth_deg=0", "optimizer=gradient", "n=14"),
        ("no position there shows alignment_x; change one of", "stand.field_azimuth_deg=0"),
    ),
}


@pytest.mark.parametrize(("arguments", "phrases"), SHELL.values(), ids=list(SHELL))
def test_the_shell_says_it_in_one_message(tmp_path: Path, arguments: tuple[str, ...], phrases: tuple[str, ...]) -> None:
    (tmp_path / "lab.py").write_text(LAB, encoding="utf-8")
    outcome = run(tmp_path, *arguments, "figures=false")
    assert_refused(outcome, *phrases)
    assert outcome.files == {"result.json"} | ({"resolved.yaml"} & outcome.files)
