"""The problem that an optimizer sees: stand, model, criterion and n bound together."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from acalx.arrays import Array
from acalx.criteria import Criterion
from acalx.errors import AcalxError, ArgumentError, PluginError
from acalx.information import Information, Parameter
from acalx.models import Model
from acalx.stands import Stand
from acalx.stimulus import Stimulus

__all__ = ["Linearization", "Problem"]

# Regressors of at most this many bytes are computed at a time: large enough that calls don't
# count, small enough that the C library keeps the memory instead of asking for fresh pages at
# each call, which would take as long as the arithmetic; and a bound on memory.
_CHUNK_BYTES = 2**18
_MEMORY_LIMIT_BYTES = 4 * 2**30


@dataclass(frozen=True)
class Problem:
    """Choose n positions of a stand so that a criterion of a model's information is least.

    Parameters
    ----------
    stand : Stand
    model : Model
    criterion : Criterion
    n : int
        Number of positions.

    Raises
    ------
    ArgumentError
        An n that is not a whole number, too small for the model or too large for memory.
    CompatibilityError
        A model that needs what the stand does not provide.
    """

    stand: Stand
    model: Model
    criterion: Criterion
    n: int

    def __post_init__(self) -> None:
        _check_n(self.n, self.model)
        self.criterion.check(self.model.parameters)
        self.model.check(self.stand.stimulus(self.stand.bounds[:, 0][None, :]), self.stand)

    @property
    def d(self) -> int:
        """Number of settings of a position."""
        return len(self.stand.settings)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The model's parameters."""
        return self.model.parameters

    @property
    def limits(self) -> tuple[Array, Array]:
        """Bounds of all the angles of a program, (n d,) each, infinite where a full turn is open."""
        lower, upper = self.stand.free_bounds.T
        return np.tile(lower, self.n), np.tile(upper, self.n)

    @cached_property
    def singles(self) -> tuple[Problem, ...]:
        """The same problem under each objective alone; itself where there is one criterion."""
        objectives = self.criterion.objectives
        return (self,) if len(objectives) == 1 else tuple(replace(self, criterion=single) for single in objectives)

    def losses(self, settings: Array) -> Array:
        """Loss of programs under each of the k objectives, +inf where singular: (..., n, d) in rad to (..., k)."""
        return np.stack([single.loss(settings) for single in self.singles], axis=-1)

    def random(self, rng: np.random.Generator, count: int) -> Array:
        """Random programs, (count, n, d) in rad."""
        return self.stand.random(rng, (count, self.n))

    def canonical(self, settings: Array) -> Array:
        """The same program with whole turns taken off and positions sorted by their angles."""
        wrapped = self.stand.wrap(settings)
        order = np.lexsort(np.round(np.degrees(wrapped), 6).T[::-1])
        return np.asarray(wrapped[order])

    def information(self, settings: Array) -> Information:
        """Information of programs: settings (..., n, d) in rad to matrices (..., p, p)."""
        return self.model.information(self.stand.stimulus(settings))

    def loss(self, settings: Array) -> Array:
        """Loss of programs, +inf where singular: settings (..., n, d) in rad to (...).

        Raises
        ------
        PluginError
            Where a criterion raises or returns something other than one number a program.
        """
        stack = settings.shape[:-2]
        if len(stack) != 1:
            return self.loss(settings.reshape((-1, *settings.shape[-2:]))).reshape(stack)
        pieces = -(-len(settings) // self.chunk)
        size = -(-len(settings) // max(1, pieces))
        losses = np.empty(stack)
        for start in range(0, len(settings), max(1, size)):
            part = settings[start : start + size]
            if len(part) > self.n:  # arithmetic runs along the longer axis
                part = np.asfortranarray(part)
            losses[start : start + size] = self.loss_of(self.information(part))
        return losses

    @property
    def chunk(self) -> int:
        """How many programs are worked on at a time."""
        row = self.model.outputs * len(self.model.parameters) * 8
        return max(1, _CHUNK_BYTES // (self.n * row))

    def loss_of(self, information: Information, criterion: Criterion | None = None) -> Array:
        """Loss of given information under the problem's criterion or another, +inf where singular."""
        criterion = criterion or self.criterion
        if not information.singular.any():
            return self._call(criterion, criterion.loss, information, information.matrix.shape[:-2])
        regular = ~information.singular
        losses = np.full(regular.shape, np.inf)
        if regular.any():
            rest = information.select(regular)
            losses[regular] = self._call(criterion, criterion.loss, rest, rest.matrix.shape[:-2])
        return losses

    def gradient_of(self, information: Information, criterion: Criterion | None = None) -> Array:
        """Gradient with respect to the information matrix, (..., p, p); zero where singular."""
        criterion = criterion or self.criterion
        regular = ~information.singular
        if regular.all():
            return self._call(criterion, criterion.gradient, information, information.matrix.shape)
        gradients = np.zeros(information.matrix.shape)
        if regular.any():
            rest = information.select(regular)
            gradients[regular] = self._call(criterion, criterion.gradient, rest, rest.matrix.shape)
        return gradients

    def linearize(self, settings: Array) -> Linearization:
        """Information of programs (..., n, d), kept with what the chain rule needs."""
        stimulus = self.stand.stimulus(settings)
        regressors = self.model.regressors(stimulus)
        information = Information.from_regressors(regressors, self.model.parameters)
        return Linearization(self, settings, stimulus, regressors, information)

    def loss_and_gradient(self, settings: Array) -> tuple[Array, Array]:
        """Loss (...) and its gradient (..., n, d) with respect to the settings in rad."""
        at = self.linearize(settings)
        return self.loss_of(at.information), at.pull(self.gradient_of(at.information))

    def _call(
        self, part: Criterion, method: Callable[[Information], Array], information: Information, shape: tuple[int, ...]
    ) -> Array:
        name = f"{type(part).__name__}.{method.__name__}"
        try:
            given = method(information)
        except AcalxError:
            raise
        except Exception as error:
            frame = traceback.extract_tb(error.__traceback__)[-1]
            raise PluginError(
                f"{name} raised {type(error).__name__}: {error} ({frame.filename}, line {frame.lineno})"
            ) from error
        try:
            values = np.asarray(given, dtype=float)
        except (TypeError, ValueError) as error:
            raise PluginError(f"{name} returned {given!r}; expected numbers of shape {shape}") from error
        if values.shape != shape:
            raise PluginError(
                f"{name} returned shape {values.shape} for matrices of shape {information.matrix.shape}; "
                f"expected {shape}"
            )
        if np.isnan(values).any():
            raise PluginError(f"{name} returned nan for an information matrix that is not singular")
        return values


@dataclass(frozen=True)
class Linearization:
    """Programs with their information, ready to pull a gradient back to the settings."""

    problem: Problem
    settings: Array
    stimulus: Stimulus
    regressors: Array
    information: Information

    def pull(self, gradient: Array) -> Array:
        """From a gradient with respect to the matrix, (..., p, p), to the settings, (..., n, d)."""
        rows = 2.0 * (self.regressors @ gradient[..., None, :, :])
        by_stimulus = dict(self.problem.model.derivative(self.stimulus).quantities())
        by_settings = dict(self.problem.stand.derivative(self.settings).quantities())
        total = np.zeros(self.settings.shape)
        for name, derivative in by_stimulus.items():
            feels = np.einsum("...nmp,...nmpk->...nk", rows, derivative)
            total += (feels[..., None, :] @ by_settings[name])[..., 0, :]
        return total


def _check_n(n: int, model: Model) -> None:
    name, p, least = type(model).__name__, len(model.parameters), model.smallest_n
    if not isinstance(n, (int, np.integer)) or isinstance(n, bool):
        raise ArgumentError(f"n={n}: the number of positions must be a whole number, such as n={2 * least}")
    if n < least:
        raise ArgumentError(f"n={n}: the {p} parameters of {name} need {least} positions or more")
    # the rows and their derivatives, for several programs at a time
    each = model.outputs * p * 8 * 128
    need = n * each
    if need > _MEMORY_LIMIT_BYTES:
        most = _MEMORY_LIMIT_BYTES // each
        raise ArgumentError(f"n={n}: would take about {need / 2**30:.0f} GB of memory; n={most} is the most")
