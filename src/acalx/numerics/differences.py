"""Derivatives by differences of fourth order."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from acalx.numerics.arrays import Array

__all__ = ["STEP", "differences", "steps_of"]

# Relative to the size of what is moved: what the differences leave out and what rounding adds are both about 1e-13
# there.
STEP = 1e-3


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


def steps_of(value: Array) -> Array:
    """Steps (w,) for a quantity (..., n, w): its components are moved by a share of their largest."""
    size = np.abs(value).max(initial=0.0)
    return np.full(value.shape[-1], STEP * (size if size > 0.0 else 1.0))
