"""The contract of a sensor looks at its noise and its parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from acalx.numerics.arrays import Array
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus
from acalx.sensors import Channel, Sensor
from acalx.stands import TwoAxis
from acalx.testing import check_sensor


@dataclass(frozen=True)
class Pair(Sensor):
    """Two accelerometers whose noise falls with the time in a position and drifts along."""

    mistake: str = ""

    @property
    def needs(self) -> dict[str, str]:
        return {"specific_force": "g", "dwell": "s"}

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(Parameter(f"bias_{axis}", "bias", "g") for axis in "xy")

    @property
    def channels(self) -> tuple[Channel, ...]:
        return Channel("ax", "g", 1e-3), Channel("ay", "g", 1e-3)

    @property
    def parts(self) -> dict[str, range]:
        left = {"a channel in none": range(1), "a channel in two": range(2)}
        return {"x": left.get(self.mistake, range(1)), "y": range(2, 2) if "none" in self.mistake else range(1, 2)}

    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        return np.asarray(stimulus["specific_force"][..., :2] + parameters[..., None, :])

    def by_parameters(self, parameters: Array, stimulus: Stimulus) -> Array:
        return np.eye(2) * (1.0 + 1e-8 * (self.mistake == "the eighth digit"))

    def deviations(self, stimulus: Stimulus) -> Array:
        sigma = np.broadcast_to(1e-3 / np.sqrt(stimulus["dwell"]), (*stimulus["dwell"].shape[:-1], 2))
        wrong = {"negative": -sigma, "zero": 0.0 * sigma, "a shape": sigma[..., :1], "infinite": sigma + np.inf}
        return np.asarray(wrong.get(self.mistake, sigma))

    def correlation(self, times: Array) -> Array:
        apart = np.abs(times[..., :, None] - times[..., None, :])
        good = 0.5 * np.exp(-apart / 600.0) + 0.5 * np.eye(times.shape[-1])
        if times.shape[-1] == 2:  # those that a model looks at when it is made
            return np.asarray(good)
        wrong = {
            "indefinite": 1.0 - apart / 60.0,
            "not symmetric": good + 1e-3 * np.triu(np.ones_like(good), 1),
            "a covariance": 2.0 * good,
            "of one program": good[..., :1],
        }
        return np.asarray(wrong.get(self.mistake, good))


def test_a_sensor_with_noise_by_dwell_is_in_order() -> None:
    check_sensor(Pair(), TwoAxis())


@pytest.mark.parametrize(
    ("mistake", "rule"),
    [
        ("negative", "deviations are positive and finite"),
        ("zero", "deviations are positive and finite"),
        ("infinite", "deviations are positive and finite"),
        ("a shape", "deviations have shape"),
        ("indefinite", "correlation is positive definite"),
        ("not symmetric", "correlation is symmetric"),
        ("a covariance", "correlation is 1 of a position with itself"),
        ("of one program", "correlation has shape"),
        ("a channel in none", "parts have each of the 2 channels once"),
        ("a channel in two", "parts have each of the 2 channels once"),
        ("the eighth digit", "by_parameters agrees with the numerical derivatives"),
    ],
)
def test_mistakes_are_named(mistake: str, rule: str) -> None:
    with pytest.raises(AssertionError, match=f"Pair breaks a rule: {rule}"):
        check_sensor(Pair(mistake), TwoAxis())
