"""From weights on candidates to a few support points, and to whole numbers of measurements."""

from __future__ import annotations

import numpy as np

from acalx.numerics.arrays import Array

__all__ = ["Cosines", "alike", "efficient_rounding", "random_roundings", "thinned"]


def thinned(rows: Array, weights: Array) -> Array:
    """Weights (k,) that give the same information with as few positions as p (p + 1) / 2 + 1.

    Where the best design is not unique, interior points give one with weight on everything.

    Parameters
    ----------
    rows : array (k, m, p)
    weights : array (k,)
        Positive.

    Source: Carathéodory's theorem; Fedorov, Theory of Optimal Experiments (1972), section 2.1.
    """
    upper = np.triu_indices(rows.shape[-1])
    products = (rows[..., upper[0]] * rows[..., upper[1]]).sum(axis=1)
    products /= np.maximum(np.abs(products).max(axis=0), np.finfo(float).tiny)
    conditions = np.column_stack([products, np.ones(len(rows))])
    left = np.arange(len(rows))
    weights = weights.copy()
    orthogonal, triangle = np.linalg.qr(conditions, mode="complete")
    null = orthogonal[:, triangle.shape[1] :].copy()
    while null.shape[1]:
        direction = null[:, 0]
        direction = direction if direction.max() >= -direction.min() else -direction
        ratios = np.full(len(left), np.inf)
        np.divide(weights[left], direction, out=ratios, where=direction > 1e-12)
        gone = int(ratios.argmin())
        weights[left] = np.maximum(weights[left] - ratios[gone] * direction, 0.0)
        weights[left[gone]] = 0.0
        column = int(np.abs(null[gone]).argmax())
        null -= np.outer(null[:, column] / null[gone, column], null[gone])
        null = np.delete(np.delete(null, column, axis=1), gone, axis=0)
        left = np.delete(left, gone)
    return np.asarray(weights / weights.sum())


class Cosines:
    """How much alike positions are: squared cosines of their regressors in the metric of the covariance.

    Parameters
    ----------
    rows : array (k, m, p)
    covariance : array (p, p)
    """

    def __init__(self, rows: Array, covariance: Array) -> None:
        self.rows = rows @ np.linalg.cholesky(covariance)
        self.sizes = np.sqrt(np.einsum("kma,kmb,knb,kna->k", *(4 * [self.rows]), optimize=True))
        self.sizes = np.maximum(self.sizes, np.finfo(float).tiny)

    def __call__(self, some: np.ndarray, other: int) -> Array:
        """Of some positions and another one, by their numbers: 1 where they are the same."""
        products = (np.einsum("kma,na->kmn", self.rows[some], self.rows[other]) ** 2).sum(axis=(1, 2))
        return np.asarray(products / (self.sizes[some] * self.sizes[other]))


def alike(rows: Array, weights: Array, covariance: Array, cosine: float = 0.98) -> np.ndarray:
    """Number of the support point that each position belongs to, (k,) from 0.

    On a grid neighbors share the weight of an optimum between them. Each position belongs to
    the heaviest one whose squared cosine with it is larger.
    """
    cosines = Cosines(rows, covariance)
    number = np.full(len(rows), -1)
    count = 0
    for first in np.argsort(-weights, kind="stable"):
        free = np.flatnonzero(number < 0)
        if number[first] < 0:
            number[free[cosines(free, int(first)) >= cosine]] = count
            number[first] = count
            count += 1
    return number


def efficient_rounding(weights: Array, n: int) -> Array:
    """How many of n measurements each point gets, (k,) of int.

    Where n is at least the number of points, no other rounding has a higher efficiency
    guaranteed for every criterion; otherwise the heaviest get one each.

    Source: Pukelsheim and Rieder, Biometrika 79 (1992) 763.
    """
    k = len(weights)
    counts = np.zeros(k, dtype=int)
    if n < k:
        counts[np.argsort(-weights, kind="stable")[:n]] = 1
        return counts
    counts = np.maximum(np.ceil((n - 0.5 * k) * weights), 1).astype(int)
    while counts.sum() > n:
        counts[np.where(counts > 1, (counts - 1) / weights, -np.inf).argmax()] -= 1
    while counts.sum() < n:
        counts[(counts / weights).argmin()] += 1
    return counts


def random_roundings(rng: np.random.Generator, weights: Array, n: int, count: int) -> Array:
    """Random roundings (count, k) of int, in which each point gets n w, rounded up or down, n w on average."""
    k = len(weights)
    counts = np.zeros((count, k), dtype=int)
    for row in counts:
        order = rng.permutation(k)
        ends = np.cumsum(weights[order]) * (n / weights.sum())
        ends[-1] = n  # free of rounding errors
        places = np.searchsorted(ends, np.arange(n) + rng.uniform(), side="right")
        row[order] = np.bincount(places, minlength=k)
    return counts
