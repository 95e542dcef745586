"""Variables with limits in the place of angles: what is a polynomial in them is a trigonometric one in the angles.

A variable from a to b is (a + b) / 2 + (b - a) / 2 cos(theta), with theta from 0 to pi; a polynomial of
degree k in it is a trigonometric polynomial of degree k in theta.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acalx.numerics.arrays import Array
from acalx.numerics.supremum import Cells

__all__ = ["Cosines"]


@dataclass(frozen=True, eq=False)
class Cosines:
    """Points with d coordinates, each an angle or a variable that is written as one.

    Parameters
    ----------
    limits : array (d, 2)
    written : sequence of bool, length d
        Which coordinates are variables that are written as angles; the others are angles themselves.
    """

    limits: Array
    written: Sequence[bool]

    def points(self, angles: Array) -> Array:
        """Points (..., d) for angles (..., d)."""
        points = angles.copy()
        for k in np.flatnonzero(self.written):
            middle, half = self.limits[k].mean(), 0.5 * np.ptp(self.limits[k])
            points[..., k] = middle + half * np.cos(angles[..., k])
        return points

    def angles(self, axis: int, values: Array) -> Array:
        """Angles (k,), ascending, for ascending values (k,) of one coordinate within its limits."""
        if not self.written[axis]:
            return values
        middle, half = self.limits[axis].mean(), 0.5 * np.ptp(self.limits[axis])
        return np.asarray(np.arccos(np.clip((values - middle) / half, -1.0, 1.0))[::-1])

    def cells(self, cells: Cells) -> Cells:
        """What boxes of angles are as boxes of points."""
        begin, end = self.points(cells.centers - cells.half), self.points(cells.centers + cells.half)
        return Cells(0.5 * (begin + end), 0.5 * np.abs(end - begin))
