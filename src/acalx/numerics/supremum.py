"""Largest value of a trigonometric polynomial on boxes, with a proof.

A polynomial of known degree is known everywhere from its values on a small grid: its Fourier
coefficients c_j. Branch and bound then splits the boxes into cells. On a cell of half widths r
around a point the polynomial is at most its Taylor polynomial of second order there, whose
largest value on the cell is bounded term by term, plus

    1/6 sum_j |c_j| (sum_k |j_k| r_k)^3

for all that is of third order. A cell where this is below what is asked for is done with; the
others are split, in the angles that add most to it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from acalx.numerics.arrays import Array

__all__ = ["Cells", "Supremum", "cells_between", "cells_of", "supremum"]

_MOST_CELLS = 2_000_000
_AT_A_TIME = 50_000
# Relative to its mean, what a function of an angle that plays no part depends on it.
_ROUNDING = 1e-13
# A cell is split in the angles that add at least this part of what the one that matters most adds.
_MATTERS = 0.3


@dataclass(frozen=True, eq=False)
class Cells:
    """Boxes side by side.

    Parameters
    ----------
    centers, half : array (k, d), in rad
        Half of the width, which may be 0.
    """

    centers: Array
    half: Array

    def __len__(self) -> int:
        return len(self.centers)

    def select(self, members: np.ndarray) -> Cells:
        """Those of the cells that are told, by a mask (k,) or by their numbers."""
        return Cells(self.centers[members], self.half[members])

    def split(self, which: np.ndarray) -> Cells:
        """Each into halves in those of its angles, (k, d), that are told."""
        centers, half = self.centers, np.where(which, 0.5 * self.half, self.half)
        for axis in range(half.shape[1]):
            halved = which[:, axis]
            shift = np.zeros((int(halved.sum()), half.shape[1]))
            shift[:, axis] = half[halved, axis]
            centers = np.concatenate([centers[~halved], centers[halved] - shift, centers[halved] + shift])
            half = np.concatenate([half[~halved], half[halved], half[halved]])
            which = np.concatenate([which[~halved], which[halved], which[halved]])
        return Cells(centers, half)


def cells_between(edges: Array) -> tuple[Array, Array]:
    """Middles and half widths of the intervals between neighboring edges."""
    return 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)


def cells_of(axes: Sequence[tuple[Array, Array]]) -> Cells:
    """All the boxes made of one interval in each angle, given by its middle and half width."""
    middles, halves = zip(*axes, strict=True)
    return Cells(
        np.stack(np.meshgrid(*middles, indexing="ij"), axis=-1).reshape(-1, len(axes)),
        np.stack(np.meshgrid(*halves, indexing="ij"), axis=-1).reshape(-1, len(axes)),
    )


@dataclass(frozen=True)
class Supremum:
    """An upper bound on a function over boxes.

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
    function: Callable[[Array], Array],
    degrees: Sequence[int],
    cells: Cells,
    target: float,
    outside: Callable[[Cells], np.ndarray] | None = None,
    finest: float = 0.0,
) -> Supremum:
    """Prove that a function is at most `target` on boxes, or as close above it as can be proved.

    Parameters
    ----------
    function : callable
        Takes points (k, d), returns values (k,): a trigonometric polynomial.
    degrees : sequence of int, length d
        Its degree in each angle.
    cells : Cells
        Where.
    target : float
    outside : callable, optional
        Says of cells which of them need not be looked at, (k,).
    finest : float, in rad
        Cells are not split in angles in which their half width is no more than this.
    """
    series = _Series(function, degrees)
    total, settled = 0, target
    while True:
        if outside is not None:
            cells = cells.select(~outside(cells))
        parts = [slice(k, k + _AT_A_TIME) for k in range(0, len(cells), _AT_A_TIME)]
        found = [series.highest(cells.centers[p], cells.half[p]) for p in parts]
        if not found:
            return Supremum(settled, total)
        highest, added = (np.concatenate(each) for each in zip(*found, strict=True))
        total += len(cells)
        above = highest > settled
        if not above.any():
            return Supremum(settled, total)
        ended = above & (cells.half <= finest).all(axis=1)
        settled = max(settled, float(highest[ended].max(initial=-np.inf)))
        above = highest > settled
        cells, added = cells.select(above), added[above]
        wide = cells.half > finest
        added = np.where(wide, added, 0.0)
        which = wide & (added >= _MATTERS * added.max(axis=1, keepdims=True))
        if total + int((2 ** which.sum(axis=1)).sum()) > _MOST_CELLS:
            return Supremum(max(settled, float(highest.max())), total)
        cells = cells.split(which)


class _Series:
    """Fourier series of a trigonometric polynomial."""

    def __init__(self, function: Callable[[Array], Array], degrees: Sequence[int]) -> None:
        counts = [2 * degree + 1 for degree in degrees]
        turns = [2 * math.pi * np.arange(count) / count for count in counts]
        values = function(np.array(list(itertools.product(*turns)))).reshape(counts)
        self.coefficients = np.fft.fftn(values) / values.size
        self.orders = [np.fft.fftfreq(count, 1 / count) for count in counts]
        self.left_out = 0.0
        for axis in range(len(counts)):
            self._leave_out(axis)
        # sum_j |c_j| |j_a j_b j_c| for all triples of angles: what the third order can add
        sizes = np.stack(np.meshgrid(*map(np.abs, self.orders), indexing="ij")).reshape(len(counts), -1)
        self.third = np.einsum("j,aj,bj,cj->abc", np.abs(self.coefficients).ravel(), sizes, sizes, sizes)

    def _leave_out(self, axis: int) -> None:
        """Keep the mean over an angle alone where the rest is no more than rounding."""
        mean = self.coefficients.take([0], axis=axis)
        rest = np.abs(np.delete(self.coefficients, 0, axis=axis)).sum()
        if rest <= _ROUNDING * np.abs(mean).sum():
            self.coefficients, self.orders[axis] = mean, np.zeros(1)
            self.left_out += float(rest)

    def highest(self, centers: Array, half: Array) -> tuple[Array, Array]:
        """Upper bounds (k,) on cells with centers and half widths (k, d), and what each angle adds to them, (k, d)."""
        d = half.shape[1]
        phases = [np.exp(1j * np.outer(centers[:, k], self.orders[k])) for k in range(d)]
        unit = np.eye(d, dtype=int)
        rest = np.einsum("abc,kb,kc->ka", self.third, half, half)
        added = half * rest / 6
        for k in range(d):
            slope = self._derivative(phases, tuple(unit[k]))
            bend = self._derivative(phases, tuple(2 * unit[k]))
            added[:, k] += _highest_of_parabola(np.abs(slope), bend, half[:, k])
            for j in range(k):
                mixed = self._derivative(phases, tuple(unit[j] + unit[k]))
                both = np.abs(mixed) * half[:, j] * half[:, k]
                added[:, j] += 0.5 * both
                added[:, k] += 0.5 * both
        return self._derivative(phases, (0,) * d) + added.sum(axis=1) + self.left_out, added

    def _derivative(self, phases: list[np.ndarray], times: tuple[int, ...]) -> Array:
        """A partial derivative at all points at once, contracting one angle after another."""
        first = phases[0] * (1j * self.orders[0]) ** times[0]
        terms = np.tensordot(first, self.coefficients, axes=1)
        for phase, order, power in zip(phases[1:], self.orders[1:], times[1:], strict=True):
            shape = (*phase.shape, *(1,) * (terms.ndim - 2))
            terms = (terms * (phase * (1j * order) ** power).reshape(shape)).sum(axis=1)
        return np.asarray(terms.real)


def _highest_of_parabola(slope: Array, bend: Array, half: Array) -> Array:
    """Largest value of slope t + bend t^2 / 2 over |t| <= half, for a slope of at least 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        top = np.where(bend < 0, np.minimum(-slope / bend, half), half)
    return np.asarray(slope * top + 0.5 * bend * top * top)
