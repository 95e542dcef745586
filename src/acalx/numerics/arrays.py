"""Small array tools that everything here is built on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["Array", "components", "empty_as", "sin_cos"]

Array = NDArray[np.float64]


def components(*arrays: Array) -> Array:
    """Stack equally shaped arrays along a new last axis, in the memory order of the first.

    Populations of programs come in Fortran order, so that arithmetic runs along the
    population: stacking in C order would cost more than computing.
    """
    first = arrays[0]
    out = empty_as(first, (*first.shape, len(arrays)))
    for k, array in enumerate(arrays):
        out[..., k] = array
    return out


def empty_as(like: Array, shape: tuple[int, ...]) -> Array:
    """An uninitialized array in the memory order of another one."""
    return np.empty(shape, order="F" if like.flags.f_contiguous else "C")


def sin_cos(angles: Array) -> tuple[Array, Array]:
    """Sine and cosine of angles in rad, through the tangent of the half angle.

    Accurate to rounding everywhere (no double is exactly half a turn, so the tangent is
    finite), and several times faster than the two calls: numpy has a vectorized tangent for
    doubles, but sine and cosine only one number at a time.
    """
    sin = np.tan(0.5 * angles)
    cos = sin * sin
    inverse = 1.0 / (1.0 + cos)
    sin *= 2.0
    sin *= inverse
    np.subtract(1.0, cos, out=cos)
    cos *= inverse
    return sin, cos
