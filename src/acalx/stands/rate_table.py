"""The rate table."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from acalx.numerics.arrays import Array, components, sin_cos
from acalx.quantities.stimulus import EARTH_RATE, Stimulus
from acalx.quantities.units import DEGREE_PER_SECOND
from acalx.stands.base import Setting, Stand
from acalx.stands.options import angle, require_limits, require_number, require_speeds, require_step, require_switch
from acalx.stands.zones import Zone, read_zones

__all__ = ["RateTable"]


@final
@dataclass(frozen=True)
class RateTable(Stand):
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
    step_deg : float, degrees, optional
        Both angles stop at whole multiples of it. None: anywhere.
    latitude_deg : float, degrees
        North is positive.
    periodic : bool
        Whether 360 degrees more of an angle is the same setting.
    forbidden : sequence of mappings
        Boxes of settings that must not be taken, as of `TwoAxis`, by ``alpha1_deg, alpha2_deg``
        and ``rate_deg_s``.
    forbidden_if : str or callable
        Function that says the same, as of `TwoAxis`.
    speed_deg_s : float or pair of float, degrees per second
        How fast the angles of the fixture turn, all or each; for the order of visit. The rate changes meanwhile.

    Raises
    ------
    ArgumentError
        Limits the wrong way round or not finite, a latitude beyond a pole, a step that is not
        positive.

    Source: IEEE Std 1431-2004, rate-table tests.
    """

    rate_deg_s: Sequence[float] = (-50.0, 50.0)
    alpha1_deg: Sequence[float] = (0.0, 360.0)
    alpha2_deg: Sequence[float] = (0.0, 360.0)
    rate_step_deg_s: float | None = None
    step_deg: float | None = None
    latitude_deg: float = 34.25
    periodic: bool = True
    forbidden: Sequence[Mapping[str, Sequence[float]]] = ()
    forbidden_if: str | Callable[..., Any] | None = None
    speed_deg_s: float | Sequence[float] = 10.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "rate_deg_s", require_limits("rate_deg_s", self.rate_deg_s, DEGREE_PER_SECOND))
        for name in ("alpha1_deg", "alpha2_deg"):
            object.__setattr__(self, name, require_limits(name, getattr(self, name)))
        require_step("rate_step_deg_s", self.rate_step_deg_s, DEGREE_PER_SECOND)
        require_step("step_deg", self.step_deg)
        require_number("latitude_deg", self.latitude_deg, -90.0, 90.0)
        require_switch("periodic", self.periodic)
        _ = self.speeds
        _ = self.settings, self.zones  # built once here so that bad ones are refused at construction

    @cached_property
    def settings(self) -> tuple[Setting, ...]:
        """The two angles of the fixture, and the rate."""
        lower, upper = self.rate_deg_s
        step = None if self.rate_step_deg_s is None else math.radians(self.rate_step_deg_s)
        return (
            angle("alpha1", self.alpha1_deg, self.step_deg, self.periodic),
            angle("alpha2", self.alpha2_deg, self.step_deg, self.periodic),
            Setting("rate", math.radians(lower), math.radians(upper), step, False, DEGREE_PER_SECOND),
        )

    @cached_property
    def zones(self) -> tuple[Zone, ...]:
        """The forbidden boxes, then what the function says."""
        return read_zones(self.settings, self.forbidden, self.forbidden_if)

    @property
    def speeds(self) -> Array:
        """Of both angles, in rad/s; the rate changes in no time."""
        return np.array((*require_speeds("speed_deg_s", self.speed_deg_s, 2), np.inf))

    def stimulus(self, settings: Array) -> Stimulus:
        """The vertical and the rate in sensor axes: settings (..., n, 3) in rad and rad/s."""
        sin, cos = sin_cos(settings[..., :2])
        cos1 = cos[..., 0]
        vertical = components(sin[..., 0], cos1 * sin[..., 1], cos1 * cos[..., 1])
        return Stimulus(specific_force=vertical, angular_rate=self._turning(settings)[..., None] * vertical)

    def derivative(self, settings: Array) -> Stimulus:
        """Derivatives of both, (..., n, 3, 3)."""
        sin, cos = sin_cos(settings[..., :2])
        sin1, sin2, cos1, cos2 = sin[..., 0], sin[..., 1], cos[..., 0], cos[..., 1]
        zero = np.zeros_like(sin1)
        vertical = components(sin1, cos1 * sin2, cos1 * cos2)
        by_alpha1 = components(cos1, -sin1 * sin2, -sin1 * cos2)
        by_alpha2 = components(zero, cos1 * cos2, -cos1 * sin2)
        turning = self._turning(settings)[..., None]
        return Stimulus(
            specific_force=components(by_alpha1, by_alpha2, np.zeros_like(vertical)),
            angular_rate=components(turning * by_alpha1, turning * by_alpha2, vertical / EARTH_RATE),
        )

    def _turning(self, settings: Array) -> Array:
        """The rate about the vertical in units of the Earth's rate."""
        return np.asarray(settings[..., 2] / EARTH_RATE + math.sin(math.radians(self.latitude_deg)))
