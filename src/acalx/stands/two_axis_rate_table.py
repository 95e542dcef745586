"""The two-axis rate table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import ClassVar, final

import numpy as np

from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import EARTH_RATE, Stimulus
from acalx.quantities.units import DEGREE_PER_SECOND, SECOND
from acalx.stands.base import Setting
from acalx.stands.fields import limits, number, step
from acalx.stands.motion import MOST_HALF, Samples, samples
from acalx.stands.rotary import Rotary
from acalx.stands.turns import UP, Part, Vector, differentiated, pieces, turned, vectors

__all__ = ["TwoAxisRateTable"]


@final
@dataclass(frozen=True)
class TwoAxisRateTable(Rotary):
    """A table that can turn about both of its axes while the sensor is read: the outer one level, the inner one on it.

    A position is a pair of angles and a pair of rates, zero at rest; the angles are those in the middle of a reading,
    which is a mean over `averaging_s`, of as many samples as the limits of the rates need. With C = Rz(inner) Rx(outer)
    the sensor feels, in its axes,

        a = C (0, 0, 1)  in g,   w = C w_earth + outer rate Rz(inner) (1, 0, 0) + inner rate (0, 0, 1),

    and the angular acceleration that both rates together make. The axes meet in the sensor's origin, from which
    lever arms count. In the rotating frame of the Earth only its rate is felt, not its centripetal acceleration.

    Parameters
    ----------
    outer_deg, inner_deg : pair of float, degrees
        Limits of the angles.
    outer_rate_deg_s, inner_rate_deg_s : pair of float, degrees per second
        Limits of the rates.
    outer_rate_step_deg_s, inner_rate_step_deg_s : float, degrees per second, optional
        A rate is a whole multiple of it. None: any.
    averaging_s : float, s
        How long a reading is averaged; 0: not at all.
    azimuth_deg : float, degrees
        Of the outer axis: 0 is north, 90, the default, east.
    latitude_deg : float, degrees
        North is positive.
    step_deg, periodic
        As of `Rotary`.
    forbidden, forbidden_if, speed_deg_s
        As of `Stand`.

    Raises
    ------
    ArgumentError
        Limits the wrong way round or not finite, a latitude beyond a pole, a time that is negative, or so long that
        the sensor would make more than twelve turns in it.

    Source: IEEE Std 1431-2004, rate-table tests; IEEE Std 1293-2018, multipoint tests.
    """

    turns: ClassVar[Mapping[str, str]] = {"outer": "x", "inner": "z"}
    outer_deg: Sequence[float] = limits(0.0, 360.0)
    inner_deg: Sequence[float] = limits(0.0, 360.0)
    outer_rate_deg_s: Sequence[float] = limits(-100.0, 100.0, DEGREE_PER_SECOND)
    inner_rate_deg_s: Sequence[float] = limits(-100.0, 100.0, DEGREE_PER_SECOND)
    _: KW_ONLY
    outer_rate_step_deg_s: float | None = step(DEGREE_PER_SECOND)
    inner_rate_step_deg_s: float | None = step(DEGREE_PER_SECOND)
    averaging_s: float = number(1.0, 0.0, 3600.0, SECOND)
    azimuth_deg: float = number(90.0, -360.0, 360.0)
    latitude_deg: float = number(34.25, -90.0, 90.0)

    @cached_property
    def settings(self) -> tuple[Setting, ...]:
        """The two angles, then their rates."""
        outer = self.outer_rate_deg_s, self.outer_rate_step_deg_s, False, DEGREE_PER_SECOND
        inner = self.inner_rate_deg_s, self.inner_rate_step_deg_s, False, DEGREE_PER_SECOND
        return (*self.angles, Setting.in_unit("outer_rate", *outer), Setting.in_unit("inner_rate", *inner))

    @cached_property
    def surroundings(self) -> Mapping[str, Vector]:
        """Gravity, and the Earth's rate along the outer axis, across it, and up."""
        latitude, azimuth = math.radians(self.latitude_deg), math.radians(self.azimuth_deg)
        level = math.cos(latitude)
        earth = (level * math.cos(azimuth), level * math.sin(azimuth), math.sin(latitude))
        return {"specific_force": UP, "angular_rate": earth}

    def stimulus(self, settings: Array) -> Stimulus:
        """What is felt along the motion: settings (..., n, 4) to arrays (..., n, 3), or (..., n, samples, 3)."""
        at, _, weights = self._along(settings)
        turns, shape = self.turns_at(at), at.shape[:-1]
        sin, cos = turns[1][2:]
        outer, inner, zero = at[..., 2], at[..., 3], np.zeros(shape)
        around = self.surroundings.items()
        felt = {name: vectors(turned(vector, turns), shape, pieces(3, shape)) for name, vector in around}
        felt["angular_rate"] += np.stack([outer * cos, -outer * sin, inner], axis=-1) / EARTH_RATE
        felt["angular_acceleration"] = (outer * inner)[..., None] * np.stack([-sin, -cos, zero], axis=-1)
        return Stimulus(felt, weights=weights)

    def derivative(self, settings: Array) -> Stimulus:
        """Its exact derivatives, arrays (..., n, 3, 4), or (..., n, samples, 3, 4)."""
        at, times, weights = self._along(settings)
        slopes = {}
        for name, columns in self._slopes(at).items():
            by_setting = np.stack([vectors(parts, at.shape[:-1]) for parts in columns], axis=-1)
            by_setting[..., 2:] += times[..., None] * by_setting[..., :2]  # rates move the angles along the motion
            slopes[name] = by_setting
        return Stimulus(slopes, weights=weights)

    def pull(self, settings: Array, gradient: Stimulus) -> Array:
        """From a gradient with respect to the stimulus to the settings, (..., n, 4), without its matrices."""
        at, times, weights = self._along(settings)
        total = np.zeros_like(at)
        slopes = self._slopes(at)
        for name, feels in gradient.items():
            for k, parts in enumerate(slopes.get(name, ())):
                for j, part in enumerate(parts):
                    if part is not None:
                        total[..., k] += feels[..., j] * part
        total[..., 2:] += times * total[..., :2]
        return total if weights is None else total.sum(axis=-2)

    def _slopes(self, at: Array) -> dict[str, list[Sequence[Part]]]:
        """Components of the derivatives of each quantity by the angles and the rates there."""
        turns = self.turns_at(at)
        sin, cos = turns[1][2:]
        outer, inner = at[..., 2] / EARTH_RATE, at[..., 3]
        none: Sequence[Part] = (None, None, None)
        force, rate = (differentiated(around, turns)[1] for around in self.surroundings.values())
        x, y, z = rate[1]
        by_inner = [_sum(x, -outer * sin), _sum(y, -outer * cos), z]
        both = at[..., 2] * inner
        return {
            "specific_force": [*force, none, none],
            "angular_rate": [
                rate[0],
                by_inner,
                (cos / EARTH_RATE, -sin / EARTH_RATE, None),
                (None, None, 1.0 / EARTH_RATE),
            ],
            "angular_acceleration": [
                none,
                (-both * cos, both * sin, None),
                (-inner * sin, -inner * cos, None),
                (-at[..., 2] * sin, -at[..., 2] * cos, None),
            ],
        }

    @property
    def frequencies(self) -> None:  # type: ignore[override]
        """None: along a motion what is felt is no trigonometric polynomial in the rates."""
        return

    @cached_property
    def samples(self) -> Samples:
        """Of the motion, as many as the fastest and longest that the limits allow needs."""
        fastest = 0.5 * float(np.abs(self.axes.bounds[2:]).max(axis=1).sum())
        return samples(self.averaging_s * fastest, "averaging_s", self.averaging_s, int(MOST_HALF / fastest))

    def _along(self, settings: Array) -> tuple[Array, Array, Array | None]:
        """Settings along the motion, (..., n, samples, 4), when they are, (samples, 1) in s, and their weights."""
        if self.averaging_s == 0.0:
            return settings, np.zeros(1), None
        times = 0.5 * self.averaging_s * self.samples.places
        at = pieces(4, (*settings.shape[:-1], len(times)))
        at[...] = settings[..., None, :]
        at[..., :2] += times[:, None] * settings[..., None, 2:]
        return at, times[:, None], self.samples.weights


def _sum(part: Part, more: Array) -> Array:
    return more if part is None else part + more
