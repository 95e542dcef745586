"""One adjustable angle of a stand, or a rate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Real

import numpy as np

from acalx.errors import ArgumentError, CompatibilityError, Option
from acalx.numerics.arrays import Array
from acalx.options import require_limits, require_switch
from acalx.quantities.units import DEGREE, Unit

__all__ = ["Setting"]

_TURN = 2.0 * math.pi
# Relative slack when comparing angles that went through degrees and back.
_SLACK = 1e-9
_MOST_STOPS = 10_000_000


@dataclass(frozen=True)
class Setting:
    """One adjustable angle of a stand, or a rate or another quantity that it can set.

    Parameters
    ----------
    name : str
        Its name; files and the command line add the unit, ``alpha1`` is ``alpha1_deg`` there.
    lower, upper : float, in rad or the SI unit of what is set
        Limits, both allowed.
    step : float, in the same unit, optional
        Resolution: the setting stops at whole multiples of it only. None: anywhere.
    periodic : bool
        Whether a full turn more is the same position; for angles only.
    unit : Unit
        What people read and write it in; degrees for an angle.
    """

    name: str
    lower: float
    upper: float
    step: float | None = None
    periodic: bool = True
    unit: Unit = DEGREE
    speed: float = math.inf

    def __post_init__(self) -> None:
        for name, value in (("lower", self.lower), ("upper", self.upper), ("step", self.step or 0.0)):
            if not isinstance(value, Real):
                raise ArgumentError(f"{self.name}: {name}={value!r}: must be a number, in rad")
        object.__setattr__(self, "periodic", require_switch("periodic", self.periodic))
        if self.periodic and self.unit.turn is None:
            raise ArgumentError(f"{self.column}: only an angle is periodic, not what is in {self.unit.plural}")

        def refused(rule: str) -> ArgumentError:
            return ArgumentError("{given}: {rule}", given=self.limits, rule=rule)

        if not (math.isfinite(self.lower) and math.isfinite(self.upper)):
            raise refused(f"bounds must be finite numbers of {self.unit.plural}")
        if self.lower >= self.upper:
            raise refused("the lower bound must be below the upper one")
        if self.periodic and self.upper - self.lower > _TURN * (1 + _SLACK):
            raise refused("a periodic angle spans 360 degrees at most")
        if self.step is not None:
            self._check_step(self.step)
        if self.step is not None and not self.full_turn and math.floor(self._last) < math.ceil(self._first):
            step = f"{self.step / self.unit.size:g} {self.unit.plural}"
            raise refused(f"holds no multiple of the step of {step}")

    def _check_step(self, step: float) -> None:
        # one step for all angles, and another for a rate
        option = self.unit.column("step" if self.unit.turn else f"{self.name}_step")
        given = _short(step / self.unit.size)
        if not (math.isfinite(step) and step > 0):
            raise ArgumentError.of(option, given, f"a step must be a positive number of {self.unit.plural}")
        if (self.upper - self.lower) / step > _MOST_STOPS:
            raise ArgumentError.of(option, given, f"gives more than {_MOST_STOPS:,} stops; leave the step out")

    @classmethod
    def in_unit(
        cls,
        name: str,
        limits: Sequence[float],
        step: float | None,
        periodic: bool = True,
        unit: Unit = DEGREE,
        speed: float = math.inf,
    ) -> Setting:
        """A setting from limits, a step and a speed in its unit, as people write them."""
        lower, upper = require_limits(unit.column(name), limits, unit.plural)
        size = None if step is None else float(unit.read(step))
        ends = float(unit.read(lower)), float(unit.read(upper))
        return cls(name, *ends, size, periodic, unit, float(unit.read(speed)))

    @property
    def angle(self) -> bool:
        """Whether it is an angle, and no rate or other quantity."""
        return self.unit.turn is not None

    @property
    def rest(self) -> float:
        """Where it is at rest: 0, or what of its limits and steps is nearest to that."""
        if self.step is not None:
            return float(self.nearest(np.zeros(())))
        return min(max(0.0, self.lower), self.upper)

    @property
    def column(self) -> str:
        """Its name with the unit, as in files and on the command line."""
        return self.unit.column(self.name)

    @property
    def limits(self) -> Option:
        """Its limits as an option."""
        return Option(self.column, [_short(self.lower / self.unit.size), _short(self.upper / self.unit.size)])

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
        """All that a stepped setting can take, in rad or the SI unit, ascending."""
        if self.step is None:
            raise CompatibilityError(f"{self.name} has no steps: it stops anywhere")
        stops = np.arange(math.ceil(self._first), math.floor(self._last) + 1) * self.step
        if self.full_turn and len(stops) > 1:
            stops = stops[stops < stops[0] + _TURN * (1 - _SLACK)]
        return np.clip(stops, self.lower, self.upper)

    def nearest(self, angles: Array) -> Array:
        """The stop of a stepped setting that is nearest to each angle."""
        stops = self.stops()
        middle = 0.5 * (stops[0] + stops[-1])
        if self.periodic:
            angles = angles - _TURN * np.round((angles - middle) / _TURN)
        index = np.clip(np.searchsorted(stops, angles), 1, max(1, len(stops) - 1))
        below, above = stops[index - 1], stops[np.minimum(index, len(stops) - 1)]
        return np.where(angles - below < above - angles, below, above)

    def wrap(self, angles: Array) -> Array:
        """The same positions with whole turns taken off, inside the limits where that is possible."""
        if not self.periodic:
            return angles
        outside = (angles < self.lower) | (angles > self.upper)
        if not outside.any():
            return angles
        middle = 0.5 * (self.lower + self.upper)
        wrapped = np.where(outside, angles - _TURN * np.round((angles - middle) / _TURN), angles)
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


def _short(value: float) -> float:
    """A number as people write it: six digits, and whole without a point."""
    short = float(f"{value:g}")
    return int(short) if short.is_integer() else short
