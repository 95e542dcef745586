"""Parts with their options, as a record names them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from acalx.models import Compared, as_model

__all__ = ["described", "recorded_metrics"]


def described(part: object) -> dict[str, Any]:
    """What a part is and how it is set: its class, and its options by name.

    Parameters
    ----------
    part : object
        A stand, model, criterion, optimizer or any other part, as a rule a frozen dataclass.

    Returns
    -------
    dict
        ``class``, the name of the class, with its module where that is not acalx's own; then the
        options as JSON has them, parts among them described in turn.

    Examples
    --------
    >>> from acalx.criteria import D, Inequality
    >>> described(Inequality("bias"))
    {'class': 'Inequality', 'group': 'bias', 'floor': 0.0005}
    """
    if isinstance(part, Compared) and part == as_model(part.sensor):
        part = part.sensor  # as it was given
    kind = type(part)
    own = kind.__module__.split(".")[0] == "acalx"
    name = kind.__qualname__ if own else f"{kind.__module__}.{kind.__qualname__}"
    if is_dataclass(part):
        options = {field.name: getattr(part, field.name) for field in fields(part) if field.init}
    else:
        options = {key: value for key, value in vars(part).items() if not key.startswith("_")}
    return {"class": name, **{key: _value(value) for key, value in options.items()}}


def recorded_metrics(metrics: Mapping[str, Any]) -> dict[str, Any]:
    """Figures of merit as a record has them: D, A and E null where no double holds them, beside their logarithms."""
    values = {name: metrics[name] if 0.0 < metrics[name] < np.inf else None for name in ("D", "A", "E")}
    return {**metrics, **values}


def _value(value: Any) -> Any:
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _value(entry) for key, entry in value.items()}
    if isinstance(value, Sequence | set | frozenset):
        return [_value(entry) for entry in value]
    if callable(value) and hasattr(value, "__qualname__"):
        return f"{value.__module__}.{value.__qualname__}"
    return described(value) if hasattr(value, "__dict__") else str(value)
