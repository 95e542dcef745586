"""Largest value of a trigonometric polynomial on boxes, with a proof.

A polynomial of known degree is known everywhere from its values on a small grid: its Fourier
coefficients c_j. Branch and bound then splits the boxes into cells. On a cell of half widths r
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

from acalx.numerics.arrays import Array

__all__ = ["Cells", "Supremum", "cells_between", "cells_of", "supremum"]

_MOST_CELLS = 2_000_000
_AT_A_TIME = 50_000


@dataclass(frozen=True)
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
        """Some of them."""
        return Cells(self.centers[members], self.half[members])

    def split(self) -> Cells:
        """Each into halves in every angle in which it has a width."""
        wide = np.any(self.half > 0, axis=0).tolist()
        corners = np.array(list(itertools.product(*((-0.5, 0.5) if w else (0.0,) for w in wide))))
        centers = self.centers[:, None, :] + corners * self.half[:, None, :]
        half = np.broadcast_to(0.5 * self.half[:, None, :], centers.shape)
        return Cells(centers.reshape(-1, len(wide)), half.reshape(-1, len(wide)))


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
        Cells of no more than this half width are not split.
    """
    series = _Series(function, degrees)
    total, settled = 0, target
    while True:
        if outside is not None:
            cells = cells.select(~outside(cells))
        parts = [slice(k, k + _AT_A_TIME) for k in range(0, len(cells), _AT_A_TIME)]
        highest = np.concatenate([np.empty(0), *(series.highest(cells.centers[p], cells.half[p]) for p in parts)])
        total += len(cells)
        above = highest > settled
        if not above.any():
            return Supremum(settled, total)
        ended = above & (cells.half <= finest).all(axis=1)
        settled = max(settled, float(highest[ended].max(initial=-np.inf)))
        above = highest > settled
        if total + int(above.sum()) * 2 ** cells.half.shape[1] > _MOST_CELLS:
            return Supremum(max(settled, float(highest.max())), total)
        cells = cells.select(above).split()


class _Series:
    """Fourier series of a trigonometric polynomial."""

    def __init__(self, function: Callable[[Array], Array], degrees: Sequence[int]) -> None:
        counts = [2 * degree + 1 for degree in degrees]
        turns = [2 * math.pi * np.arange(count) / count for count in counts]
        values = function(np.array(list(itertools.product(*turns)))).reshape(counts)
        self.coefficients = np.fft.fftn(values) / values.size
        self.orders = [np.fft.fftfreq(count, 1 / count) for count in counts]
        # sum_j |c_j| |j_a j_b j_c| for all triples of angles: what the third order can add
        sizes = np.stack(np.meshgrid(*(np.abs(order) for order in self.orders), indexing="ij")).reshape(len(counts), -1)
        self.third = np.einsum("j,aj,bj,cj->abc", np.abs(self.coefficients).ravel(), sizes, sizes, sizes)

    def highest(self, centers: Array, half: Array) -> Array:
        """Upper bounds on cells around centers (k, d) with half widths (k, d)."""
        d = half.shape[1]
        phases = [np.exp(1j * np.outer(centers[:, k], self.orders[k])) for k in range(d)]
        unit = np.eye(d, dtype=int)
        bound = self._derivative(phases, (0,) * d)
        for k in range(d):
            slope = self._derivative(phases, tuple(unit[k]))
            bend = self._derivative(phases, tuple(2 * unit[k]))
            bound = bound + _highest_of_parabola(np.abs(slope), bend, half[:, k])
            for j in range(k):
                mixed = self._derivative(phases, tuple(unit[j] + unit[k]))
                bound = bound + np.abs(mixed) * half[:, j] * half[:, k]
        rest = np.einsum("abc,ka,kb,kc->k", self.third, half, half, half)
        return np.asarray(bound + rest / 6)

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
