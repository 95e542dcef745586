"""Residuals in units of their noise."""

from __future__ import annotations

import numpy as np

from acalx.numerics.arrays import Array

__all__ = ["correlated", "decorrelated", "flat", "passed_on", "whitened"]


def whitened(sigma: Array, value: Array, rows: Array, by_readings: Array | None) -> tuple[Array, Array]:
    """A residual and its rows over the noise of the readings, which several residuals of a position may share.

    Parameters
    ----------
    sigma : array (k,) or (..., n, k)
        Standard deviations of the readings.
    value : array (..., n, m)
    rows : array (..., n, m, p)
    by_readings : array (..., n, m, k), or None where the residual is the readings themselves

    Returns
    -------
    Both, with a noise of unit covariance: over the lower Cholesky factor of J diag(sigma^2) J'.
    """
    if by_readings is None:
        return value / sigma, rows / sigma[..., None]
    scaled = by_readings * sigma[..., None, :]
    if value.shape[-1] == 1:
        size = np.sqrt((scaled * scaled).sum(axis=-1))
        return value / size, rows / size[..., None]
    with np.errstate(invalid="ignore"):
        covariance = scaled @ scaled.swapaxes(-1, -2)
    good = np.array(np.isfinite(covariance).all(axis=(-2, -1)))
    covariance = np.where(good[..., None, None], covariance, np.eye(value.shape[-1]))
    root = np.linalg.cholesky(covariance)
    whole = np.linalg.solve(root, np.concatenate([value[..., None], rows], axis=-1))
    return whole[..., 0], whole[..., 1:]


def passed_on(own: Array, sigma: Array, by_readings: Array | None) -> Array:
    """Standard deviations (n m,) of residuals in units of the model's, of readings with their own, (n, k).

    Parameters
    ----------
    own : array (n, k)
    sigma : array (k,) or (n, k)
        What the model says of them.
    by_readings : array (n, m, k), or None where the residual is the readings themselves
    """
    if by_readings is None:
        return np.asarray(own / sigma).reshape(-1)
    passed = [np.sqrt(((by_readings * each[..., None, :]) ** 2).sum(axis=-1)) for each in (own, sigma)]
    return np.asarray(passed[0] / passed[1]).reshape(-1)


def decorrelated(correlation: Array | None, rows: Array, *, back: bool = False) -> Array:
    """Rows (..., n, m, p) over the Cholesky factor L of the correlations of n positions, (..., n, n).

    `back` is for gradients by such rows: over the transpose of L.
    """
    assert correlation is not None  # nothing is asked where there is none
    root = np.linalg.cholesky(correlation)
    root = root.swapaxes(-1, -2) if back else root
    *stack, n, m, p = rows.shape
    return np.linalg.solve(root, rows.reshape((*stack, n, m * p))).reshape(rows.shape)


def correlated(correlation: Array | None, noise: Array) -> Array:
    """Independent noise (..., n, k) with the correlations of n positions, (..., n, n)."""
    assert correlation is not None  # nothing is asked where there is none
    return np.asarray(np.linalg.cholesky(correlation) @ noise)


def flat(residual: Array, rows: Array) -> tuple[Array, Array]:
    """(..., n, m) and (..., n, m, p) with positions and outputs in one axis."""
    return residual.reshape((*residual.shape[:-2], -1)), rows.reshape((*rows.shape[:-3], -1, rows.shape[-1]))
