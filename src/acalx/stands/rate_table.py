"""The rate table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import ClassVar, final

import numpy as np

from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import EARTH_RATE, Stimulus
from acalx.quantities.units import DEGREE_PER_SECOND
from acalx.stands.base import Setting
from acalx.stands.fields import limits, number, step
from acalx.stands.rotary import Rotary
from acalx.stands.turns import UP, Vector, derivatives, differentiated, turned, vectors

__all__ = ["RateTable"]


@final
@dataclass(frozen=True)
class RateTable(Rotary):
    """A table that turns about the vertical, with a two-axis fixture that holds the sensor on it.

    A position is an attitude of the sensor on the table and a rate of the table. With the
    vertical e in sensor axes, as of `TwoAxis`,

        e = (sin a1, cos a1 sin a2, cos a1 cos a2),   a = e  in g,
        w = (rate + sin(latitude) Earth rate) e.

    A reading is a mean over whole turns of the table, so that the horizontal part of the
    Earth's rate cancels; at a rate of 0 it is the mean of opposite headings. The sensor is near
    the axis, so that no centripetal acceleration counts.

    Parameters
    ----------
    rate_deg_s : pair of float, degrees per second
        Limits of the table's rate, counterclockwise seen from above.
    alpha1_deg, alpha2_deg : pair of float, degrees
        Limits of the angles of the fixture.
    rate_step_deg_s : float, degrees per second, optional
        The rate is a whole multiple of it. None: any.
    latitude_deg : float, degrees
        North is positive.
    step_deg, periodic
        Of the fixture, as of `Rotary`.
    forbidden, forbidden_if, speed_deg_s
        As of `Stand`; ``rate_deg_s`` is a setting too.

    Raises
    ------
    ArgumentError
        Limits the wrong way round or not finite, a latitude beyond a pole, a step that is not
        positive.

    Source: IEEE Std 1431-2004, rate-table tests.
    """

    turns: ClassVar[Mapping[str, str]] = {"alpha1": "-y", "alpha2": "x"}
    surroundings: ClassVar[Mapping[str, Vector]] = {"specific_force": UP}
    frequencies: ClassVar[tuple[int, ...]] = (1, 1, 1)
    rate_deg_s: Sequence[float] = limits(-50.0, 50.0, DEGREE_PER_SECOND)
    alpha1_deg: Sequence[float] = limits(0.0, 360.0)
    alpha2_deg: Sequence[float] = limits(0.0, 360.0)
    _: KW_ONLY
    rate_step_deg_s: float | None = step(DEGREE_PER_SECOND)
    latitude_deg: float = number(34.25, -90.0, 90.0)

    @cached_property
    def settings(self) -> tuple[Setting, ...]:
        """The two angles of the fixture, and the rate."""
        return (*self.angles, Setting.in_unit("rate", self.rate_deg_s, self.rate_step_deg_s, False, DEGREE_PER_SECOND))

    def stimulus(self, settings: Array) -> Stimulus:
        """The vertical and the rate in sensor axes: settings (..., n, 3) in rad and rad/s."""
        vertical = vectors(turned(UP, self.turns_at(settings)), settings.shape[:-1])
        return Stimulus(specific_force=vertical, angular_rate=_turning(self, settings)[..., None] * vertical)

    def derivative(self, settings: Array) -> Stimulus:
        """Derivatives of both, (..., n, 3, 3)."""
        vertical, by_angle = differentiated(UP, self.turns_at(settings))
        by_force = derivatives([*by_angle, (None, None, None)], settings.shape[:-1])
        by_rate = _turning(self, settings)[..., None, None] * by_force
        by_rate[..., 2] = vectors(vertical, settings.shape[:-1]) / EARTH_RATE
        return Stimulus(specific_force=by_force, angular_rate=by_rate)


def _turning(table: RateTable, settings: Array) -> Array:
    """The rate about the vertical in units of the Earth's rate."""
    return np.asarray(settings[..., 2] / EARTH_RATE + math.sin(math.radians(table.latitude_deg)))
