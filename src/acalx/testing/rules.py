"""Rules that parts of every kind are held to; each raises AssertionError with the part and the rule it broke."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus

__all__ = [
    "STACKS",
    "TOLERANCE",
    "N",
    "arrays",
    "require",
    "require_close",
    "require_derivative",
    "require_shape",
    "require_stacked",
]

# Leading axes: a few programs, one, and so many on two levels that arithmetic runs along them.
STACKS: tuple[tuple[int, ...], ...] = ((3,), (), (2, 20))
N = 5
# How far derivatives may be from numerical ones, relative to the largest entry.
TOLERANCE = 1e-6


def require(holds: bool, part: object, rule: str) -> None:
    """Raise AssertionError unless a rule holds."""
    if not holds:
        raise AssertionError(f"{type(part).__name__} breaks a rule: {rule}")


def require_shape(part: object, what: str, value: Array, shape: tuple[int, ...]) -> None:
    """A value has this shape and is finite."""
    require(np.shape(value) == shape, part, f"{what} has shape {shape}, got {np.shape(value)}")
    require(bool(np.isfinite(value).all()), part, f"{what} is finite")


def require_close(part: object, rule: str, value: Array, expected: Array, tolerance: float) -> None:
    """A value is as expected, within a tolerance relative to the largest entry."""
    value, expected = np.asarray(value), np.asarray(expected)
    require(value.shape == expected.shape, part, f"{rule}; shape {expected.shape}, got {value.shape}")
    error = float(np.abs(value - expected).max(initial=0.0))
    require(error <= tolerance * (1.0 + np.abs(expected).max(initial=0.0)), part, f"{rule}; it is {error:.1e} off")


def require_stacked(part: object, what: str, function: Callable[[Array], list[Array]], x: Array) -> None:
    """The result for a stack, in both memory orders, is that of its members; x stays as it is."""
    before, stack = x.copy(), x.shape[:-2]
    for ordered in (np.ascontiguousarray(x), np.asfortranarray(x)):
        for whole, *each in zip(function(ordered), *(function(x[k]) for k in np.ndindex(stack)), strict=True):
            one_by_one = np.stack(each).reshape((*stack, *np.shape(each[0])))
            require_close(part, f"{what} of a stack is that of its members", whole, one_by_one, 1e-9)
        require(np.array_equal(ordered, before), part, f"{what} leaves its input as it is")


def require_derivative(part: object, exact: Stimulus, numerical: Stimulus, shape: tuple[int, ...]) -> None:
    """An exact derivative has this shape and agrees with the numerical one."""
    got, wanted = dict(exact.items()), dict(numerical.items())
    require(sorted(got) == sorted(wanted), part, f"derivative is of {sorted(wanted)}, got {sorted(got)}")
    for name, expected in wanted.items():
        require_shape(part, f"derivative.{name}", got[name], shape)
        require_close(part, f"derivative.{name} agrees with the numerical one", got[name], expected, TOLERANCE)


def arrays(stimulus: Stimulus) -> list[Array]:
    """The quantities of a stimulus, one array each."""
    return [value for _, value in stimulus.items()]
