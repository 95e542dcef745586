"""The problem that an optimizer sees: stand, model, criterion and n bound together."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from acalx.arrays import Array
from acalx.criteria import Criterion
from acalx.errors import AcalxError, ArgumentError, CompatibilityError, PluginError
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
# So many times positions of a random program are drawn anew until all of them differ.
_MOST_DRAWS = 200
_BISECTIONS = 12
# Positions whose stimuli differ by less, in its unit, are replicates of each other: rounding on a
# stand with steps, and elsewhere one degree, since any two can be apart by next to nothing.
_SAME_STOP = 1e-6
_SAME_PLACE = 2.0 * np.sin(np.radians(0.5))


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
    fixed : array (f, d), in rad, optional
        Positions that must be in the program, measured already perhaps; the stand's limits do
        not bind them. They come first in every program.
    replicates : bool
        Whether positions may occur more than once. Otherwise any two differ: by one stop, or where
        the stand has no steps by one degree in what the sensor feels.

    Raises
    ------
    ArgumentError
        An n that is not a whole number, too small for the model or for the fixed positions, or
        too large for memory.
    CompatibilityError
        A model that needs what the stand does not provide; fewer stops than positions without
        replicates.
    """

    stand: Stand
    model: Model
    criterion: Criterion
    n: int
    fixed: Array | None = field(default=None, compare=False)
    replicates: bool = True

    def __post_init__(self) -> None:
        _check_n(self.n, self.model)
        if not isinstance(self.replicates, bool):
            raise ArgumentError(f"replicates={self.replicates!r}: must be true or false")
        if self.fixed is not None and len(self.fixed) >= self.n:
            raise ArgumentError(
                f"n={self.n} with {len(self.fixed)} fixed positions leaves nothing to choose: "
                f"n counts them too, so give n={len(self.fixed) + 1} or more"
            )
        self.criterion.check(self.model.parameters)
        self.model.check(self.stand.stimulus(self.stand.bounds[:, 0][None, :]), self.stand)

    def with_criterion(self, criterion: Criterion) -> Problem:
        """The same problem for another criterion."""
        return replace(self, criterion=criterion)

    @property
    def held(self) -> int:
        """Number f of positions that are fixed, the first ones of every program."""
        return 0 if self.fixed is None else len(self.fixed)

    @cached_property
    def base(self) -> Array:
        """Information matrix (p, p) of the fixed positions; zero without any."""
        p = len(self.parameters)
        if self.fixed is None:
            return np.zeros((p, p))
        return self.information(self.fixed).matrix

    @property
    def base_share(self) -> Array:
        """Of the information of the fixed positions what falls to each of the others, (p, p)."""
        return self.base / (self.n - self.held)

    @property
    def d(self) -> int:
        """Number of settings of a position."""
        return len(self.stand.settings)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The model's parameters."""
        return self.model.parameters

    def limits_around(self, settings: Array, hold: Sequence[bool] | None = None) -> tuple[Array, Array]:
        """Limits (..., n d) of all the angles around programs (..., n, d), infinite where there are none.

        Fixed positions are held where they are, and so are angles with steps, or those that
        `hold` says.
        """
        lower, upper = self.stand.limits_around(settings, hold)
        if self.fixed is not None:
            lower[..., : self.held, :] = upper[..., : self.held, :] = self.fixed
        shape = (*settings.shape[:-2], -1)
        return lower.reshape(shape), upper.reshape(shape)

    @cached_property
    def singles(self) -> tuple[Problem, ...]:
        """The same problem under each objective alone; itself where there is one criterion."""
        objectives = self.criterion.objectives
        return (self,) if len(objectives) == 1 else tuple(replace(self, criterion=single) for single in objectives)

    def losses(self, settings: Array) -> Array:
        """Loss of programs under each of the k objectives, +inf where singular: (..., n, d) in rad to (..., k)."""
        return np.stack([single.loss(settings) for single in self.singles], axis=-1)

    def random(self, rng: np.random.Generator, count: int) -> Array:
        """Random programs that are permitted, (count, n, d) in rad.

        Raises
        ------
        CompatibilityError
            Where none is found.
        """
        return self.apart(self._random(rng, count), rng)

    def apart(self, programs: Array, rng: np.random.Generator) -> Array:
        """Programs (s, n, d) with positions that must not repeat others drawn anew; CompatibilityError as `random`."""
        if self.replicates:
            return programs
        programs = programs.copy()
        for _ in range(_MOST_DRAWS):
            wrong = ~self.permits(programs)
            if not wrong.any():
                return programs
            # what collides with an earlier position is drawn again, not the whole program
            again = wrong[:, None] & self._repeated(programs) & (np.arange(self.n) >= self.held)
            programs[again] = self.stand.random(rng, (int(again.sum()),))
        raise CompatibilityError(
            f"no {self.n} different positions were found on stand {type(self.stand).__name__}: "
            "widen its limits, take fewer positions, or allow replicates=true"
        )

    def _random(self, rng: np.random.Generator, count: int) -> Array:
        if self.fixed is None:
            return self.stand.random(rng, (count, self.n))
        free = self.stand.random(rng, (count, self.n - self.held))
        return np.concatenate([np.broadcast_to(self.fixed, (count, *self.fixed.shape)), free], axis=1)

    @property
    def restricted(self) -> bool:
        """Whether some programs within the limits of the angles are not permitted."""
        return bool(self.stand.zones) or not self.replicates

    def permits(self, settings: Array, clearance: bool = False) -> np.ndarray:
        """Which programs (..., n, d) leave forbidden zones alone and repeat no position that may not be.

        The limits of single angles are not looked at: see `Stand.allows`. With a clearance, what
        is so close to a zone that rounding may put it there is not permitted either.
        """
        permitted = ~self.stand.forbids(settings[..., self.held :, :], clearance).any(axis=-1)
        if not self.replicates:
            permitted &= ~self._repeated(settings)[..., self.held :].any(axis=-1)
        return np.asarray(permitted)

    def project(self, settings: Array, allowed: Array) -> Array:
        """Programs (s, n, d) with each position that is not permitted moved back towards those of others.

        Parameters
        ----------
        settings : array (s, n, d), in rad
        allowed : array (s, n, d), in rad
            Permitted programs.
        """
        settings = settings.copy()
        wrong = self.stand.forbids(settings, clearance=True)
        wrong[:, : self.held] = False
        if wrong.any():
            settings[wrong] = self._up_to_zones(settings[wrong], allowed[wrong])
        if not self.replicates:
            near = self.alike(settings, settings)
            near[:, range(self.n), range(self.n)] = False
            settings = np.where(np.any(near, axis=-1, keepdims=True), allowed, settings)
        if self.restricted:
            settings = np.where(self.permits(settings, clearance=True)[:, None, None], settings, allowed)
        return settings

    def _up_to_zones(self, settings: Array, allowed: Array) -> Array:
        """The way (k, d) from allowed settings to others as far as bisection finds it free."""
        share = np.zeros(len(settings))
        for k in range(1, _BISECTIONS + 1):
            trial = share + 0.5**k
            between = allowed + trial[:, None] * (settings - allowed)
            share = np.where(self.stand.forbids(between, clearance=True), share, trial)
        return np.asarray(allowed + share[:, None] * (settings - allowed))

    def _repeated(self, settings: Array) -> np.ndarray:
        """Which positions (..., n) an earlier one of the same program replicates."""
        repeated = self.alike(settings, settings)
        return np.asarray(np.tril(repeated, -1).any(axis=-1))

    def alike(self, settings: Array, others: Array) -> np.ndarray:
        """Which positions (..., k, d) the sensor feels as it does others (..., l, d): (..., k, l).

        What of the stimulus the model does not read, it does not feel.
        """
        squares = np.zeros((*settings.shape[:-1], others.shape[-2]))
        stimulus, another = self.stand.stimulus(settings), self.stand.stimulus(others)
        for name in self.model.needs:
            felt, other = getattr(stimulus, name), getattr(another, name)
            squares += ((felt[..., :, None, :] - other[..., None, :, :]) ** 2).sum(axis=-1)
        steps_only = all(setting.step is not None for setting in self.stand.settings)
        limit = _SAME_STOP if steps_only else _SAME_PLACE * (1.0 - 1e-9)
        return np.asarray(squares < limit**2)

    def canonical(self, settings: Array) -> Array:
        """The same program with whole turns taken off, the fixed positions first, the others sorted by their angles."""
        wrapped = self.stand.wrap(settings[self.held :])
        order = np.lexsort(np.round(self.stand.written(wrapped), 6).T[::-1])
        return np.concatenate([settings[: self.held], wrapped[order]])

    def information(self, settings: Array) -> Information:
        """Information of programs: settings (..., n, d) in rad to matrices (..., p, p)."""
        return self.model.information(self.stand.stimulus(settings))

    def loss(self, settings: Array) -> Array:
        """Loss of programs, +inf where singular or not permitted: settings (..., n, d) in rad to (...).

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
        if self.restricted:
            losses[~self.permits(settings)] = np.inf
        return losses

    @property
    def chunk(self) -> int:
        """How many programs are worked on at a time."""
        return max(1, _CHUNK_BYTES // (self.n * self.model.entries * 8))

    def loss_of(self, information: Information, criterion: Criterion | None = None) -> Array:
        """Loss of given information under the problem's criterion or another, +inf where singular."""
        criterion = criterion or self.criterion
        if not information.singular.any():
            return self._call(criterion, criterion.loss, information, information.singular.shape)
        regular = ~information.singular
        losses = np.full(regular.shape, np.inf)
        if regular.any():
            rest = information.select(regular)
            losses[regular] = self._call(criterion, criterion.loss, rest, rest.singular.shape)
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
        information = self.model.information_of(regressors)
        permitted = self.permits(settings) if self.restricted else None
        return Linearization(self, settings, stimulus, regressors, information, permitted)

    def loss_and_gradient(self, settings: Array) -> tuple[Array, Array]:
        """Loss (...) and its gradient (..., n, d) with respect to the settings in rad."""
        at = self.linearize(settings)
        loss = self.loss_of(at.information)
        if at.permitted is not None:
            loss = np.where(at.permitted, loss, np.inf)
        return loss, at.pull(self.gradient_of(at.information))

    def _call(
        self, part: Criterion, method: Callable[[Information], Array], information: Information, shape: tuple[int, ...]
    ) -> Array:
        name, p = f"{type(part).__name__}.{method.__name__}", len(information.parameters)
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
                f"{name} returned shape {values.shape} for matrices of shape "
                f"{(*information.singular.shape, p, p)}; expected {shape}"
            )
        if np.isnan(values).any():
            raise PluginError(f"{name} returned nan for an information matrix that is not singular")
        return values


@dataclass(frozen=True)
class Linearization:
    """Programs with their information, ready to pull a gradient back to the settings.

    `permitted` is None where all programs are.
    """

    problem: Problem
    settings: Array
    stimulus: Stimulus
    regressors: Array
    information: Information
    permitted: np.ndarray | None = None

    def pull(self, gradient: Array) -> Array:
        """From a gradient with respect to the matrix, (..., p, p), to the settings, (..., n, d)."""
        rows = 2.0 * (self.regressors @ gradient[..., None, :, :])
        by_stimulus = dict(self.problem.model.pull(self.stimulus, rows).quantities())
        by_settings = dict(self.problem.stand.derivative(self.settings).quantities())
        total = np.zeros(self.settings.shape)
        for name, feels in by_stimulus.items():
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
