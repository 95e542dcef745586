"""Stands that turn while the sensor is read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import EARTH_RATE, Stimulus
from acalx.quantities.units import DEGREE_PER_SECOND, SECOND
from acalx.stands.base import Setting
from acalx.stands.fields import number
from acalx.stands.motion import MOST_HALF, Samples, samples
from acalx.stands.rotary import Rotary
from acalx.stands.turns import (
    AXES,
    Part,
    Turn,
    added,
    differentiated,
    pieces,
    slope,
    turned,
    vectors,
)

__all__ = ["Turning"]

_NONE: Sequence[Part] = (None, None, None)


@dataclass(frozen=True, eq=False)
class Turning(Rotary):
    """A stand that can turn about all of its axes at once while the sensor is read, each at a rate of its own.

    Settings are the angles in the middle of a reading and the rates, zero at rest. A reading is a mean over
    `averaging_s`, of as many samples as the limits of the rates need. Beside its surroundings the sensor feels the rate
    r_1 e_1 + r_2 e_2 + ... about the axes e_k, each as the turns behind it have it, and the angular acceleration that
    comes of their turning. The axes meet in the sensor's origin, from which lever arms count. In the rotating
    frame of the Earth only its rate is felt, not its centripetal acceleration.

    A new stand gives what a `Rotary` gives, and fields for the limits and the steps of the rate about each axis,
    ``outer_rate_deg_s`` and ``outer_rate_step_deg_s`` for ``outer``.

    Parameters
    ----------
    averaging_s : float, s
        How long a reading is averaged; 0: not at all.

    Raises
    ------
    ArgumentError
        Limits the wrong way round or not finite, a time that is negative, or so long that the sensor would make more
        than twelve turns in it.
    """

    _: KW_ONLY
    averaging_s: float = number(1.0, 0.0, 3600.0, SECOND)

    @cached_property
    def settings(self) -> tuple[Setting, ...]:
        """The angles, then their rates."""
        rates = [
            (name, *(getattr(self, f"{name}_rate_{end}") for end in ("deg_s", "step_deg_s"))) for name in self.turns
        ]
        return (
            *self.angles,
            *(Setting.in_unit(f"{name}_rate", most, step, False, DEGREE_PER_SECOND) for name, most, step in rates),
        )

    @cached_property
    def samples(self) -> Samples:
        """Of the motion, as many as the fastest and longest that the limits allow needs."""
        fastest = 0.5 * float(np.abs(self.axes.bounds[len(self.turns) :]).max(axis=1).sum())
        return samples(self.averaging_s * fastest, "averaging_s", self.averaging_s, int(MOST_HALF / fastest))

    def stimulus(self, settings: Array) -> Stimulus:
        """What is felt along the motion: settings (..., n, d) to arrays (..., n, 3), or (..., n, samples, 3)."""
        at, _, weights = self._along(settings)
        turns, rates, shape = self.turns_at(at), self._rates(at), at.shape[:-1]
        felt = {name: turned(vector, turns) for name, vector in self.surroundings.items()}
        for k, axis in enumerate(self._axes):
            rate = rates[k] / EARTH_RATE
            felt["angular_rate"] = added(felt.get("angular_rate", _NONE), turned(axis, turns[k + 1 :]), rate)
        felt["angular_acceleration"] = list(_NONE)
        for k, j, both in self._pairs(rates):
            felt["angular_acceleration"] = added(felt["angular_acceleration"], self._slope(turns, k, j), both)
        arrays = {name: vectors(parts, shape, pieces(3, shape)) for name, parts in felt.items()}
        return Stimulus(arrays, weights=weights)

    def derivative(self, settings: Array) -> Stimulus:
        """Its exact derivatives, arrays (..., n, 3, d), or (..., n, samples, 3, d)."""
        at, times, weights = self._along(settings)
        count, slopes = len(self.turns), {}
        for name, columns in self._slopes(at).items():
            by_setting = np.stack([vectors(parts, at.shape[:-1]) for parts in columns], axis=-1)
            by_setting[..., count:] += times[..., None] * by_setting[..., :count]  # rates move the angles meanwhile
            slopes[name] = by_setting
        return Stimulus(slopes, weights=weights)

    def pull(self, settings: Array, gradient: Stimulus) -> Array:
        """From a gradient with respect to the stimulus to the settings, (..., n, d), without its matrices."""
        at, times, weights = self._along(settings)
        count, total, slopes = len(self.turns), np.zeros_like(at), self._slopes(at)
        for name, feels in gradient.items():
            for k, parts in enumerate(slopes.get(name, ())):
                for j, part in enumerate(parts):
                    if part is not None:
                        total[..., k] += feels[..., j] * part
        total[..., count:] += times * total[..., :count]
        return total if weights is None else total.sum(axis=-2)

    def starts(self, settings: Array) -> Array:
        """Settings at the beginning of each reading."""
        return self._moved(settings, -0.5 * self.averaging_s)

    def ends(self, settings: Array) -> Array:
        """The same at its end."""
        return self._moved(settings, 0.5 * self.averaging_s)

    def _moved(self, settings: Array, seconds: float) -> Array:
        angles, rates = np.split(settings, 2, axis=-1)
        return np.concatenate([angles + seconds * rates, rates], axis=-1)

    @cached_property
    def _axes(self) -> list[Sequence[Part]]:
        return [AXES[axis] for axis in self.turns.values()]

    def _rates(self, at: Array) -> list[Array]:
        return [at[..., len(self.turns) + k] for k in range(len(self.turns))]

    def _pairs(self, rates: list[Array]) -> list[tuple[int, int, Array]]:
        """Of any two axes the outer one, the inner one that turns it, and the product of their rates."""
        return [(k, j, rates[k] * rates[j]) for k, j in combinations(range(len(rates)), 2)]

    def _slope(self, turns: list[Turn], axis: int, *angles: int) -> list[Part]:
        """The derivative of an axis, as the sensor sees it, by angles of axes behind it."""
        return slope(self._axes[axis], turns[axis + 1 :], [angle - axis - 1 for angle in angles])

    def _slopes(self, at: Array) -> Mapping[str, list[Sequence[Part]]]:
        """Components of the derivatives of each quantity by the angles and then the rates there."""
        turns, rates = self.turns_at(at), self._rates(at)
        count = len(turns)
        found: dict[str, list[Sequence[Part]]] = {
            name: [*differentiated(vector, turns)[1], *[_NONE] * count] for name, vector in self.surroundings.items()
        }
        by_rate = found.setdefault("angular_rate", [_NONE] * (2 * count))
        by_change = [_NONE] * (2 * count)
        for k, axis in enumerate(self._axes):
            by_rate[count + k] = added(_NONE, turned(axis, turns[k + 1 :]), 1.0 / EARTH_RATE)
        for k, j, both in self._pairs(rates):
            moved = self._slope(turns, k, j)
            by_rate[j] = added(by_rate[j], moved, rates[k] / EARTH_RATE)
            by_change[count + k] = added(by_change[count + k], moved, rates[j])
            by_change[count + j] = added(by_change[count + j], moved, rates[k])
            for i in range(k + 1, count):
                by_change[i] = added(by_change[i], self._slope(turns, k, j, i), both)
        return {**found, "angular_acceleration": by_change}

    def _along(self, settings: Array) -> tuple[Array, Array, Array | None]:
        """Settings along the motion, (..., n, samples, d), when they are, (samples, 1) in s, and their weights."""
        if self.averaging_s == 0.0:
            return settings, np.zeros(1), None
        count, times = len(self.turns), 0.5 * self.averaging_s * self.samples.places
        at = pieces(2 * count, (*settings.shape[:-1], len(times)))
        at[...] = settings[..., None, :]
        at[..., :count] += times[:, None] * settings[..., None, count:]
        return at, times[:, None], self.samples.weights
