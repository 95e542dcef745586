"""Which programs there are to choose from: limits, forbidden zones, fixed positions, replicates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from acalx.errors import CompatibilityError, Option
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import VECTORS, Stimulus
from acalx.stands import Stand

__all__ = ["Restrictions"]

# Positions whose stimuli differ by less, as a share of their size, are replicates of each other: rounding on a
# stand with steps, and elsewhere one degree, since any two can be apart by next to nothing.
_SAME_STOP = 1e-6
_SAME_PLACE = 2.0 * np.sin(np.radians(0.5))
# So many times positions of a random program are drawn anew until all of them differ.
_MOST_DRAWS = 200
_HALVINGS = 12
# Positions that one call may be asked about where that saves calls.
_IN_ONE_CALL = 1024
# So many positions, the limits among them, show how large a quantity is on a stand.
_LOOKED_AT = 1000


@dataclass(frozen=True, eq=False)
class Restrictions:
    """The programs of n positions that a stand can take and a user permits.

    Parameters
    ----------
    stand : Stand
    feels : sequence of str
        Quantities of the stimulus by which positions differ: those that the model reads.
    n : int
    fixed : array (f, d), in rad, optional
        Positions that must be in the program, the first ones of every one.
    replicates : bool
        Whether positions may occur more than once.
    ordered : bool
        Whether the order of the positions matters.
    """

    stand: Stand
    feels: Sequence[str]
    n: int
    fixed: Array | None
    replicates: bool
    ordered: bool = False

    @property
    def held(self) -> int:
        """Number f of positions that are fixed."""
        return 0 if self.fixed is None else len(self.fixed)

    @property
    def sizes(self) -> Array:
        """What is about as much of each setting, (d,): see `acalx.stands.axes.Axes.sizes`."""
        return self.stand.axes.sizes

    def limits_around(self, settings: Array, hold: Sequence[bool] | None = None) -> tuple[Array, Array]:
        """Limits (..., n d) of all the angles around programs (..., n, d), infinite where there are none.

        Fixed positions are held where they are, and so are angles with steps, or those that
        `hold` says.
        """
        lower, upper = self.stand.axes.limits_around(settings, hold)
        if self.fixed is not None:
            lower[..., : self.held, :] = upper[..., : self.held, :] = self.fixed
        shape = (*settings.shape[:-2], -1)
        return lower.reshape(shape), upper.reshape(shape)

    def random(self, rng: np.random.Generator, count: int) -> Array:
        """Random programs that are permitted, (count, n, d) in rad.

        Raises
        ------
        CompatibilityError
            Where none is found.
        """
        return self.apart(self.completed(self.stand.axes.random(rng, (count, self.n - self.held))), rng)

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
            programs[again] = self.stand.axes.random(rng, (int(again.sum()),))
        raise CompatibilityError(
            "no {n} different positions were found on stand {stand}: widen its limits, take fewer positions, or allow "
            "{replicates}",
            n=self.n,
            stand=type(self.stand).__name__,
            replicates=Option("replicates", True),
        )

    def completed(self, free: Array) -> Array:
        """Programs (s, f + k, d) of the fixed positions and then k free ones, (s, k, d)."""
        if self.fixed is None:
            return free
        return np.concatenate([np.broadcast_to(self.fixed, (len(free), *self.fixed.shape)), free], axis=1)

    @property
    def active(self) -> bool:
        """Whether some programs within the limits of the angles are not permitted."""
        return bool(self.stand.zones) or not self.replicates

    def permits(self, settings: Array, clearance: bool = False) -> np.ndarray:
        """Which programs (..., n, d) leave forbidden zones alone and repeat no position that may not be.

        The limits of single angles are not looked at: see `Axes.allows`. With a clearance, what
        is so close to a zone that rounding may put it there is not permitted either.
        """
        permitted = ~self.stand.axes.forbids(settings[..., self.held :, :], clearance).any(axis=-1)
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
        wrong = self.stand.axes.forbids(settings, clearance=True)
        wrong[:, : self.held] = False
        if wrong.any():
            settings[wrong] = self._up_to_zones(settings[wrong], allowed[wrong])
        if not self.replicates:
            near = self.alike(settings, settings)
            near[:, range(self.n), range(self.n)] = False
            settings = np.where(np.any(near, axis=-1, keepdims=True), allowed, settings)
        if self.active:
            settings = np.where(self.permits(settings, clearance=True)[:, None, None], settings, allowed)
        return settings

    def _up_to_zones(self, settings: Array, allowed: Array) -> Array:
        """The way (k, d) from allowed settings to others as far as bisection finds it free."""
        share, way, step = np.zeros(len(settings)), settings - allowed, 1.0
        # for few positions a call costs more than what it computes: several halvings' outcomes in one
        halvings = next(m for m in (6, 3, 1) if m == 1 or len(settings) << m <= _IN_ONE_CALL)
        for _ in range(0, _HALVINGS, halvings):
            step *= 0.5**halvings
            trials = share[:, None] + step * np.arange(1, 2**halvings)
            between = allowed[:, None, :] + trials[..., None] * way[:, None, :]
            free = ~self.stand.axes.forbids(between, clearance=True)
            ahead = np.zeros(len(settings), dtype=int)
            for k in reversed(range(halvings)):
                further = ahead + (1 << k)
                ahead = np.where(free[range(len(free)), further - 1], further, ahead)
            share += step * ahead
        return np.asarray(allowed + share[:, None] * way)

    def _repeated(self, settings: Array) -> np.ndarray:
        """Which positions (..., n) an earlier one of the same program replicates."""
        repeated = self.alike(settings, settings)
        return np.asarray(np.tril(repeated, -1).any(axis=-1))

    def alike(self, settings: Array, others: Array) -> np.ndarray:
        """Which positions (..., k, d) the sensor feels as it does others (..., l, d): (..., k, l).

        What of the stimulus the model does not read, it does not feel. Of a vector that is 1 everywhere, as the
        vertical, what counts is the chord; any other by its largest magnitude on the stand, and what is no vector by
        its range. Of motions the mean square difference counts.
        """
        squares = np.zeros((*settings.shape[:-1], others.shape[-2]))
        stimulus, another = self.stand.stimulus(settings), self.stand.stimulus(others)
        for name, size in self._sizes.items():
            felt, other = (_flat(each, name) for each in (stimulus, another))
            apart = ((felt[..., :, None, :] - other[..., None, :, :]) ** 2).sum(axis=-1)
            squares += apart if size == 1.0 else apart / size**2
        steps_only = all(setting.step is not None for setting in self.stand.settings)
        limit = _SAME_STOP if steps_only else _SAME_PLACE * (1.0 - 1e-9)
        return np.asarray(squares < limit**2)

    @cached_property
    def _sizes(self) -> Mapping[str, float]:
        """What differences of each quantity are held against: 1 where it is a unit vector in every position."""
        stimulus = self.stand.stimulus(
            self.stand.axes.candidates(_LOOKED_AT, "structured", np.random.default_rng(0))[:]
        )
        return {name: _size(stimulus[name], vector=name in VECTORS) for name in self.feels if name in stimulus}

    def canonical(self, settings: Array) -> Array:
        """The same program with whole turns taken off, the fixed positions first, the others sorted by their angles.

        In the order that they have where that matters.
        """
        wrapped = self.stand.axes.wrap(settings[self.held :])
        if self.ordered:
            return np.concatenate([settings[: self.held], wrapped])
        order = np.lexsort(np.round(self.stand.axes.written(wrapped), 6).T[::-1])
        return np.concatenate([settings[: self.held], wrapped[order]])


def _flat(stimulus: Stimulus, name: str) -> Array:
    """A quantity (..., n, w), its samples side by side, each with the root of its weight."""
    value = stimulus[name]
    if stimulus.weights is None:
        return value
    weighted = np.sqrt(stimulus.weights)[:, None] * value
    return weighted.reshape((*value.shape[:-2], value.shape[-2] * value.shape[-1]))


def _size(values: Array, *, vector: bool) -> float:
    """The largest magnitude of a vector (..., w), the range of another quantity; 1 where there is none."""
    if vector:
        largest = float(np.sqrt((values * values).sum(axis=-1).max()))
        return 1.0 if abs(largest - 1.0) < 1e-6 else largest or 1.0
    return float((values.max() - values.min()) or 1.0)
