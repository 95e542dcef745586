"""Estimators: from readings to the parameters of a sensor, with all that their accuracy follows from."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from acalx.errors import ArgumentError
from acalx.estimation.losses import Loss
from acalx.estimation.residuals import Residual
from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.options import is_number, is_whole
from acalx.quantities.information import Information
from acalx.quantities.stimulus import Stimulus

__all__ = ["Estimate", "Estimator"]

# Rows of at most this many bytes are worked on at a time: they stay in the processor's cache.
_CHUNK_BYTES = 2**20
_MEDIAN_OF_NORMAL = 0.6744897501960817
# A median jumps from one residual to another, for ever with some readings: the scale of a robust
# loss follows the residuals for so many steps and is then kept.
_SCALE_STEPS = 20
Linearize = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class Estimate:
    """Parameters of a sensor, or of a stack of simulated ones, and the readings they come from.

    Parameters
    ----------
    model : Model
    parameters : array (..., p)
        In g, relative, rad; nan where the positions can't show them.
    residual : array (..., n)
    rows : array (..., n, p), or (n, p) where all have the same
        What the parameters leave of the residuals, and the regressors there; n m of them with m outputs a position.
    noise : array (n,) or (..., n), optional
        Standard deviation of each residual, where it is known.
    loss : Loss
    converged : array (...)
        Whether the last step was below the tolerance.
    iterations : int
    """

    model: Model
    parameters: Array
    residual: Array
    rows: Array
    noise: Array | None
    loss: Loss
    converged: np.ndarray
    iterations: int

    @property
    def freedom(self) -> int:
        """Degrees of freedom of the residuals, n - p."""
        return int(self.residual.shape[-1] - self.parameters.shape[-1])

    @cached_property
    def information(self) -> Information:
        """H'H, each row divided by the standard deviation of its residual where that is known."""
        rows = self.rows if self.noise is None else self.rows / self.noise[..., None]
        return _information(rows, self.model)

    @cached_property
    def scaled(self) -> Array:
        """Residuals in units of their known standard deviation, or as they are, (..., n)."""
        return self.residual if self.noise is None else self.residual / self.noise

    @cached_property
    def scale(self) -> Array:
        """Standard deviation of a residual in units of `scaled`, (...): 1 where the noise is known.

        Nan where there are as many parameters as positions.
        """
        return _scale(self.scaled, self.freedom, self.loss, self.noise)

    @property
    def variance(self) -> Array:
        """Factor (...) that makes inv(H'H) the covariance of the parameters.

        Where the noise is estimated, s^2 (sum psi^2 / (n - p)) / (mean psi')^2, which for
        squares is the residual variance. Source: Huber, Robust Statistics (1981), chapter 7.
        """
        if self.noise is not None:
            return np.full(self.parameters.shape[:-1], self.loss.variance_factor)
        if self.freedom <= 0:
            return np.full(self.parameters.shape[:-1], np.nan)
        u = self.residual / _positive(self.scale)[..., None]
        psi = u * self.loss.weight(u)
        slope = self.loss.slope(u).mean(axis=-1)
        return np.asarray(self.scale**2 * (psi * psi).sum(axis=-1) / self.freedom / slope**2)

    @property
    def covariance(self) -> Array:
        """Covariance of the parameters, (..., p, p); nan where the noise can't be told."""
        return np.asarray(self.information.covariance * self.variance[..., None, None])

    @property
    def standard_errors(self) -> Array:
        """Standard errors of the parameters, (..., p)."""
        return np.sqrt(self.information.variances * self.variance[..., None])


class Estimator(ABC):
    """A way to estimate, built from options; it takes stacks of readings.

    A new one gives `linearization`: the residual and its rows at given parameters. Steps of least
    squares on those, with the weights of the loss, are repeated until they are small.
    Concrete estimators are frozen dataclasses.
    """

    residual: Residual
    loss: Loss
    tolerance: float
    iterations: int

    def check_options(self) -> None:
        """Raise ArgumentError for an option that is not acceptable."""
        if not isinstance(self.residual, Residual):
            raise ArgumentError.of("residual", self.residual, "must be Magnitude(), Oriented() or Outputs()")
        if not isinstance(self.loss, Loss):
            raise ArgumentError.of("loss", self.loss, "must be Squares(), Huber() or Bisquare()")
        if not is_number(self.tolerance) or not 1e-15 <= self.tolerance <= 1e-2:
            raise ArgumentError.of("tolerance", self.tolerance, "give a number from 1e-15 to 1e-2, such as 1e-10")
        if not is_whole(self.iterations) or self.iterations < 1:
            raise ArgumentError.of("iterations", self.iterations, "give a whole number, 1 or more")

    @abstractmethod
    def linearization(self, model: Model, measurement: Array, stimulus: Stimulus | None) -> Linearize:
        """A function from parameters (..., p) to what they leave of the residual, and rows."""

    def estimate(
        self,
        model: Model,
        measurement: Array,
        stimulus: Stimulus | None = None,
        noise: Array | None = None,
        start: Array | None = None,
    ) -> Estimate:
        """Estimate the parameters of each sensor of a stack.

        Parameters
        ----------
        model : Model
        measurement : array (..., n, k)
            Readings of `Model.measurement`, of an accelerometer triad in g.
        stimulus : arrays (n, 3) or (..., n, 3), optional
            What the sensor feels, the vertical in its axes, where it is known.
        noise : array (n,) or (..., n), optional
            Known standard deviation of each residual; positions then count by its inverse square.
        start : array (p,) or (..., p), optional
            Zero if it is not given.

        Returns
        -------
        Estimate
            With nan where the positions can't show all the parameters.

        Raises
        ------
        ArgumentError, CompatibilityError
            A robust loss with too few positions; a residual that the model does not have.
        """
        self.residual.check(model)
        *stack, n, width = measurement.shape
        p = len(model.parameters)
        count = n * model.outputs
        self._check_count(count, p, noise)
        flat = measurement.reshape(-1, n, width)
        starts = np.broadcast_to(0.0 if start is None else start, (*stack, p)).reshape(-1, p)
        felt = {} if stimulus is None else {name: _members(array, 2, stack) for name, array in stimulus.quantities()}
        noises = _members(noise, 1, stack)
        parts: list[tuple[Array, ...]] = []
        iterations = 0
        size = max(1, _CHUNK_BYTES // (count * p * 8))
        with np.errstate(all="ignore"):  # a member that can't be estimated may go anywhere; `converged` tells
            for begin in range(0, len(flat), size):
                part = slice(begin, begin + size)
                piece = flat[part] if len(flat) == 1 else np.asfortranarray(flat[part])
                known = Stimulus(**{name: of(part) for name, of in felt.items()}) if felt else None
                linearize = self.linearization(model, piece, known)
                x, converged, steps = _descend(linearize, starts[part], self, noises(part), model)
                left, rows = linearize(x)
                parts.append((x, left, rows if rows.ndim > 2 else rows[None], converged))
                iterations = max(iterations, steps)
        shared = rows.ndim == 2
        x, left, rows, converged = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        x, left, converged = x.reshape((*stack, p)), left.reshape((*stack, count)), converged.reshape(stack)
        rows = rows[0] if shared else rows.reshape((*stack, count, p))
        return Estimate(model, x, left, rows, noise, self.loss, converged, iterations)

    def _check_count(self, count: int, p: int, noise: Array | None) -> None:
        """Refuse a robust loss that as few residuals as parameters leave nothing to judge by."""
        if self.loss.robust and noise is None and count <= p:
            raise ArgumentError(
                f"a robust loss needs more positions than the {p} parameters to tell which are far out; got {count}"
            )


def _descend(
    linearize: Linearize, start: Array, options: Estimator, noise: Array | None, model: Model
) -> tuple[Array, np.ndarray, int]:
    """Weighted steps of Gauss and Newton for a stack (T, p), each loss from where the one before it ended."""
    losses = [options.loss]
    while (first := losses[0].first) is not None:
        losses.insert(0, first)
    x, iterations = start, 0
    converged = np.zeros(len(x), dtype=bool)
    for loss in losses:
        scale = np.ones(len(x))
        for count in range(options.iterations):
            residual, rows = linearize(x)
            if noise is not None:
                residual, rows = residual / noise, rows / noise[..., None]
            if loss.robust and count < _SCALE_STEPS:
                scale = _positive(_scale(residual, residual.shape[-1] - x.shape[-1], loss, noise))
            step = _step(residual, rows, loss, scale, model)
            x = x + step
            iterations += 1
            size = np.abs(step).max(axis=-1)
            converged = size <= options.tolerance
            if (converged | ~np.isfinite(size)).all():
                break
    return x, converged, iterations


def _step(residual: Array, rows: Array, loss: Loss, scale: Array, model: Model) -> Array:
    """Least squares of a residual (T, n) on rows (n, p) or (T, n, p), weighted by a loss of that scale (T,)."""
    if loss.robust:
        root = np.sqrt(loss.weight(residual / scale[..., None]))
        residual, rows = residual * root, rows * root[..., None]
    information = _information(rows, model)
    pull = residual @ rows if rows.ndim == 2 else np.einsum("...n,...nj->...j", residual, rows)
    return information.solve(pull)


def _information(rows: Array, model: Model) -> Information:
    """H'H of rows (..., n, p): along the stack where that is first in memory, else member by member."""
    if rows.flags.f_contiguous and not rows.flags.c_contiguous:
        return Information.from_regressors(rows[..., None, :], model.parameters)
    return Information(rows.swapaxes(-1, -2) @ rows, model.parameters)


def _scale(scaled: Array, freedom: int, loss: Loss, noise: Array | None) -> Array:
    """Standard deviation of residuals (..., n): 1 if known, root mean square, or median deviation."""
    if noise is not None:
        return np.ones(scaled.shape[:-1])
    if freedom <= 0:
        return np.full(scaled.shape[:-1], np.nan)
    if not loss.robust:
        return np.asarray(np.sqrt((scaled * scaled).sum(axis=-1) / freedom))
    share = np.sqrt(scaled.shape[-1] / freedom)  # fitted residuals are smaller than the noise
    return np.asarray(np.median(np.abs(scaled), axis=-1) / _MEDIAN_OF_NORMAL * share)


def _positive(scale: Array) -> Array:
    """Where everything fits exactly nothing is far out."""
    return np.maximum(scale, np.finfo(float).tiny)


def _members(array: Array | None, own: int, stack: list[int]) -> Callable[[slice], Array | None]:
    """Gives the part of an array that belongs to some members of the stack; all of it where they share it."""
    if array is None or array.ndim == own:
        return lambda part: array
    shape = array.shape[-own:]
    flat = np.broadcast_to(array, (*stack, *shape)).reshape(-1, *shape)
    return lambda part: flat[part]
