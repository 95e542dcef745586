"""Residuals in units of their noise."""

from __future__ import annotations

import numpy as np

from acalx.numerics.arrays import Array

__all__ = ["flat", "whitened"]


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


def flat(residual: Array, rows: Array) -> tuple[Array, Array]:
    """(..., n, m) and (..., n, m, p) with positions and outputs in one axis."""
    return residual.reshape((*residual.shape[:-2], -1)), rows.reshape((*rows.shape[:-3], -1, rows.shape[-1]))
