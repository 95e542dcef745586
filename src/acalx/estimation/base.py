"""Estimators: from readings to the parameters of a sensor, with all that their accuracy follows from."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from acalx.errors import ArgumentError
from acalx.estimation.estimate import Estimate, information_of, positive, scale_of
from acalx.estimation.losses import Loss
from acalx.models import Comparison, Model, compared_by
from acalx.numerics.arrays import Array
from acalx.options import is_number, is_whole
from acalx.quantities.information import Information
from acalx.quantities.stimulus import Stimulus

__all__ = ["Estimator"]

# Rows of at most this many bytes are worked on at a time: they stay in the processor's cache.
_CHUNK_BYTES = 2**20
# A median jumps from one residual to another, for ever with some readings: the scale of a robust
# loss follows the residuals for so many steps and is then kept.
_SCALE_STEPS = 20
# The sizes of several noises that are no medians are followed until they change by no more than this, so many times.
_SETTLED, _MOST_ROUNDS = 1e-6, 100
# So many roundings of a reading are in a residual, at most: what is smaller says nothing.
_ROUNDINGS = 16.0 * float(np.finfo(float).eps)
# They are not looked at before so many steps: as a rule these are enough without.
_FEW = 2
Linearize = Callable[[Array], tuple[Array, Array]]


class Estimator(ABC):
    """A way to estimate, built from options; it takes stacks of readings.

    A new one gives `linearization`: the residual and its rows at given parameters. Steps of least
    squares on those, with the weights of the loss, are repeated until they are small.
    Concrete estimators are frozen dataclasses.
    """

    comparison: Comparison | None
    loss: Loss
    tolerance: float
    iterations: int

    def check_options(self) -> None:
        """Raise ArgumentError for an option that is not acceptable."""
        if self.comparison is not None and not isinstance(self.comparison, Comparison):
            rule = "must be Magnitude(), Projection() or Outputs(), or None for what the model compares"
            raise ArgumentError.of("comparison", self.comparison, rule)
        if not isinstance(self.loss, Loss):
            raise ArgumentError.of("loss", self.loss, "must be Squares(), Huber() or Bisquare()")
        if not is_number(self.tolerance) or not 1e-15 <= self.tolerance <= 1e-2:
            raise ArgumentError.of("tolerance", self.tolerance, "give a number from 1e-15 to 1e-2, such as 1e-6")
        if not is_whole(self.iterations) or self.iterations < 1:
            raise ArgumentError.of("iterations", self.iterations, "give a whole number, 1 or more")

    def model_for(self, model: Model) -> Model:
        """The model with what the estimator compares; CompatibilityError where its readings do not have that."""
        return compared_by(model, self.comparison)

    @abstractmethod
    def linearization(self, model: Model, readings: Array, known: Stimulus | None) -> Linearize:
        """A function from parameters (..., p) to what they leave of the residual (..., n m), and rows (..., n m, p)."""

    def estimate(
        self,
        model: Model,
        readings: Array,
        known: Stimulus | None = None,
        noise: Array | None = None,
        start: Array | None = None,
    ) -> Estimate:
        """Estimate the parameters of each sensor of a stack.

        Parameters
        ----------
        model : Model
        readings : array (..., n, k)
            Of `Model.channels`, each in its unit.
        known : arrays (n, width) or (..., n, width), optional
            What is known of the stimulus in each position, in sensor axes.
        noise : array (n m,) or (..., n m), optional
            Known standard deviation of each residual in units of the model's noise; residuals then count by its
            inverse square. None: the sizes of the noises are estimated, and only relative to each other taken
            from the model.
        start : array (p,) or (..., p), optional
            Nominal parameters if it is not given.

        Returns
        -------
        Estimate
            With nan where the positions can't show all the parameters.

        Raises
        ------
        ArgumentError, CompatibilityError
            A robust loss with too few positions; a comparison that the readings do not have.
        """
        model = self.model_for(model)
        noises = model.noises
        if noise is not None or len(noises.parameters) == 1:
            return self._estimate(model, readings, known, noise, start, np.zeros(0))
        return self._with_several_noises(model, readings, known, start)

    def _with_several_noises(
        self, model: Model, readings: Array, known: Stimulus | None, start: Array | None
    ) -> Estimate:
        """Weights from the residuals of each noise, until they stay: they matter where parameters show in several."""
        n, noises = readings.shape[-2], model.noises
        of_residuals = np.tile(noises.of_outputs, n)
        sizes = np.ones((*readings.shape[:-2], len(noises.parameters)))
        least = _rounding(model, readings, known)[..., None]
        weighs = noises.shared or model.informed
        rounds = _SCALE_STEPS if self.loss.robust else _MOST_ROUNDS if weighs else 1
        settled = np.full(readings.shape[:-2], self.loss.robust or not weighs)
        for _ in range(rounds):
            found = self._estimate(model, readings, known, sizes[..., of_residuals], start, sizes)
            before, start = sizes, found.parameters
            sizes = np.maximum(found.sizes_of_noises(noises, of_residuals), least)
            same = (np.abs(sizes - before) <= _SETTLED * before + least).all(axis=-1)
            if (same | ~np.isfinite(sizes).all(axis=-1)).all():
                break
        found = self._estimate(model, readings, known, sizes[..., of_residuals], start, sizes)
        return replace(found, converged=found.converged & (settled | same))

    def _estimate(
        self,
        model: Model,
        readings: Array,
        known: Stimulus | None,
        noise: Array | None,
        start: Array | None,
        sizes: Array,
    ) -> Estimate:
        *stack, n, width = readings.shape
        p = len(model.parameters)
        count = n * model.outputs
        self._check_count(count, p, noise)
        flat = readings.reshape(-1, n, width)
        starts = np.broadcast_to(model.nominal if start is None else start, (*stack, p)).reshape(-1, p)
        felt = {} if known is None else {name: _members(array, known, stack) for name, array in known.items()}
        noise_of = _each(noise, stack)
        parts: list[tuple[Array, ...]] = []
        iterations = 0
        size = max(1, _CHUNK_BYTES // (count * p * 8))
        with np.errstate(all="ignore"):  # a member that can't be estimated may go anywhere; `converged` tells
            for begin in range(0, len(flat), size):
                part = slice(begin, begin + size)
                piece = flat[part] if len(flat) == 1 else np.asfortranarray(flat[part])
                of_part = None if known is None else known.made({name: of(part) for name, of in felt.items()})
                linearize = self.linearization(model, piece, of_part)
                rounding = partial(_rounding, model, piece, of_part)
                x, converged, steps = _descend(linearize, starts[part], self, noise_of(part), model, rounding)
                left, rows = linearize(x)
                parts.append((x, left, rows if rows.ndim > 2 else rows[None], converged))
                iterations = max(iterations, steps)
        shared = rows.ndim == 2
        x, left, rows, converged = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        x, left, converged = x.reshape((*stack, p)), left.reshape((*stack, count)), converged.reshape(stack)
        rows = rows[0] if shared else rows.reshape((*stack, count, p))
        return Estimate(model, x, left, rows, noise, self.loss, converged, iterations, sizes)

    def _check_count(self, count: int, p: int, noise: Array | None) -> None:
        """Refuse a robust loss that as few residuals as parameters leave nothing to judge by."""
        if self.loss.robust and noise is None and count <= p:
            raise ArgumentError(
                f"a robust loss needs more positions than the {p} parameters to tell which are far out; got {count}"
            )


def _rounding(model: Model, readings: Array, known: Stimulus | None) -> Array:
    """The size (...) of what rounding leaves in a residual, in units of the model's noise."""
    felt = Stimulus() if known is None else known
    if set(model.needs) <= set(felt):
        deviations = model.deviations(felt)
    else:  # they may depend on what follows from the readings
        deviations = np.array([channel.noise for channel in model.channels])
    if deviations.ndim > 1:
        return np.asarray(_ROUNDINGS * np.abs(readings / deviations).max(axis=(-2, -1)))
    largest = np.maximum(readings.max(axis=-2), -readings.min(axis=-2))
    return np.asarray(_ROUNDINGS * (largest / deviations).max(axis=-1))


def _descend(
    linearize: Linearize,
    start: Array,
    options: Estimator,
    noise: Array | None,
    model: Model,
    rounding: Callable[[], Array],
) -> tuple[Array, np.ndarray, int]:
    """Weighted steps of Gauss and Newton for a stack (T, p), each loss from where the one before it ended.

    Steps are measured in standard errors: d' M d is p for one that is as long as those are. None is shorter than what
    rounding (T,) of the residuals makes of it, which is looked at where two steps were not enough.
    """
    losses = [options.loss]
    while (first := losses[0].first) is not None:
        losses.insert(0, first)
    x, iterations = start, 0
    prior = model.prior_information
    informed = model.informed
    converged = np.zeros(len(x), dtype=bool)
    floor: Array | None = None
    for loss in losses:
        scale = np.ones(len(x))
        for count in range(options.iterations):
            residual, rows = linearize(x)
            if noise is not None:
                residual, rows = residual / noise, rows / noise[..., None]
            if (loss.robust or (informed and noise is None)) and count < _SCALE_STEPS:
                freedom = residual.shape[-1] - x.shape[-1] + int(np.count_nonzero(prior))
                scale = positive(scale_of(residual, freedom, loss, noise))
            before = scale[..., None] ** 2 * prior if informed else None
            step, length = _step(residual, rows, loss, scale, model, before, model.nominal - x)
            x = x + step
            iterations += 1
            if noise is None and not loss.robust:
                variance = (residual * residual).sum(axis=-1) / max(1, residual.shape[-1] - x.shape[-1])
            else:
                variance = scale**2
            enough = options.tolerance**2 * variance
            converged = length <= x.shape[-1] * enough
            if count >= _FEW and not converged.all():
                floor = _squared(rounding(), noise) if floor is None else floor
                converged = length <= x.shape[-1] * (enough + floor)
            if (converged | ~np.isfinite(length)).all():
                break
    return x, converged, iterations


def _squared(rounding: Array, noise: Array | None) -> Array:
    return np.asarray(rounding**2 if noise is None else (rounding / noise.min(axis=-1)) ** 2)


def _step(
    residual: Array, rows: Array, loss: Loss, scale: Array, model: Model, prior: Array | None, back: Array
) -> tuple[Array, Array]:
    """Least squares of a residual (T, n) on rows (n, p) or (T, n, p), weighted by a loss of that scale (T,).

    With information (T, p) that is there before, towards where `back` (T, p) leads. The step d (T, p), and d' M d (T,)
    with the information M.
    """
    if loss.robust:
        root = np.sqrt(loss.weight(residual / scale[..., None]))
        residual, rows = residual * root, rows * root[..., None]
    information = information_of(rows, model)
    pull = residual @ rows if rows.ndim == 2 else np.einsum("...n,...nj->...j", residual, rows)
    if prior is not None:
        information = Information(information.matrix + prior[..., None] * np.eye(prior.shape[-1]), model.parameters)
        pull = pull + prior * back
    step = information.solve(pull)
    return step, (step * pull).sum(axis=-1)


def _members(array: Array, known: Stimulus, stack: list[int]) -> Callable[[slice], Array]:
    """Gives the part of a known quantity that belongs to some members of the stack; all of it where they share it."""
    own = 2 if known.weights is None else 3
    if array.ndim == own:
        return lambda part: array
    shape = array.shape[-own:]
    flat = np.broadcast_to(array, (*stack, *shape)).reshape(-1, *shape)
    return lambda part: flat[part]


def _each(noise: Array | None, stack: list[int]) -> Callable[[slice], Array | None]:
    """The same of what is known of the noise."""
    if noise is None or noise.ndim == 1:
        return lambda part: noise
    flat = np.broadcast_to(noise, (*stack, noise.shape[-1])).reshape(-1, noise.shape[-1])
    return lambda part: flat[part]
