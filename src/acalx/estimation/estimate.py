"""What an estimate is, and how accurate."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from acalx.estimation.losses import Loss
from acalx.models import Model
from acalx.models.base import Noises
from acalx.numerics.arrays import Array
from acalx.quantities.information import Information

__all__ = ["Estimate", "information_of", "positive", "scale_of"]

_MEDIAN_OF_NORMAL = 0.6744897501960817


@dataclass(frozen=True, eq=False)
class Estimate:
    """Parameters of a sensor, or of a stack of simulated ones, and the readings they come from.

    Parameters
    ----------
    model : Model
    parameters : array (..., p)
        In their units; nan where the positions can't show them.
    residual : array (..., n m)
    rows : array (..., n m, p), or (n m, p) where all have the same
        What the parameters leave of the residuals, in units of the model's noise, and the regressors there.
    noise : array (n m,) or (..., n m), optional
        Standard deviation of each residual in the same unit, where it is known, or was estimated for several noises.
    loss : Loss
    converged : array (...)
        Whether the last step was below the tolerance.
    iterations : int
    sizes : array (..., g)
        Of several noises that were estimated, each in units of the model's; empty otherwise.
    """

    model: Model
    parameters: Array
    residual: Array
    rows: Array
    noise: Array | None
    loss: Loss
    converged: np.ndarray
    iterations: int
    sizes: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def known(self) -> bool:
        """Whether the noise was known rather than estimated from the residuals."""
        return self.noise is not None and not self.sizes.size

    @cached_property
    def freedom(self) -> Array:
        """Degrees of freedom of the residuals: their number less that of the parameters, or of what these fit away.

        With a prior the residuals of each member fit away less, (...); otherwise one number for all, (). Of several
        noises the least.
        """
        if self.sizes.size:
            return np.asarray(self._left_of_noises().min(axis=-1))
        count, p = self.residual.shape[-1], self.parameters.shape[-1]
        if not self.model.informed:
            return np.asarray(float(count - p))
        prior = self.model.prior_information
        matrix = information_of(self._over_noise, self.model).matrix
        left = float(count - p + np.count_nonzero(prior))
        # what a prior says counts in units of the residuals
        size = positive(scale_of(self.residual, max(1.0, left), self.loss, self.noise))
        whole = Information(matrix + (size**2)[..., None, None] * np.diag(prior), self.model.parameters)
        with np.errstate(invalid="ignore"):  # nan where a member has no estimate
            return np.asarray(count - (whole.covariance * matrix).sum(axis=(-2, -1)))

    @cached_property
    def freedoms(self) -> Array:
        """Degrees of freedom with which the error of each parameter is told, (..., p), or (p,) where all have those."""
        p = self.parameters.shape[-1]
        if not self.sizes.size:
            return np.broadcast_to(self.freedom[..., None], (*self.freedom.shape, p))
        noises, m = self.model.noises, self.model.outputs
        n, each = self.residual.shape[-1] // m, self._left_of_noises()
        shows = (np.abs(self.rows.reshape(-1, n, m, p)) > 0.0).any(axis=(0, 1))  # (m, p)
        freedoms = np.where(shows, each[..., noises.of_outputs, None], np.inf).min(axis=-2)
        return np.asarray(np.where(np.isposinf(freedoms), each.min(axis=-1, keepdims=True), freedoms))

    @property
    def of_noises(self) -> np.ndarray:
        """The number of the noise that each residual has, (n m,); 0 where there is one for all."""
        if not self.sizes.size:
            return np.zeros(self.residual.shape[-1], dtype=int)
        of_outputs = self.model.noises.of_outputs
        return np.tile(of_outputs, self.residual.shape[-1] // len(of_outputs))

    @property
    def freedom_of_residuals(self) -> Array:
        """Degrees of freedom of the noise of each residual, (..., n m), or (n m,)."""
        each = self._left_of_noises() if self.sizes.size else self.freedom[..., None]
        return np.asarray(each[..., self.of_noises], dtype=float)

    def _left_of_noises(self) -> Array:
        """Degrees of freedom of each of several noises, (g,): residuals less the parameters that are fitted to them.

        With a prior, or parameters that show in several, that is what the leverages of the residuals add up to in each
        member, (..., g).
        """
        noises = self.model.noises
        n = self.residual.shape[-1] // len(noises.of_outputs)
        counts = n * np.bincount(noises.of_outputs)
        if not self.model.informed and not noises.shared:
            return np.asarray(counts - noises.parameters)
        rows = self._over_noise
        leverage = np.einsum("...np,...pq,...nq->...n", rows, self.information.covariance, rows)
        of_noise = np.tile(noises.of_outputs, n) == np.arange(len(counts))[:, None]
        fitted = leverage @ of_noise.T.astype(float)
        good = np.isfinite(fitted).all(axis=-1, keepdims=True)
        return np.asarray(counts - np.where(good, fitted, noises.parameters))

    def sizes_of_noises(self, noises: Noises, of_residuals: np.ndarray) -> Array:
        """The size of each noise in units of the model's, (..., g), from the residuals that it is the noise of."""
        sizes, freedoms = [], self._left_of_noises()
        for k in range(freedoms.shape[-1]):
            size = scale_of(self.residual[..., of_residuals == k], freedoms[..., k], self.loss, None)
            sizes.append(np.where(freedoms[..., k] > 0.0, size, 1.0))
        return positive(np.stack(sizes, axis=-1))

    @property
    def _over_noise(self) -> Array:
        """Rows over the standard deviation of their residual, where that is known."""
        return self.rows if self.noise is None else self.rows / self.noise[..., None]

    @cached_property
    def information(self) -> Information:
        """H'H, each row over the standard deviation of its residual where that is known, with what a prior says."""
        found = information_of(self._over_noise, self.model)
        if not self.model.informed:
            return found
        prior = self.model.prior_information
        size = np.ones(self.parameters.shape[:-1]) if self.noise is not None else positive(self.scale)
        matrix = found.matrix + (size**2)[..., None, None] * np.diag(prior)
        return Information(matrix, self.model.parameters)

    @cached_property
    def scaled(self) -> Array:
        """Residuals in units of their known standard deviation, or as they are, (..., n m)."""
        return self.residual if self.noise is None else self.residual / self.noise

    @cached_property
    def scale(self) -> Array:
        """Standard deviation of a residual in units of `scaled`, (...): 1 where the noise is known.

        Nan where there are as many parameters as positions.
        """
        return scale_of(self.scaled, self.freedom, self.loss, self.noise)

    @property
    def variance(self) -> Array:
        """Factor (...) that makes inv(H'H) the covariance of the parameters.

        Where the noise is estimated, s^2 (sum psi^2 / (n - p)) / (mean psi')^2, which for
        squares is the residual variance. Source: Huber, Robust Statistics (1981), chapter 7.
        """
        if self.noise is not None:
            return np.full(self.parameters.shape[:-1], self.loss.variance_factor)
        u = self.residual / positive(self.scale)[..., None]
        psi = u * self.loss.weight(u)
        slope = self.loss.slope(u).mean(axis=-1)
        return np.asarray(self.scale**2 * (psi * psi).sum(axis=-1) / _judging(self.freedom) / slope**2)

    @property
    def covariance(self) -> Array:
        """Covariance of the parameters, (..., p, p); nan where the noise can't be told."""
        return np.asarray(self.information.covariance * self.variance[..., None, None])

    @property
    def standard_errors(self) -> Array:
        """Standard errors of the parameters, (..., p)."""
        return np.sqrt(self.information.variances * self.variance[..., None])


def information_of(rows: Array, model: Model) -> Information:
    """H'H of rows (..., n, p): along the stack where that is first in memory, else member by member."""
    if rows.flags.f_contiguous and not rows.flags.c_contiguous:
        return Information.from_regressors(rows[..., None, :], model.parameters)
    return Information(rows.swapaxes(-1, -2) @ rows, model.parameters)


def scale_of(scaled: Array, freedom: Array | float, loss: Loss, noise: Array | None) -> Array:
    """Standard deviation of residuals (..., n): 1 if known, root mean square, or median deviation.

    Nan where the degrees of freedom, one number or (...), are none.
    """
    if noise is not None:
        return np.ones(scaled.shape[:-1])
    freedom = _judging(freedom)
    if not loss.robust:
        return np.asarray(np.sqrt((scaled * scaled).sum(axis=-1) / freedom))
    share = np.sqrt(scaled.shape[-1] / freedom)  # fitted residuals are smaller than the noise
    return np.asarray(np.median(np.abs(scaled), axis=-1) / _MEDIAN_OF_NORMAL * share)


def _judging(freedom: Array | float) -> Array:
    """Degrees of freedom that tell a scale: nan where there are none."""
    return np.where(np.asarray(freedom) > 0.0, freedom, np.nan)


def positive(scale: Array) -> Array:
    """Where everything fits exactly nothing is far out."""
    return np.maximum(scale, np.finfo(float).tiny)
