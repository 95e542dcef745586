"""Calibration of a gyro triad on a rate table."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import final

from acalx.models.base import Model
from acalx.models.joined import Composite
from acalx.models.polynomial import Polynomial, Term, require_noise
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import EARTH_RATE

__all__ = ["GyroRateTable"]


@final
@dataclass(frozen=True)
class GyroRateTable(Composite):
    """Twenty-one parameters of a gyro triad: bias, scale, misalignment and g-sensitivity.

    With the angular rate w in deg/s and the specific force a in g, both in sensor axes, the
    gyro along axis i reads, in deg/s,

        W_i = bias_i + (1 + scale_i) w_i + misalignment_ij w_j + misalignment_ik w_k
            + g_sensitivity_ix ax + g_sensitivity_iy ay + g_sensitivity_iz az.

    On a table at rest the rate is too small to show scale and misalignment: use the stand
    ``rate_table``, whose rate is a setting of each position.

    Parameters
    ----------
    noise_deg_s : float, deg/s
        Standard deviation of a reading. With 1, the default, standard deviations are in units
        of it.

    Raises
    ------
    ArgumentError
        A noise that is not positive.

    Source: IEEE Std 1431-2004 for the terms.
    """

    noise_deg_s: float = 1.0

    def __post_init__(self) -> None:
        require_noise("noise_deg_s", self.noise_deg_s)

    @cached_property
    def models(self) -> tuple[Model, ...]:
        """The x, y and z gyro."""
        return tuple(_Axis(own, self.noise_deg_s) for own in range(3))


@final
@dataclass(frozen=True)
class _Axis(Polynomial):
    own: int
    noise_deg_s: float

    @property
    def kind(self) -> str:
        """Gyros: the three axes are designed for together."""
        return "gyros"

    @property
    def noise(self) -> float:
        return self.noise_deg_s

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        axis = "xyz"[self.own]
        others = [k for k in range(3) if k != self.own]

        def rate(name: str, group: str, unit: str, k: int) -> Term:
            return Term(Parameter(name, group, unit), (("angular_rate", k),), math.degrees(EARTH_RATE))

        return (
            Term(Parameter(f"bias_{axis}", "bias", "deg/s")),
            rate(f"scale_{axis}", "scale", "1", self.own),
            *(rate(f"misalignment_{axis}{'xyz'[k]}", "misalignment", "rad", k) for k in others),
            *(
                Term(Parameter(f"g_sensitivity_{axis}{'xyz'[k]}", "g_sensitivity", "deg/s/g"), (("specific_force", k),))
                for k in range(3)
            ),
        )
