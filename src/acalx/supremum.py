"""Largest value of a trigonometric polynomial on a box, with a proof.

A polynomial of known degree is known everywhere from its values on a small grid: its Fourier
coefficients c_j. Branch and bound then splits the box into cells. On a cell of half widths r
around a point the polynomial is at most its Taylor polynomial of second order there, whose
largest value on the cell is bounded term by term, plus

    1/6 sum_j |c_j| (sum_k |j_k| r_k)^3

for all that is of third order. A cell where this is below what is asked for is done with; the
others are split.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from acalx.arrays import Array

__all__ = ["Supremum", "supremum"]

_FIRST_CELLS = 24
_MOST_CELLS = 2_000_000
_AT_A_TIME = 50_000


@dataclass(frozen=True)
class Supremum:
    """An upper bound on a function over a box.

    Parameters
    ----------
    value : float
        The bound.
    cells : int
        Number of cells that it took to prove.
    """

    value: float
    cells: int


def supremum(
    function: Callable[[Array], Array], degrees: Sequence[int], lower: Array, upper: Array, target: float
) -> Supremum:
    """Prove that a function is at most `target` on a box, or as close above it as can be proved.

    Parameters
    ----------
    function : callable
        Takes points (k, d), returns values (k,): a trigonometric polynomial.
    degrees : sequence of int, length d
        Its degree in each angle.
    lower, upper : array (d,), in rad
    target : float
    """
    series = _Series(function, degrees)
    half = (upper - lower) / (2 * _FIRST_CELLS)
    axes = [low + width * (2 * np.arange(_FIRST_CELLS) + 1) for low, width in zip(lower, half, strict=True)]
    centers = np.array(list(itertools.product(*axes)))
    corners = np.array(list(itertools.product((-0.5, 0.5), repeat=len(half))))
    cells = 0
    while True:
        parts = [centers[k : k + _AT_A_TIME] for k in range(0, len(centers), _AT_A_TIME)]
        highest = np.concatenate([series.highest(part, half) for part in parts])
        cells += len(centers)
        above = highest > target
        if not above.any():
            return Supremum(target, cells)
        if cells + int(above.sum()) * len(corners) > _MOST_CELLS:
            return Supremum(float(highest.max()), cells)
        centers = (centers[above][:, None, :] + corners * half).reshape(-1, len(half))
        half = half / 2


class _Series:
    """Fourier series of a trigonometric polynomial."""

    def __init__(self, function: Callable[[Array], Array], degrees: Sequence[int]) -> None:
        counts = [2 * degree + 1 for degree in degrees]
        turns = [2 * math.pi * np.arange(count) / count for count in counts]
        values = function(np.array(list(itertools.product(*turns)))).reshape(counts)
        self.coefficients = np.fft.fftn(values) / values.size
        self.orders = [np.fft.fftfreq(count, 1 / count) for count in counts]

    def highest(self, centers: Array, half: Array) -> Array:
        """Upper bounds on cells around centers (k, d) with half widths (d,)."""
        d = len(half)
        phases = [np.exp(1j * np.outer(centers[:, k], self.orders[k])) for k in range(d)]
        unit = np.eye(d, dtype=int)
        bound = self._derivative(phases, (0,) * d)
        for k in range(d):
            slope = self._derivative(phases, tuple(unit[k]))
            bend = self._derivative(phases, tuple(2 * unit[k]))
            bound = bound + _highest_of_parabola(np.abs(slope), bend, float(half[k]))
            for j in range(k):
                mixed = self._derivative(phases, tuple(unit[j] + unit[k]))
                bound = bound + np.abs(mixed) * float(half[j] * half[k])
        reach = sum(
            np.abs(order).reshape([-1 if k == axis else 1 for k in range(d)]) * half[axis]
            for axis, order in enumerate(self.orders)
        )
        return np.asarray(bound + float((np.abs(self.coefficients) * reach**3).sum()) / 6)

    def _derivative(self, phases: list[np.ndarray], times: tuple[int, ...]) -> Array:
        """A partial derivative at all points at once, contracting one angle after another."""
        first = phases[0] * (1j * self.orders[0]) ** times[0]
        terms = np.tensordot(first, self.coefficients, axes=1)
        for phase, order, power in zip(phases[1:], self.orders[1:], times[1:], strict=True):
            shape = (*phase.shape, *(1,) * (terms.ndim - 2))
            terms = (terms * (phase * (1j * order) ** power).reshape(shape)).sum(axis=1)
        return np.asarray(terms.real)


def _highest_of_parabola(slope: Array, bend: Array, half: float) -> Array:
    """Largest value of slope t + bend t^2 / 2 over |t| <= half, for a slope of at least 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        top = np.where(bend < 0, np.minimum(-slope / bend, half), half)
    return np.asarray(slope * top + 0.5 * bend * top * top)
