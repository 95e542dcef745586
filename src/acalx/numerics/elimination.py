"""Elimination along a stack of small matrices, and null spaces that can be read."""

from __future__ import annotations

import numpy as np

from acalx.numerics.arrays import Array

__all__ = ["cholesky", "inverse_roots", "row_reduced", "substituted"]

# A pivot so much smaller than its diagonal entry is rounding.
_PIVOT_TOLERANCE = 1e-13


def cholesky(matrix: Array) -> tuple[Array, np.ndarray]:
    """Cholesky factors U, M = U'U, as (p, p, ...), and where there is one; along the stack.

    For thousands of small matrices several times as fast as a LAPACK call for each, and it
    tolerates singular ones.
    """
    upper = np.array(np.moveaxis(matrix, (-2, -1), (0, 1)), order="C")
    p = len(upper)
    floors = np.array([_PIVOT_TOLERANCE * upper[k, k] for k in range(p)])
    regular = np.ones(upper.shape[2:], dtype=bool)
    for k in range(p):  # row by row
        row = upper[k, k:]
        row -= np.einsum("j...,jm...->m...", upper[:k, k], upper[:k, k:])
        good = row[0] > floors[k]
        regular &= good
        row *= 1.0 / np.sqrt(np.where(good, row[0], 1.0))
    return upper, regular


def substituted(upper: Array, vectors: Array) -> Array:
    """inv(U'U) v for Cholesky factors (p, p, ...) and vectors (..., p), forth and back along the stack."""
    solution = np.array(np.moveaxis(vectors, -1, 0), order="C")
    p = len(upper)
    for k in range(p):
        solution[k] -= np.einsum("j...,j...->...", upper[:k, k], solution[:k])
        solution[k] /= upper[k, k]
    for k in reversed(range(p)):
        solution[k] -= np.einsum("j...,j...->...", upper[k, k + 1 :], solution[k + 1 :])
        solution[k] /= upper[k, k]
    return np.asarray(np.moveaxis(solution, 0, -1))


def inverse_roots(upper: Array, regular: np.ndarray) -> Array:
    """Inverses R of Cholesky factors, R U' = I, as (..., p, p); inf where there is none."""
    p = len(upper)
    root = np.zeros(upper.shape)
    for i in range(p):  # row by row
        root[i, i] = 1.0 / np.where(regular, upper[i, i], 1.0)
        root[i, :i] = -root[i, i] * np.einsum("k...,km...->m...", upper[:i, i], root[:i, :i])
    return np.asarray(np.moveaxis(np.where(regular, root, np.inf), (0, 1), (-2, -1)))


def row_reduced(rows: Array) -> Array:
    """Reduced row echelon form with full pivoting, which makes a null space readable."""
    rows = rows.copy()
    for k in range(len(rows)):
        i, j = divmod(int(np.abs(rows[k:]).argmax()), rows.shape[1])
        rows[[k, k + i]] = rows[[k + i, k]]
        rows[k] /= rows[k, j]
        others = np.arange(len(rows)) != k
        rows[others] -= np.outer(rows[others, j], rows[k])
    return rows
