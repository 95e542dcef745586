"""Options of stands as fields of dataclasses that say what they take; a stand looks at them when it is made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field, fields
from typing import Any

import numpy as np

from acalx.options import kept, require_limits, require_number, require_step, require_switch
from acalx.quantities.units import DEGREE, Unit

__all__ = ["check_fields", "limits", "number", "step", "switch"]


def limits(lower: float, upper: float, unit: Unit = DEGREE) -> Any:
    """A lower and an upper limit of a setting, with these by default."""
    return _checked((lower, upper), lambda name, value: require_limits(name, value, unit.plural))


def number(default: float | None, lower: float, upper: float, unit: Unit = DEGREE) -> Any:
    """A number within limits; None too where that is the default."""

    def check(name: str, value: object) -> float | None:
        return None if default is None and value is None else require_number(name, value, lower, upper, unit.plural)

    return _checked(default, check)


def step(unit: Unit = DEGREE) -> Any:
    """A step, or None, the default."""
    return _checked(None, lambda name, value: require_step(name, value, unit.plural))


def switch(default: bool) -> Any:
    """An option that is on or off, with what it is by default."""
    return _checked(default, require_switch)


def check_fields(stand: Any) -> None:
    """Look at the options of a stand that is being made; keep numbers as numbers, pairs as pairs, lists as tuples.

    A list that is changed later changes no stand, and equal options make equal stands.

    Parameters
    ----------
    stand : dataclass
        With fields of the kinds above.

    Raises
    ------
    ArgumentError
        What an option does not take.
    """
    for option in fields(stand):
        value = getattr(stand, option.name)
        if _CHECK in option.metadata:
            value = value.tolist() if isinstance(value, np.ndarray) else value
            value = kept(option.metadata[_CHECK](option.name, value))
        elif option.name in _OF_ALL:
            value = kept(value)
        object.__setattr__(stand, option.name, tuple(value) if isinstance(value, list) else value)


_CHECK = "check"
# Options of every stand, and of those with axes.
_OF_ALL = ("forbidden", "speed_deg_s", "step_deg")


def _checked(default: object, check: Callable[[str, object], object]) -> Any:
    return field(default=default, metadata={_CHECK: check})
