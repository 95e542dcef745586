"""Checks of options, with one kind of message for all."""

from __future__ import annotations

import math

import numpy as np

from acalx.errors import ArgumentError

__all__ = ["require_confidence", "require_count", "require_points", "require_positive", "require_seed"]


def require_confidence(value: object) -> None:
    """Raise ArgumentError unless it is a probability that intervals can have, from 0.5 to less than 1."""
    if not (isinstance(value, float) and 0.5 <= value < 1.0):
        raise ArgumentError(f"confidence={value}: give a probability from 0.5 to less than 1, such as 0.95")


def require_count(name: str, value: object) -> None:
    """Raise ArgumentError unless the option is a whole number of at least 1."""
    if not isinstance(value, (int, np.integer)) or isinstance(value, bool) or value < 1:
        raise ArgumentError(f"{name}={value}: must be a whole number of at least 1")


def require_positive(name: str, value: object) -> None:
    """Raise ArgumentError unless the option is a positive finite number."""
    if not isinstance(value, (int, float)) or isinstance(value, bool) or not 0 < value < math.inf:
        raise ArgumentError(f"{name}={value}: must be a positive number")


def require_points(name: str, value: object, objectives: int = 2) -> None:
    """Raise ArgumentError unless the option is a whole number that a front of so many objectives can have."""
    require_count(name, value)
    if isinstance(value, (int, np.integer)) and value < objectives:
        raise ArgumentError(f"{name}={value}: a front of {objectives} objectives has {objectives} ends or more")


def require_seed(value: object) -> None:
    """Raise ArgumentError unless it is a seed of a random generator."""
    if not isinstance(value, (int, np.integer)) or isinstance(value, bool) or value < 0:
        raise ArgumentError(f"seed={value}: the seed must be a whole number, 0 or more")
