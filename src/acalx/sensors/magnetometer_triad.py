"""A triad of magnetometers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, final

from acalx.options import keep
from acalx.sensors.base import Channel, suits
from acalx.sensors.polynomial import Polynomial, Term, three_of
from acalx.sensors.triads import GROUPS, axis_terms, require_triad, triangular_terms

__all__ = ["MagnetometerTriad"]


@final
@dataclass(frozen=True)
class MagnetometerTriad(Polynomial):
    """Three magnetometers along three axes, nearly, with hard and soft iron about them.

    In a field b in sensor axes, in units of its strength, the triad reads, in that unit,

        W = bias + (I + diag(scale) + M) b,

    where the biases hold hard iron, and scale and M soft iron too. M is [[0, xy, xz], [0, 0, 0], [0, zy, 0]] for a
    triangular matrix, which is all that can be told where the attitude is not known, and has all six entries
    for a full one.

    Parameters
    ----------
    matrix : str
        ``triangular`` or ``full``.
    noise_field : float or three of them, in units of the field's strength
        Standard deviation of a reading. With 1, the default, standard deviations come out in units of it.

    Raises
    ------
    ArgumentError
        A matrix that there is not, a noise that is not positive.

    Source: Gebre-Egziabher, Elkaim, Powell, Parkinson, J. Aerosp. Eng. 19(2), 2006, 87-102.
    """

    usual: ClassVar[Mapping[str, Any]] = suits(stand="magnetic_table")
    matrix: str = "triangular"
    noise_field: float | Sequence[float] = 1.0

    def __post_init__(self) -> None:
        require_triad(self.matrix, 1)
        three_of("noise_field", self.noise_field)
        keep(self, "noise_field")

    @property
    def kind(self) -> str:
        """Magnetometers: schemes design for them together."""
        return "magnetometers"

    @property
    def senses(self) -> tuple[str, ...]:
        """The field follows from three readings."""
        return ("magnetic_field",)

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """mx, my, mz in units of the field's strength."""
        noises = zip("xyz", three_of("noise_field", self.noise_field), strict=True)
        return tuple(Channel(f"m{axis}", "field", noise) for axis, noise in noises)

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """Biases in units of the field, relative scale errors, angles in rad."""
        if self.matrix == "triangular":
            return triangular_terms("b", "field", GROUPS)
        return tuple(term for k, axis in enumerate("xyz") for term in axis_terms("b", "field", axis, k))
