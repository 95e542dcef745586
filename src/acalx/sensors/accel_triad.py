"""A triad of accelerometers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

from acalx.errors import ArgumentError
from acalx.options import keep
from acalx.sensors.base import Channel
from acalx.sensors.polynomial import Polynomial, Term, three_of
from acalx.sensors.triads import GROUPS, axis_terms, require_triad, triangular_terms

__all__ = ["AccelTriad"]


@final
@dataclass(frozen=True)
class AccelTriad(Polynomial):
    """Three accelerometers along three axes, nearly.

    With the specific force a in sensor axes, in g, the triad reads, in g,

        W = bias + (I + diag(scale) + M) a + quadratic a^2 + cubic a^3   (squares and cubes axis by axis),

    where M is [[0, xy, xz], [0, 0, 0], [0, zy, 0]] for a triangular matrix, which is all that can be told
    where the attitude is not known, and has all six misalignments for a full one.

    Parameters
    ----------
    matrix : str
        ``triangular`` or ``full``.
    order : int
        1, 2 or 3: the highest power of the specific force along an axis.
    groups : sequence of str
        Of a triangular matrix the groups that are estimated; the others are taken for zero.
    noise_g : float or three of them, g
        Standard deviation of a reading. With 1, the default, standard deviations come out in units of it.

    Raises
    ------
    ArgumentError
        A matrix, an order or groups that there are not; a noise that is not positive.

    Source: Egorov, Kiryachenko, Popov (2021) for the triangular matrix; IEEE Std 1293-2018 for the others.
    """

    matrix: str = "triangular"
    order: int = 1
    groups: Sequence[str] = GROUPS
    noise_g: float | Sequence[float] = 1.0

    def __post_init__(self) -> None:
        require_triad(self.matrix, self.order)
        given = self.groups
        if isinstance(given, str) or not isinstance(given, Sequence) or not given or not set(given) <= set(GROUPS):
            raise ArgumentError.of("groups", given, f"give one or more of {', '.join(GROUPS)}", ["bias", "scale"])
        object.__setattr__(self, "groups", tuple(group for group in GROUPS if group in given))
        three_of("noise_g", self.noise_g)
        keep(self, "noise_g")

    @property
    def kind(self) -> str:
        """Accelerometers: schemes design for them together."""
        return "accels"

    @property
    def senses(self) -> tuple[str, ...]:
        """The specific force follows from three readings."""
        return ("specific_force",)

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """ax, ay, az in g."""
        noises = zip("xyz", three_of("noise_g", self.noise_g), strict=True)
        return tuple(Channel(f"a{axis}", "g", noise) for axis, noise in noises)

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """Biases in g, scale errors, angles in rad, second-order terms in 1/g, third-order terms in 1/g^2."""
        if self.matrix == "triangular":
            return triangular_terms("f", "g", self.groups, self.order)
        return tuple(term for k, axis in enumerate("xyz") for term in axis_terms("f", "g", axis, k, self.order))
