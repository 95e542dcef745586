"""Derivatives by differences of fourth order."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from acalx.numerics.arrays import Array

__all__ = ["STEP", "differences", "differences_at", "settled", "steps_at"]

# Relative to the size of what is moved: what the differences leave out and what rounding adds are both about 1e-13
# there.
STEP = 1e-3
# Of the size of a quantity in a position beside the largest in the program.
_LEAST = 1e-4
# How far derivatives by a step and by a tenth of it may differ, relative, and by rounding; and how often it is tried.
_SETTLED, _ROUNDING, _MOST_TENTHS = 1e-8, 1e-13, 8


def differences(function: Callable[[Array], Array], steps: Array) -> Array:
    """Derivatives of a function by each component of a shift, in a last axis.

    Parameters
    ----------
    function : callable
        From a shift (w,) to an array.
    steps : array (w,)
        How far each component is moved.
    """
    columns = []
    for k, step in enumerate(steps):
        shift = np.zeros(len(steps))
        shift[k] = step
        near, far = (function(m * shift) - function(-m * shift) for m in (1, 2))
        columns.append((8.0 * near - far) / (12.0 * step))
    return np.stack(columns, axis=-1)


def steps_at(value: Array, positions: int = 1) -> Array:
    """Steps (..., n) for a quantity (..., n, w) in each position: a share of its size there.

    No size is taken for smaller than a ten-thousandth of the largest in the same program.

    Parameters
    ----------
    value : array (..., n, w), or (..., n, K, w)
    positions : int
        How many axes positions have: 2 with samples.
    """
    size = np.sqrt((value * value).sum(axis=-1))
    largest = size.max(axis=tuple(range(-positions, 0)), keepdims=True, initial=0.0)
    return np.asarray(STEP * np.maximum(size, np.where(largest > 0.0, _LEAST * largest, 1.0)))


def differences_at(function: Callable[[Array], Array], value: Array, steps: Array, behind: int) -> Array:
    """Derivatives of what each position gives by a quantity there, in a last axis.

    Parameters
    ----------
    function : callable
        From shifts of the quantity, of the shape of `value`, to an array with `behind` axes behind that of positions.
    value : array (..., n, w)
    steps : array (..., n)
        How far each component is moved in each position.
    behind : int
    """
    columns, by_step = [], steps[(..., *[None] * behind)]
    for k in range(value.shape[-1]):
        shift = np.zeros(np.broadcast_shapes(value.shape, (*steps.shape, 1)))
        shift[..., k] = steps
        near, far = (function(m * shift) - function(-m * shift) for m in (1, 2))
        columns.append((8.0 * near - far) / (12.0 * by_step))
    return np.stack(columns, axis=-1)


def settled(function: Callable[[Array], Array], steps: Array) -> Array:
    """Steps (w,) so small that a tenth of them changes no derivative by more than rounding does.

    Parameters
    ----------
    function : callable
        From a shift (w,) to an array; a few of all the values that matter are enough.
    steps : array (w,)
        Tried first.
    """
    found = steps.copy()
    for k, step in enumerate(steps):

        def along(shift: Array, k: int = k) -> Array:
            whole = np.zeros(len(steps))
            whole[k] = shift[0]
            return function(whole)

        size = float(np.abs(function(np.zeros(len(steps)))).max(initial=0.0))
        this = differences(along, np.array([step]))
        for _ in range(_MOST_TENTHS):
            smaller = differences(along, np.array([0.1 * step]))
            largest = float(np.abs(smaller).max(initial=0.0))
            if not np.abs(this - smaller).max(initial=0.0) > _SETTLED * largest + _ROUNDING * size / step:
                break
            step, this = 0.1 * step, smaller
        found[k] = step
    return found
