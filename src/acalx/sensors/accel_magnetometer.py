"""A triad of accelerometers and one of magnetometers on the same board."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, final

from acalx.quantities.parameter import Parameter
from acalx.sensors.base import Channel, suits
from acalx.sensors.polynomial import Polynomial, Term, require_noise
from acalx.sensors.triads import GROUPS, part_terms, triangular_terms

__all__ = ["AccelMagnetometer"]


@final
@dataclass(frozen=True)
class AccelMagnetometer(Polynomial):
    """Three accelerometers and three magnetometers, and how their axes lie to each other: 21 parameters.

    With the specific force a in g and the field b in units of its strength, both in the axes of the accelerometers,

        W_a = bias_a + (I + diag(scale_a) + N_a) a,   W_m = bias_m + (I + diag(scale_m) + N_m) b - r x b,

    with triangular N as of `AccelTriad`, and the small rotation r of the magnetometers. Magnitudes show each triad by
    itself; the angle between gravity and the field, the same in every attitude, shows r.

    Parameters
    ----------
    accel_noise_g, magnetometer_noise_field : float
        Standard deviations of a reading, in g and in units of the field's strength.

    Raises
    ------
    ArgumentError
        A noise that is not positive.

    Source: Kok and Schoen, IEEE Sensors J. 16(14), 2016, 5679-5689, for the alignment by the dip.
    """

    usual: ClassVar[Mapping[str, Any]] = suits(stand="magnetic_table", optimizer="gradient", n=12)
    accel_noise_g: float = 1e-3
    magnetometer_noise_field: float = 5e-3

    def __post_init__(self) -> None:
        require_noise("accel_noise_g", self.accel_noise_g)
        require_noise("magnetometer_noise_field", self.magnetometer_noise_field)

    @property
    def kind(self) -> str:
        """The two are designed for together."""
        return "accel_magnetometer"

    @property
    def senses(self) -> tuple[str, ...]:
        """The specific force and the field follow from six readings."""
        return ("specific_force", "magnetic_field")

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """ax, ay, az in g, then mx, my, mz in units of the field's strength."""
        accels = (Channel(f"a{axis}", "g", self.accel_noise_g) for axis in "xyz")
        return (*accels, *(Channel(f"m{axis}", "field", self.magnetometer_noise_field) for axis in "xyz"))

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """Those of each triad, then the rotation of the magnetometers about x, y and z."""
        accels = part_terms(triangular_terms("f", "g", GROUPS), "accel_", 0)
        magnetometers = part_terms(triangular_terms("b", "field", GROUPS), "magnetometer_", 3)
        return (*accels, *magnetometers, *(term for axis in range(3) for term in _turned(axis)))


def _turned(axis: int) -> list[Term]:
    """- r x b for a rotation about one axis: the next component of b goes into the one after it, and that back."""
    j, k = (axis + 1) % 3, (axis + 2) % 3
    rotation = Parameter(f"alignment_{'xyz'[axis]}", "alignment", "rad", scatter=0.01)
    return [Term(rotation, f"b{'xyz'[k]}", 1.0, 3 + j), Term(rotation, f"b{'xyz'[j]}", -1.0, 3 + k)]
