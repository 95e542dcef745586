"""Turns about the axes of a sensor, one after another: vectors as it then sees them, with exact derivatives.

Components that are zero, and factors of one, cost nothing: a vertical that is turned twice takes two products.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Literal, TypeAlias

import numpy as np

from acalx.numerics.arrays import Array

__all__ = [
    "AXES",
    "PLANES",
    "UP",
    "Part",
    "Turn",
    "Vector",
    "added",
    "derivatives",
    "differentiated",
    "pieces",
    "slope",
    "turned",
    "vectors",
]

# A component of a vector: a number until a turn makes it depend on angles, None where it is zero.
Part: TypeAlias = "Array | float | None"
# One that no turn has touched.
Vector: TypeAlias = tuple[float | None, float | None, float | None]
# A turn of the axes in the plane of the components u and v, with the sine and the cosine of its angle.
Turn: TypeAlias = tuple[int, int, Array, Array]

UP: Vector = (None, None, 1.0)

# Axes that turns are about.
AXES: Mapping[str, Vector] = MappingProxyType(
    {
        "x": (1.0, None, None),
        "y": (None, 1.0, None),
        "z": UP,
        "-x": (-1.0, None, None),
        "-y": (None, -1.0, None),
        "-z": (None, None, -1.0),
    }
)
# A turn by an angle about an axis takes the components u and v to c u + s v and c v - s u: which they are.
PLANES: Mapping[str, tuple[int, int]] = MappingProxyType(
    {"x": (1, 2), "y": (2, 0), "z": (0, 1), "-x": (2, 1), "-y": (0, 2), "-z": (1, 0)}
)


def turned(vector: Sequence[Part], turns: Iterable[Turn]) -> list[Part]:
    """The three components of a vector in turned axes."""
    parts = list(vector)
    for u, v, sin, cos in turns:
        _turn(parts, u, v, sin, cos)
    return parts


def differentiated(vector: Sequence[Part], turns: Iterable[Turn]) -> tuple[list[Part], list[list[Part]]]:
    """The same, and its derivatives with respect to the angle of each turn, three components each."""
    parts = list(vector)
    by_angle: list[list[Part]] = []
    for u, v, sin, cos in turns:
        for each in by_angle:
            _turn(each, u, v, sin, cos)
        _turn(parts, u, v, sin, cos)
        first = parts[u]
        own: list[Part] = [None, None, None]
        own[u], own[v] = parts[v], None if first is None else -first
        by_angle.append(own)
    return parts, by_angle


def slope(vector: Sequence[Part], turns: Sequence[Turn], angles: Sequence[int]) -> list[Part]:
    """The derivative of a turned vector by the angles of the turns of these numbers, each once or twice."""
    parts = list(vector)
    for k, (u, v, sin, cos) in enumerate(turns):
        order = angles.count(k)
        if order:
            parts[3 - u - v] = None
            sin, cos = (cos, -sin) if order == 1 else (-sin, -cos)
        _turn(parts, u, v, sin, cos)
    return parts


def added(parts: Sequence[Part], more: Sequence[Part], factor: Array | float) -> list[Part]:
    """The components of a vector, and so many times those of another."""
    return [_sum(one, None if other is None else factor * other) for one, other in zip(parts, more, strict=True)]


def _sum(one: Part, other: Part) -> Part:
    return other if one is None else one if other is None else one + other


def _turn(parts: list[Part], u: int, v: int, sin: Array, cos: Array) -> None:
    """Turn a vector in place."""
    first, second = parts[u], parts[v]
    if first is not None:
        if second is not None:
            parts[u], parts[v] = first * cos + second * sin, second * cos - first * sin
        else:
            parts[u], parts[v] = first * cos, -(first * sin)
    elif second is not None:
        if second.__class__ is float and second == 1.0:
            parts[u], parts[v] = sin, cos
        else:
            parts[u], parts[v] = second * sin, second * cos


def vectors(parts: Sequence[Part], shape: tuple[int, ...], out: Array | None = None) -> Array:
    """Components of that shape as an array (*shape, 3), in `out`, or in the order of the first that is an array."""
    out = np.empty((*shape, 3), float, _order(parts)) if out is None else out
    for k, part in enumerate(parts):
        out[..., k] = 0.0 if part is None else part
    return out


def pieces(width: int, shape: tuple[int, ...]) -> Array:
    """An uninitialized array (*shape, width) each of whose components is in one piece.

    Products of components of large arrays then run through memory from one end to the other.
    """
    return np.moveaxis(np.empty((width, *shape)), 0, -1)


def derivatives(by_angle: Sequence[Sequence[Part]], shape: tuple[int, ...]) -> Array:
    """The same of derivatives with respect to d settings, (*shape, 3, d)."""
    out = np.zeros((*shape, 3, len(by_angle)), float, _order(by_angle[0]))
    for k, parts in enumerate(by_angle):
        for j, part in enumerate(parts):
            if part is not None:
                out[..., j, k] = part
    return out


def _order(parts: Sequence[Part]) -> Literal["C", "F"]:
    for part in parts:
        if isinstance(part, np.ndarray):
            return "F" if part.flags.f_contiguous else "C"
    return "C"
