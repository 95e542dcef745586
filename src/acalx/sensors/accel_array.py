"""Several triads of accelerometers on one board."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, final

from acalx.errors import ArgumentError
from acalx.options import require_count
from acalx.sensors.base import Channel, suits
from acalx.sensors.polynomial import Polynomial, Term, require_noise
from acalx.sensors.triads import GROUPS, axis_terms, part_terms, triangular_terms

__all__ = ["AccelArray"]


@final
@dataclass(frozen=True)
class AccelArray(Polynomial):
    """Triads of accelerometers that feel the same specific force: 9 parameters of the first and 12 of each other.

    In the axes of the first, which has a triangular matrix as of `AccelTriad`. The others have full ones, in which
    their alignment to it is.

    Parameters
    ----------
    triads : int
        How many; 2 or more.
    noise_g : float, g
        Standard deviation of a reading.

    Raises
    ------
    ArgumentError
        A number that is none, a noise that is not positive.

    Source: Carlsson, Skog, Jalden, IEEE Sensors J. 21(2), 2021, 1862-1873, for calibration of arrays in place.
    """

    usual: ClassVar[Mapping[str, Any]] = suits(optimizer="gradient", n=12)
    triads: int = 4
    noise_g: float = 1e-3

    def __post_init__(self) -> None:
        require_count("triads", self.triads)
        if self.triads == 1:
            raise ArgumentError.of("triads", 1, "give 2 or more; one triad alone is model scalar_accel", 2)
        require_noise("noise_g", self.noise_g)

    @property
    def kind(self) -> str:
        """Accelerometers: schemes design for them together."""
        return "accels"

    @property
    def senses(self) -> tuple[str, ...]:
        """The specific force, which each triad reads."""
        return ("specific_force",)

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """a1x, a1y, a1z, a2x and so on, in g."""
        return tuple(Channel(f"a{k + 1}{axis}", "g", self.noise_g) for k in range(self.triads) for axis in "xyz")

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """Of one triad after the other."""
        first = triangular_terms("f", "g", GROUPS)
        other = [term for k, axis in enumerate("xyz") for term in axis_terms("f", "g", axis, k)]
        each = (first, *[other] * (self.triads - 1))
        return tuple(
            term for k, own in enumerate(each) for term in part_terms(own, f"triad_{k + 1}_", 3 * k, grouped=False)
        )
