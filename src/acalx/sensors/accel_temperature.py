"""A triad of accelerometers that feel the temperature."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, final

from acalx.quantities.parameter import Parameter
from acalx.sensors.base import Channel, suits
from acalx.sensors.polynomial import Polynomial, Term, require_noise
from acalx.sensors.triads import axis_terms

__all__ = ["AccelTemperature"]


@final
@dataclass(frozen=True)
class AccelTemperature(Polynomial):
    """Three accelerometers with a full matrix whose biases and scales change with the temperature t in degrees Celsius.

    In known attitudes the accelerometer along axis i reads, in g,

        W_i = bias_i + (1 + scale_i) a_i + misalignment_ij a_j + bias_t_i t + bias_tt_i t^2 + scale_t_i t a_i,

    21 parameters in all. They are those at 0 degrees Celsius; D does not depend on that.

    Parameters
    ----------
    noise_g : float, g
        Standard deviation of a reading.

    Raises
    ------
    ArgumentError
        A noise that is not positive.

    Source: IEEE Std 1293-2018, the thermal model.
    """

    usual: ClassVar[Mapping[str, Any]] = suits(stand="chamber", optimizer="gradient", n=12)
    noise_g: float = 1e-4

    def __post_init__(self) -> None:
        require_noise("noise_g", self.noise_g)

    @property
    def kind(self) -> str:
        """Accelerometers: schemes design for them together."""
        return "accels"

    @property
    def senses(self) -> tuple[str, ...]:
        """The specific force follows from three readings and the temperature."""
        return ("specific_force",)

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """ax, ay, az in g."""
        return tuple(Channel(f"a{axis}", "g", self.noise_g) for axis in "xyz")

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """Of each accelerometer those without the temperature, then those with it."""
        return tuple(t for k, a in enumerate("xyz") for t in (*axis_terms("f", "g", a, k), *_thermal(a, k)))


def _thermal(axis: str, channel: int) -> list[Term]:
    """What the temperature does to one of them."""
    return [
        Term(Parameter(f"bias_t_{axis}", "bias_t", "g/degC", scatter=1e-4), "t", 1.0, channel),
        Term(Parameter(f"bias_tt_{axis}", "bias_tt", "g/degC^2", scatter=1e-6), "t t", 1.0, channel),
        Term(Parameter(f"scale_t_{axis}", "scale_t", "1/degC", scatter=1e-4), f"t f{axis}", 1.0, channel),
    ]
