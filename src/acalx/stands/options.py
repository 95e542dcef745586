"""Options that several stands have, checked with one kind of message."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeGuard

from acalx.errors import ArgumentError
from acalx.quantities.units import DEGREE, Unit
from acalx.stands.base import Setting

__all__ = [
    "angle",
    "require_limits",
    "require_number",
    "require_speeds",
    "require_step",
    "require_steps",
    "require_switch",
]


def require_number(name: str, value: object, lower: float, upper: float, unit: Unit = DEGREE) -> float:
    """A number within limits, or ArgumentError."""
    if not _is_number(value) or not lower <= value <= upper:
        raise ArgumentError(f"{name}={value}: must be a number of {unit.plural} from {lower:g} to {upper:g}")
    return float(value)


def require_limits(name: str, value: object, unit: Unit = DEGREE) -> tuple[float, float]:
    """A lower and an upper limit, or ArgumentError."""
    if not (isinstance(value, Sequence) and not isinstance(value, str) and len(value) == 2):
        raise ArgumentError(
            f"{name}={value}: give a lower and an upper limit in {unit.plural}, as in {name}=[-180,180]"
        )
    lower, upper = value
    if not (_is_number(lower) and _is_number(upper)):
        raise ArgumentError(f"{name}=[{lower}, {upper}]: both limits must be finite numbers of {unit.plural}")
    return float(lower), float(upper)


def require_step(name: str, value: object, unit: Unit = DEGREE) -> None:
    """Raise ArgumentError unless it is a number or None; `Setting` looks at its size."""
    if value is not None and not _is_number(value):
        raise ArgumentError(f"{name}={value}: a step is a number of {unit.plural}, or null for none")


def require_steps(name: str, value: object, count: int) -> tuple[float | None, ...]:
    """One step for all of some angles or one for each, in degrees, or ArgumentError."""
    if not isinstance(value, Sequence) or isinstance(value, str):
        require_step(name, value)
        return (value,) * count  # type: ignore[return-value]  # looked at by require_step
    if len(value) != count:
        raise ArgumentError(f"{name}={list(value)}: give one step for all angles or {count}, one for each")
    for step in value:
        require_step(name, step)
    return tuple(value)


def require_speeds(name: str, value: object, count: int) -> tuple[float, ...]:
    """One speed for all of some axes or one for each, in degrees per second, as rad/s, or ArgumentError."""
    each = tuple(value) if isinstance(value, Sequence) and not isinstance(value, str) else (value,) * count
    speeds = tuple(math.radians(speed) for speed in each if _is_number(speed) and speed > 0)
    if len(speeds) != len(each) or len(each) != count:
        raise ArgumentError(
            f"{name}={value}: give a positive number of degrees per second, or {count} of them, one for each axis"
        )
    return speeds


def require_switch(name: str, value: object) -> None:
    """Raise ArgumentError unless it is true or false."""
    if not isinstance(value, bool):
        raise ArgumentError(f"{name}={value}: must be true or false")


def angle(name: str, limits_deg: Sequence[float], step_deg: float | None, periodic: bool) -> Setting:
    """A setting from options in degrees."""
    lower, upper = limits_deg
    step = None if step_deg is None else math.radians(step_deg)
    return Setting(name, math.radians(lower), math.radians(upper), step, periodic)


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
