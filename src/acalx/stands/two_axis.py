"""The two-axis table."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from acalx.arrays import Array, components, sin_cos
from acalx.errors import ArgumentError
from acalx.stands.base import Setting, Stand
from acalx.stands.zones import Zone, read_zones
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
    forbidden: Sequence[Mapping[str, Sequence[float]]] = ()
    forbidden_if: str | Callable[..., Any] | None = None

    def __post_init__(self) -> None:
        for name in ("alpha1_deg", "alpha2_deg"):
            object.__setattr__(self, name, _pair(name, getattr(self, name)))
        if isinstance(self.step_deg, Sequence) and not isinstance(self.step_deg, str):
            object.__setattr__(self, "step_deg", tuple(self.step_deg))
        if len(self._steps) != 2 or not all(step is None or _is_number(step) for step in self._steps):
            raise ArgumentError(
                f"step_deg={self.step_deg}: a step is a number of degrees, or null for none, or a pair of them"
            )
        if not isinstance(self.periodic, bool):
            raise ArgumentError(f"periodic={self.periodic}: must be true or false")
        _ = self.settings, self.zones  # built once here so that bad ones are refused at construction

    @cached_property
    def settings(self) -> tuple[Setting, ...]:
        """The two angles, alpha1 and alpha2."""
        limits = (("alpha1", self.alpha1_deg), ("alpha2", self.alpha2_deg))
        return tuple(
            Setting(
                name,
                math.radians(lower),
                math.radians(upper),
                None if step is None else math.radians(step),
                self.periodic,
            )
            for (name, (lower, upper)), step in zip(limits, self._steps, strict=True)
        )

    @property
    def _steps(self) -> tuple[float | None, ...]:
        return self.step_deg if isinstance(self.step_deg, tuple) else (self.step_deg,) * 2

    @cached_property
    def zones(self) -> tuple[Zone, ...]:
        """The forbidden boxes, then what the function says."""
        names, periodic = [f"{name}_deg" for name in self.names], [self.periodic] * 2
        return read_zones(names, periodic, self.forbidden, self.forbidden_if)

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
