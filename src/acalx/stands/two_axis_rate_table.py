"""The two-axis rate table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import ClassVar, final

from acalx.quantities.units import DEGREE_PER_SECOND
from acalx.stands.fields import limits, number, step
from acalx.stands.turning import Turning
from acalx.stands.turns import UP, Vector

__all__ = ["TwoAxisRateTable"]


@final
@dataclass(frozen=True)
class TwoAxisRateTable(Turning):
    """A table that can turn about both of its axes while the sensor is read: the outer one level, the inner one on it.

    A position is a pair of angles and a pair of rates. With C = Rz(inner) Rx(outer) the sensor feels, in its axes,

        a = C (0, 0, 1)  in g,   w = C w_earth + outer rate Rz(inner) (1, 0, 0) + inner rate (0, 0, 1),

    and the angular acceleration that both rates together make.

    Parameters
    ----------
    outer_deg, inner_deg : pair of float, degrees
        Limits of the angles.
    outer_rate_deg_s, inner_rate_deg_s : pair of float, degrees per second
        Limits of the rates.
    outer_rate_step_deg_s, inner_rate_step_deg_s : float, degrees per second, optional
        A rate is a whole multiple of it. None: any.
    azimuth_deg : float, degrees
        Of the outer axis: 0 is north, 90, the default, east.
    latitude_deg : float, degrees
        North is positive.
    averaging_s
        As of `Turning`.
    step_deg, periodic
        As of `Rotary`.
    forbidden, forbidden_if, speed_deg_s
        As of `Stand`.

    Raises
    ------
    ArgumentError
        Limits the wrong way round or not finite, a latitude beyond a pole, and as of `Turning`.

    Source: IEEE Std 1431-2004, rate-table tests; IEEE Std 1293-2018, multipoint tests.
    """

    turns: ClassVar[Mapping[str, str]] = {"outer": "x", "inner": "z"}
    outer_deg: Sequence[float] = limits(0.0, 360.0)
    inner_deg: Sequence[float] = limits(0.0, 360.0)
    outer_rate_deg_s: Sequence[float] = limits(-100.0, 100.0, DEGREE_PER_SECOND)
    inner_rate_deg_s: Sequence[float] = limits(-100.0, 100.0, DEGREE_PER_SECOND)
    _: KW_ONLY
    outer_rate_step_deg_s: float | None = step(DEGREE_PER_SECOND)
    inner_rate_step_deg_s: float | None = step(DEGREE_PER_SECOND)
    azimuth_deg: float = number(90.0, -360.0, 360.0)
    latitude_deg: float = number(34.25, -90.0, 90.0)

    @cached_property
    def surroundings(self) -> Mapping[str, Vector]:
        """Gravity, and the Earth's rate along the outer axis, across it, and up."""
        latitude, azimuth = math.radians(self.latitude_deg), math.radians(self.azimuth_deg)
        level = math.cos(latitude)
        earth = (level * math.cos(azimuth), level * math.sin(azimuth), math.sin(latitude))
        return {"specific_force": UP, "angular_rate": earth}
