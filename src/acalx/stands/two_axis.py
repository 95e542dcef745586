"""The two-axis table."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from acalx.numerics.arrays import Array, components, sin_cos
from acalx.quantities.stimulus import Stimulus
from acalx.stands.base import Setting, Stand
from acalx.stands.options import angle, require_limits, require_number, require_speeds, require_steps, require_switch
from acalx.stands.zones import Zone, read_zones

__all__ = ["TwoAxis"]


@final
@dataclass(frozen=True)
class TwoAxis(Stand):
    """A table with two axes, which brings the vertical to any direction of the sensor.

    The unit vector of the vertical in sensor axes is
    (sin a1, cos a1 sin a2, cos a1 cos a2). Every direction is reached by two pairs of
    angles, (a1, a2) and (180 - a1, a2 + 180).

    Parameters
    ----------
    alpha1_deg, alpha2_deg : pair of float, degrees
        Lower and upper limit of each angle.
    step_deg : float or pair of float, degrees, optional
        Resolution of the table, of both angles or of each: they stop at whole multiples of it.
        None: anywhere.
    periodic : bool
        Whether 360 degrees more is the same setting. Without it, angles are not wrapped, and
        limits may span more than a turn.
    forbidden : sequence of mappings, degrees
        Boxes of settings that must not be taken, as ``{"alpha1_deg": (80, 100), "alpha2_deg":
        (170, 190)}``; an angle that is left out may be any. The edge of a box is allowed.
    forbidden_if : str or callable
        Function of arrays ``alpha1_deg, alpha2_deg``, true where a setting must not be taken;
        or where it is, as ``module.function``.
    dip_deg : float, degrees, optional
        How far the magnetic field points below the horizon. None: the field plays no part.
    field_azimuth_deg : float, degrees
        Of the field's horizontal part, from the table's x axis at zero angles towards y, the
        axis of alpha1.
    speed_deg_s : float or pair of float, degrees per second
        How fast the angles turn, all or each; for the order of visit.

    Raises
    ------
    ArgumentError
        Limits the wrong way round or not finite, a step that is not positive, zones that are
        not understood.

    Source: Egorov, Kiryachenko, Popov (2021); the mapping reproduces their printed programs.
    """

    alpha1_deg: Sequence[float] = (0.0, 360.0)
    alpha2_deg: Sequence[float] = (0.0, 360.0)
    step_deg: float | Sequence[float | None] | None = None
    periodic: bool = True
    dip_deg: float | None = None
    field_azimuth_deg: float = 0.0
    forbidden: Sequence[Mapping[str, Sequence[float]]] = ()
    forbidden_if: str | Callable[..., Any] | None = None
    speed_deg_s: float | Sequence[float] = 10.0

    def __post_init__(self) -> None:
        for name in ("alpha1_deg", "alpha2_deg"):
            object.__setattr__(self, name, require_limits(name, getattr(self, name)))
        _ = self._steps
        require_switch("periodic", self.periodic)
        if self.dip_deg is not None:
            require_number("dip_deg", self.dip_deg, -90.0, 90.0)
        require_number("field_azimuth_deg", self.field_azimuth_deg, -360.0, 360.0)
        _ = self.speeds
        _ = self.settings, self.zones  # built once here so that bad ones are refused at construction

    @cached_property
    def settings(self) -> tuple[Setting, ...]:
        """The two angles, alpha1 and alpha2."""
        return (
            angle("alpha1", self.alpha1_deg, self._steps[0], self.periodic),
            angle("alpha2", self.alpha2_deg, self._steps[1], self.periodic),
        )

    def advice(self, quantity: str) -> str:
        """The field is there where its dip is given."""
        return " unless its dip is given, as in stand.dip_deg=65" if quantity == "magnetic_field" else ""

    @property
    def _steps(self) -> tuple[float | None, ...]:
        return require_steps("step_deg", self.step_deg, 2)

    @cached_property
    def zones(self) -> tuple[Zone, ...]:
        """The forbidden boxes, then what the function says."""
        return read_zones(self.settings, self.forbidden, self.forbidden_if)

    @property
    def speeds(self) -> Array:
        """Of both angles, in rad/s."""
        return np.array(require_speeds("speed_deg_s", self.speed_deg_s, 2))

    @property
    def frequencies(self) -> tuple[int, ...]:
        """One in each angle."""
        return (1, 1)

    def stimulus(self, settings: Array) -> Stimulus:
        """The vertical in sensor axes: settings (..., n, 2) in rad."""
        sin, cos = sin_cos(settings)
        cos1 = cos[..., 0]
        vertical = components(sin[..., 0], cos1 * sin[..., 1], cos1 * cos[..., 1])
        return Stimulus(specific_force=vertical, magnetic_field=None if self.dip_deg is None else self._field(sin, cos))

    def derivative(self, settings: Array) -> Stimulus:
        """Derivative of the vertical, (..., n, 3, 2)."""
        sin, cos = sin_cos(settings)
        sin1, sin2, cos1, cos2 = sin[..., 0], sin[..., 1], cos[..., 0], cos[..., 1]
        by_alpha1 = components(cos1, -sin1 * sin2, -sin1 * cos2)
        by_alpha2 = components(np.zeros_like(sin1), cos1 * cos2, -cos1 * sin2)
        vertical = components(by_alpha1, by_alpha2)
        return Stimulus(vertical, magnetic_field=None if self.dip_deg is None else self._field_derivative(sin, cos))

    @cached_property
    def _level_field(self) -> tuple[float, float, float]:
        """The field in the axes of the sensor at zero angles, z up."""
        assert self.dip_deg is not None  # else there is no field
        dip, azimuth = math.radians(self.dip_deg), math.radians(self.field_azimuth_deg)
        return math.cos(dip) * math.cos(azimuth), math.cos(dip) * math.sin(azimuth), -math.sin(dip)

    def _field(self, sin: Array, cos: Array) -> Array:
        """Turned about y by alpha1, then about x by alpha2, as the vertical is."""
        sin1, sin2, cos1, cos2 = sin[..., 0], sin[..., 1], cos[..., 0], cos[..., 1]
        x, y, z = self._level_field
        up = z * cos1 - x * sin1
        return components(x * cos1 + z * sin1, y * cos2 + up * sin2, up * cos2 - y * sin2)

    def _field_derivative(self, sin: Array, cos: Array) -> Array:
        sin1, sin2, cos1, cos2 = sin[..., 0], sin[..., 1], cos[..., 0], cos[..., 1]
        x, y, z = self._level_field
        up, fall = z * cos1 - x * sin1, -z * sin1 - x * cos1
        by_alpha1 = components(-x * sin1 + z * cos1, fall * sin2, fall * cos2)
        by_alpha2 = components(np.zeros_like(sin1), up * cos2 - y * sin2, -up * sin2 - y * cos2)
        return components(by_alpha1, by_alpha2)

    def equivalents(self, settings: Array) -> Array:
        """(a1, a2) and (180 - a1, a2 + 180), which show the same vertical; not the same field."""
        if self.dip_deg is not None:
            return settings[None]
        other = np.stack([math.pi - settings[..., 0], settings[..., 1] + math.pi], axis=-1)
        other = np.stack([setting.reach(other[..., k]) for k, setting in enumerate(self.settings)], axis=-1)
        return np.stack([settings, np.where(self.axes.allows(other)[..., None], other, settings)])

    def aim(self, directions: Array) -> Array:
        """Settings for directions of the vertical in sensor axes, the pair that the limits allow."""
        x, y, z = np.moveaxis(directions, -1, 0)
        first = np.stack([np.arctan2(x, np.hypot(y, z)), np.arctan2(y, z)], axis=-1)
        first = np.where(np.abs(first) < 1e-15, 0.0, first)  # not a turn less a rounding error
        second = np.stack([math.pi - first[..., 0], first[..., 1] + math.pi], axis=-1)
        # along the first axis the second angle does not matter
        return self.either(first, second, free=np.hypot(y, z) < 1e-12)
