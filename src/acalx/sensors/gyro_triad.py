"""A triad of gyros."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, final

from acalx.options import keep, require_switch
from acalx.quantities.stimulus import EARTH_RATE
from acalx.sensors.base import Channel, suits
from acalx.sensors.polynomial import Polynomial, Term, three_of
from acalx.sensors.triads import GROUPS, axis_terms, g_sensitivity_terms, require_triad, triangular_terms

__all__ = ["GyroTriad"]

_FACTOR = math.degrees(EARTH_RATE)  # stands give rates in units of the Earth's


@final
@dataclass(frozen=True)
class GyroTriad(Polynomial):
    """Three gyros along three axes, nearly.

    With the angular rate w in deg/s and the specific force a in g, both in sensor axes, the triad reads, in deg/s,

        W = bias + (I + diag(scale) + M) w + g_sensitivity a,

    where M is [[0, xy, xz], [0, 0, 0], [0, zy, 0]] for a triangular matrix, which is all that can be told where only
    the magnitude of the rate is known, and has all six misalignments for a full one. The g-sensitivity has
    nine entries.

    Parameters
    ----------
    matrix : str
        ``triangular`` or ``full``.
    g_sensitivity : bool
        Whether the specific force shows in the readings.
    noise_deg_s : float or three of them, deg/s
        Standard deviation of a reading. With 1, the default, standard deviations come out in units of it.

    Raises
    ------
    ArgumentError
        A matrix that there is not, a noise that is not positive.

    Source: IEEE Std 1431-2004 for the terms.
    """

    usual: ClassVar[Mapping[str, Any]] = suits(stand="rate_table")
    matrix: str = "full"
    g_sensitivity: bool = True
    noise_deg_s: float | Sequence[float] = 1.0

    def __post_init__(self) -> None:
        require_triad(self.matrix, 1)
        object.__setattr__(self, "g_sensitivity", require_switch("g_sensitivity", self.g_sensitivity))
        three_of("noise_deg_s", self.noise_deg_s)
        keep(self, "noise_deg_s")

    @property
    def kind(self) -> str:
        """Gyros: schemes design for them together."""
        return "gyros"

    @property
    def senses(self) -> tuple[str, ...]:
        """The angular rate follows from three readings."""
        return ("angular_rate",)

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """gx, gy, gz in deg/s."""
        noises = zip("xyz", three_of("noise_deg_s", self.noise_deg_s), strict=True)
        return tuple(Channel(f"g{axis}", "deg/s", noise) for axis, noise in noises)

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """Biases in deg/s, scale errors, angles in rad, g-sensitivities in deg/s/g."""
        if self.matrix == "triangular":
            each = [term for k, axis in enumerate("xyz") for term in self._by_force(axis, k)]
            return (*triangular_terms("w", "deg/s", GROUPS, 1, _FACTOR), *each)
        return tuple(
            term
            for k, axis in enumerate("xyz")
            for term in (*axis_terms("w", "deg/s", axis, k, 1, _FACTOR), *self._by_force(axis, k))
        )

    def _by_force(self, axis: str, channel: int) -> list[Term]:
        if not self.g_sensitivity:
            return []
        return g_sensitivity_terms(axis, channel)
