"""The two-axis table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from acalx.arrays import Array, components, sin_cos
from acalx.errors import ArgumentError
from acalx.stands.base import Setting, Stand
from acalx.stimulus import Stimulus

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
    step_deg : float, degrees, optional
        Resolution of the table: both angles stop at whole multiples of it. None: anywhere.
    periodic : bool
        Whether 360 degrees more is the same setting. Without it, angles are not wrapped, and
        limits may span more than a turn.

    Raises
    ------
    ArgumentError
        Limits the wrong way round or not finite, a step that is not positive.

    Source: Egorov, Kiryachenko, Popov (2021); the mapping reproduces their printed programs.
    """

    alpha1_deg: Sequence[float] = (0.0, 360.0)
    alpha2_deg: Sequence[float] = (0.0, 360.0)
    step_deg: float | None = None
    periodic: bool = True

    def __post_init__(self) -> None:
        for name in ("alpha1_deg", "alpha2_deg"):
            object.__setattr__(self, name, _pair(name, getattr(self, name)))
        if self.step_deg is not None and not _is_number(self.step_deg):
            raise ArgumentError(f"step_deg={self.step_deg}: a step is a number of degrees, or null for none")
        if not isinstance(self.periodic, bool):
            raise ArgumentError(f"periodic={self.periodic}: must be true or false")
        _ = self.settings  # built once here so that bad limits are refused at construction

    @cached_property
    def settings(self) -> tuple[Setting, ...]:
        """The two angles, alpha1 and alpha2."""
        step = None if self.step_deg is None else math.radians(self.step_deg)
        return tuple(
            Setting(name, math.radians(lower), math.radians(upper), step, self.periodic)
            for name, (lower, upper) in (("alpha1", self.alpha1_deg), ("alpha2", self.alpha2_deg))
        )

    @property
    def frequencies(self) -> tuple[int, ...]:
        """One in each angle."""
        return (1, 1)

    def stimulus(self, settings: Array) -> Stimulus:
        """The vertical in sensor axes: settings (..., n, 2) in rad."""
        sin, cos = sin_cos(settings)
        cos1 = cos[..., 0]
        return Stimulus(specific_force=components(sin[..., 0], cos1 * sin[..., 1], cos1 * cos[..., 1]))

    def derivative(self, settings: Array) -> Stimulus:
        """Derivative of the vertical, (..., n, 3, 2)."""
        sin, cos = sin_cos(settings)
        sin1, sin2, cos1, cos2 = sin[..., 0], sin[..., 1], cos[..., 0], cos[..., 1]
        by_alpha1 = components(cos1, -sin1 * sin2, -sin1 * cos2)
        by_alpha2 = components(np.zeros_like(sin1), cos1 * cos2, -cos1 * sin2)
        return Stimulus(specific_force=components(by_alpha1, by_alpha2))

    def aim(self, directions: Array) -> Array:
        """Settings for directions of the vertical in sensor axes, the pair that the limits allow."""
        x, y, z = np.moveaxis(directions, -1, 0)
        first = np.stack([np.arctan2(x, np.hypot(y, z)), np.arctan2(y, z)], axis=-1)
        first = np.where(np.abs(first) < 1e-15, 0.0, first)  # not a turn less a rounding error
        second = np.stack([math.pi - first[..., 0], first[..., 1] + math.pi], axis=-1)
        for k, setting in enumerate(self.settings):
            first[..., k] = setting.reach(first[..., k])
            second[..., k] = setting.reach(second[..., k])
        inner = self.settings[1]
        free = np.hypot(y, z) < 1e-12  # along the first axis the second angle does not matter
        any_angle = min(max(0.0, inner.lower), inner.upper) if inner.step is None else inner.stops()[0]
        for angles in (first, second):
            angles[..., 1] = np.where(free & ~inner.allows(angles[..., 1]), any_angle, angles[..., 1])
        use_second = self.allows(second) & ~self.allows(first)
        return np.where(use_second[..., None], second, first)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _pair(name: str, value: object) -> tuple[float, float]:
    if not (isinstance(value, Sequence) and not isinstance(value, str) and len(value) == 2):
        raise ArgumentError(f"{name}={value}: give a lower and an upper limit in degrees, as in {name}=[-180,180]")
    lower, upper = value
    if not (_is_number(lower) and _is_number(upper)):
        raise ArgumentError(f"{name}=[{lower}, {upper}]: both limits must be finite numbers of degrees")
    return float(lower), float(upper)
