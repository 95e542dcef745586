"""Residuals in units of their noise."""

from __future__ import annotations

import numpy as np

from acalx.errors import AcalxError, CompatibilityError, PluginError
from acalx.numerics.arrays import Array

__all__ = ["correlated", "flat", "over_shared", "passed_on", "whitened"]

_NO_NOISE = PluginError(
    "the correlations that a sensor gives for the times of a program are those of no noise: the matrix is not positive "
    "definite"
)
_ALIKE = CompatibilityError(
    "what is compared has no noise of its own in some position, as the angle between parallel vectors has none: "
    "compare something else, or change what the stand says of the place, such as its dip_deg"
)


def whitened(
    sigma: Array, value: Array, rows: Array, by_readings: Array | None, correlation: Array | None = None
) -> tuple[Array, Array]:
    """A residual and its rows over the noise of the readings, which residuals and positions may share.

    Parameters
    ----------
    sigma : array (k,) or (..., n, k)
        Standard deviations of the readings.
    value : array (..., n, m)
    rows : array (..., n, m, p)
    by_readings : array (..., n, m, k), or None where the residual is the readings themselves
    correlation : array (..., n, n), optional
        Of the noise of each channel in n positions; None: positions share none.

    Returns
    -------
    Both, with a noise of unit covariance: over the lower Cholesky factor of J diag(sigma^2) J', of positions that
    share noise of all of them together.
    """
    if by_readings is None:
        value, rows = value / sigma, rows / sigma[..., None]
        return over_shared(correlation, value[..., None])[..., 0], over_shared(correlation, rows)
    scaled = by_readings * sigma[..., None, :]
    if correlation is not None:
        return _together(correlation, value, rows, scaled)
    if value.shape[-1] == 1:
        size = np.sqrt((scaled * scaled).sum(axis=-1))
        return value / size, rows / size[..., None]
    with np.errstate(invalid="ignore"):
        covariance = scaled @ scaled.swapaxes(-1, -2)
    good = np.array(np.isfinite(covariance).all(axis=(-2, -1)))
    covariance = np.where(good[..., None, None], covariance, np.eye(value.shape[-1]))
    root = _root(covariance, _ALIKE)
    whole = np.linalg.solve(root, np.concatenate([value[..., None], rows], axis=-1))
    return whole[..., 0], whole[..., 1:]


def passed_on(own: Array, sigma: Array, by_readings: Array | None, *, shared: bool = False) -> Array:
    """Standard deviations (n m,) of residuals in units of the model's, of readings with their own, (n, k).

    Parameters
    ----------
    own : array (n, k)
    sigma : array (k,) or (n, k)
        What the model says of them.
    by_readings : array (n, m, k), or None where the residual is the readings themselves
    shared : bool
        Whether positions share noise: standard deviations in one ratio to the model's are all that goes with it.

    Raises
    ------
    CompatibilityError
        Others beside noise that is shared.
    """
    if shared and np.ptp(own / sigma, axis=0).any():
        raise CompatibilityError(
            "readings with standard deviations of their own can't be weighted beside noise that positions share: leave "
            "these out"
        )
    if by_readings is None:
        return np.asarray(own / sigma).reshape(-1)
    passed = [np.sqrt(((by_readings * each[..., None, :]) ** 2).sum(axis=-1)) for each in (own, sigma)]
    return np.asarray(passed[0] / passed[1]).reshape(-1)


def _together(correlation: Array, value: Array, rows: Array, scaled: Array) -> tuple[Array, Array]:
    """The same where what the residuals make of noise, J diag(sigma) (..., n, m, k), has to do with other positions."""
    *stack, n, m, p = rows.shape
    k = scaled.shape[-1]
    flat = scaled.reshape((*scaled.shape[:-3], n * m, k))
    spread = np.repeat(np.repeat(correlation, m, axis=-1), m, axis=-2)
    whole = np.concatenate([np.broadcast_to(value, rows.shape[:-1])[..., None], rows], axis=-1)
    right = whole.reshape((*stack, n * m, p + 1))
    found = np.linalg.solve(_root(spread * (flat @ flat.swapaxes(-1, -2))), right).reshape(whole.shape)
    return np.asarray(found[..., 0]), np.asarray(found[..., 1:])


def over_shared(correlation: Array | None, rows: Array, *, back: bool = False) -> Array:
    """Rows (..., n, m, p) over the Cholesky factor L of the correlations of n positions, (..., n, n), if there are any.

    `back` is for gradients by such rows: over the transpose of L.
    """
    if correlation is None:
        return rows
    root = _root(correlation)
    root = root.swapaxes(-1, -2) if back else root
    *stack, n, m, p = rows.shape
    return np.asarray(np.linalg.solve(root, rows.reshape((*stack, n, m * p)))).reshape(rows.shape)


def correlated(correlation: Array | None, noise: Array) -> Array:
    """Independent noise (..., n, k) with the correlations of n positions, (..., n, n), if there are any."""
    return noise if correlation is None else np.asarray(_root(correlation) @ noise)


def _root(covariance: Array, otherwise: AcalxError = _NO_NOISE) -> Array:
    """The lower Cholesky factor; an error where there is none."""
    try:
        return np.asarray(np.linalg.cholesky(covariance), dtype=float)
    except np.linalg.LinAlgError as error:
        raise otherwise from error


def flat(residual: Array, rows: Array) -> tuple[Array, Array]:
    """(..., n, m) and (..., n, m, p) with positions and outputs in one axis."""
    return residual.reshape((*residual.shape[:-2], -1)), rows.reshape((*rows.shape[:-3], -1, rows.shape[-1]))
