"""One adjustable angle of a stand."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from acalx.arrays import Array
from acalx.errors import ArgumentError, CompatibilityError

__all__ = ["Setting"]

_TURN = 2.0 * math.pi
# Relative slack when comparing angles that went through degrees and back.
_SLACK = 1e-9


@dataclass(frozen=True)
class Setting:
    """One adjustable angle of a stand.

    Parameters
    ----------
    name : str
        Its name; files and the command line add the unit, ``alpha1`` is ``alpha1_deg`` there.
    lower, upper : float, in rad
        Limits, both allowed.
    step : float, in rad, optional
        Resolution: the angle stops at whole multiples of it only. None: anywhere.
    periodic : bool
        Whether a full turn more is the same position.
    """

    name: str
    lower: float
    upper: float
    step: float | None = None
    periodic: bool = True

    def __post_init__(self) -> None:
        for name, value in (("lower", self.lower), ("upper", self.upper), ("step", self.step or 0.0)):
            if not isinstance(value, (int, float)):
                raise ArgumentError(f"{self.name}: {name}={value!r}: must be a number, in rad")
        if not isinstance(self.periodic, bool):
            raise ArgumentError(f"{self.name}: periodic={self.periodic!r}: must be true or false")
        limits = f"[{math.degrees(self.lower):g}, {math.degrees(self.upper):g}]"
        if not (math.isfinite(self.lower) and math.isfinite(self.upper)):
            raise ArgumentError(f"{self.name}_deg={limits}: bounds must be finite numbers of degrees")
        if self.lower >= self.upper:
            raise ArgumentError(f"{self.name}_deg={limits}: the lower bound must be below the upper one")
        if self.periodic and self.upper - self.lower > _TURN * (1 + _SLACK):
            raise ArgumentError(f"{self.name}_deg={limits}: a periodic angle spans 360 degrees at most")
        if self.step is not None:
            if not (math.isfinite(self.step) and self.step > 0):
                raise ArgumentError(
                    f"step_deg={math.degrees(self.step):g}: a step must be a positive number of degrees"
                )
            if not self.full_turn and math.floor(self._last) < math.ceil(self._first):
                raise ArgumentError(
                    f"{self.name}_deg={limits} holds no multiple of the step of {math.degrees(self.step):g} degrees"
                )

    @property
    def full_turn(self) -> bool:
        """Whether every angle can be set, so that the limits are no limits."""
        return self.periodic and self.upper - self.lower >= _TURN * (1 - _SLACK)

    @property
    def _first(self) -> float:
        assert self.step is not None
        return self.lower / self.step * (1 - math.copysign(_SLACK, self.lower))

    @property
    def _last(self) -> float:
        assert self.step is not None
        return self.upper / self.step * (1 + math.copysign(_SLACK, self.upper))

    def stops(self) -> Array:
        """All the angles of a stepped setting, in rad, ascending."""
        if self.step is None:
            raise CompatibilityError(f"{self.name} has no steps: it stops anywhere")
        stops = np.arange(math.ceil(self._first), math.floor(self._last) + 1) * self.step
        if self.full_turn and len(stops) > 1:
            stops = stops[stops < stops[0] + _TURN * (1 - _SLACK)]
        return np.clip(stops, self.lower, self.upper)

    def wrap(self, angles: Array) -> Array:
        """The same positions with whole turns taken off, inside the limits where that is possible."""
        if not self.periodic:
            return angles
        middle = 0.5 * (self.lower + self.upper)
        wrapped = np.where(
            (angles < self.lower) | (angles > self.upper),
            angles - _TURN * np.round((angles - middle) / _TURN),
            angles,
        )
        return np.clip(wrapped, self.lower, self.upper) if self.full_turn else wrapped

    def reach(self, angles: Array) -> Array:
        """The same attitudes with whole turns added so that they are within the limits, where some are."""
        turns = np.ceil((self.lower - angles) / _TURN - _SLACK)
        inside = angles + _TURN * turns
        return np.where(inside <= self.upper * (1 + math.copysign(_SLACK, self.upper)), inside, angles)

    def allows(self, angles: Array, tolerance: float = 1e-9) -> np.ndarray:
        """Whether angles are within the limits and on a step, within a tolerance in rad."""
        wrapped = self.wrap(angles)
        inside = (wrapped >= self.lower - tolerance) & (wrapped <= self.upper + tolerance)
        if self.step is None:
            return inside
        return np.asarray(inside & (np.abs(wrapped - self.step * np.round(wrapped / self.step)) <= tolerance))
