"""Checks of options, with one kind of message for all."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from numbers import Integral, Real
from typing import Any, TypeGuard

import numpy as np

from acalx.errors import ArgumentError, Option

__all__ = [
    "is_number",
    "is_whole",
    "keep",
    "kept",
    "require_confidence",
    "require_count",
    "require_limits",
    "require_number",
    "require_part",
    "require_points",
    "require_positive",
    "require_seed",
    "require_speeds",
    "require_step",
    "require_steps",
    "require_switch",
]


def is_number(value: object) -> TypeGuard[float]:
    """Whether it is a finite number, Python's or numpy's; true and false are none."""
    if not isinstance(value, Real) or isinstance(value, bool):
        return False
    try:
        return math.isfinite(float(value))
    except OverflowError:  # a whole number that no double holds
        return False


def is_whole(value: object) -> TypeGuard[int]:
    """Whether it is a whole number by its type, Python's or numpy's; true and false are none."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def kept(value: Any) -> Any:
    """An option as a part keeps it: lists, arrays and what is in them as tuples, mappings copied.

    What is changed later changes no part, and equal options make equal parts.
    """
    if isinstance(value, np.ndarray):
        return kept(value.tolist())
    if isinstance(value, list | tuple):
        return tuple(map(kept, value))
    return {key: kept(entry) for key, entry in value.items()} if isinstance(value, Mapping) else value


def keep(part: object, *names: str) -> None:
    """Keep these options of a frozen dataclass as `kept` has them."""
    for name in names:
        object.__setattr__(part, name, kept(getattr(part, name)))


def require_confidence(value: object) -> None:
    """Raise ArgumentError unless it is a probability that intervals can have, from 0.5 to less than 1."""
    if not is_number(value) or not 0.5 <= value < 1.0:
        raise ArgumentError.of("confidence", value, "give a probability from 0.5 to less than 1, such as 0.95")


def require_count(name: str, value: object) -> None:
    """Raise ArgumentError unless the option is a whole number of at least 1."""
    if not is_whole(value) or value < 1:
        raise ArgumentError.of(name, value, "must be a whole number of at least 1")


def require_positive(name: str, value: object) -> None:
    """Raise ArgumentError unless the option is a positive finite number."""
    if not is_number(value) or value <= 0:
        raise ArgumentError.of(name, value, "must be a positive number")


def require_number(name: str, value: object, lower: float, upper: float, unit: str = "degrees") -> float:
    """A number within limits, or ArgumentError."""
    if not is_number(value) or not lower <= value <= upper:
        raise ArgumentError.of(name, value, f"must be a number of {unit} from {lower:g} to {upper:g}")
    return float(value)


def require_limits(name: str, value: object, unit: str = "degrees") -> tuple[float, float]:
    """A lower and an upper limit, or ArgumentError."""
    if not (isinstance(value, Sequence) and not isinstance(value, str) and len(value) == 2):
        raise ArgumentError(
            "{given}: give a lower and an upper limit in {unit}, as in {example}",
            given=Option(name, value),
            unit=unit,
            example=Option(name, [-180, 180], "(-180, 180)"),
        )
    lower, upper = value
    if not (is_number(lower) and is_number(upper)):
        raise ArgumentError.of(name, value, f"both limits must be finite numbers of {unit}")
    return float(lower), float(upper)


def require_step(name: str, value: object, unit: str = "degrees") -> float | None:
    """A number or None, or ArgumentError; its size is for the setting to judge."""
    if value is not None and not is_number(value):
        raise ArgumentError(
            "{given}: a step is a number of {unit}, or {none} for none",
            given=Option(name, value),
            unit=unit,
            none=Option(name, None),
        )
    return value


def require_steps(name: str, value: object, count: int) -> tuple[float | None, ...]:
    """One step for all of some angles or one for each, in degrees, or ArgumentError."""
    if not isinstance(value, Sequence) or isinstance(value, str):
        return (require_step(name, value),) * count
    if len(value) != count:
        raise ArgumentError.of(name, list(value), f"give one step for all angles or {count}, one for each")
    return tuple(require_step(name, step) for step in value)


def require_speeds(name: str, value: object, count: int) -> tuple[float, ...]:
    """One speed for all of some axes or one for each, in degrees per second, as rad/s, or ArgumentError."""
    each = tuple(value) if isinstance(value, Sequence) and not isinstance(value, str) else (value,) * count
    speeds = tuple(math.radians(speed) for speed in each if is_number(speed) and speed > 0)
    if len(speeds) != len(each) or len(each) != count:
        raise ArgumentError.of(
            name, value, f"give a positive number of degrees per second, or {count} of them, one for each axis"
        )
    return speeds


def require_switch(name: str, value: object) -> bool:
    """True or false, or ArgumentError."""
    if not isinstance(value, bool | np.bool_):
        raise ArgumentError.of(name, value, "must be true or false")
    return bool(value)


def require_part(name: str, value: object, kind: type | tuple[type, ...]) -> None:
    """Raise ArgumentError unless the argument is a part of this kind, made, and not its class or its name."""
    if isinstance(value, kind):
        return
    wanted = " or ".join(each.__name__ for each in (kind if isinstance(kind, tuple) else (kind,)))
    made = f"; make one, as in {value.__name__}()" if isinstance(value, type) else ""
    raise ArgumentError.of(name, value, f"must be {'an' if wanted[0] in 'AEIO' else 'a'} {wanted}{made}")


def require_points(name: str, value: object, objectives: int = 2) -> None:
    """Raise ArgumentError unless the option is a whole number that a front of so many objectives can have."""
    require_count(name, value)
    if is_whole(value) and value < objectives:
        raise ArgumentError.of(name, value, f"a front of {objectives} objectives has {objectives} ends or more")


def require_seed(value: object) -> None:
    """Raise ArgumentError unless it is a seed of a random generator."""
    if not is_whole(value) or value < 0:
        raise ArgumentError.of("seed", value, "the seed must be a whole number, 0 or more")
