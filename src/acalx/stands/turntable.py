"""A turntable that is turned by known angles."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import ClassVar, final

import numpy as np

from acalx.numerics.arrays import Array
from acalx.options import require_steps
from acalx.quantities.stimulus import EARTH_RATE, Stimulus
from acalx.quantities.units import SECOND
from acalx.stands.base import Setting
from acalx.stands.fields import limits, number
from acalx.stands.motion import MOST_HALF, Samples, samples
from acalx.stands.rotary import Rotary
from acalx.stands.turns import UP, Vector

__all__ = ["Turntable"]


@final
@dataclass(frozen=True)
class Turntable(Rotary):
    """A level turntable with a two-axis fixture on it, turned by a known angle, by hand or by a motor.

    A position is an attitude of the sensor and a turn about the vertical, from north, that begins and ends at rest; the
    reading is a mean over it, the angle that a gyro adds up over its time. However fast the turn goes meanwhile,

        a = e  in g,   w = turn / turn_s e + the mean of the Earth's rate,   e = (sin a1, cos a1 sin a2, cos a1 cos a2).

    Parameters
    ----------
    turn_deg : pair of float, degrees
        Limits of the angle of a turn, counterclockwise seen from above; up to twelve turns are allowed.
    alpha1_deg, alpha2_deg : pair of float, degrees
        Limits of the angles of the fixture.
    turn_s : float, s
        How long each turn is read for.
    latitude_deg : float, degrees
        North is positive.
    step_deg, periodic
        Of all three angles, as of `Rotary`; turns are never periodic.
    forbidden, forbidden_if, speed_deg_s
        As of `Stand`.

    Raises
    ------
    ArgumentError
        Limits the wrong way round or not finite, a latitude beyond a pole, a time that is not positive,
        more than twelve turns.

    Source: Tedaldi, Pretto, Menegatti, ICRA 2014, for gyros calibrated by turns between rests.
    """

    turns: ClassVar[Mapping[str, str]] = {"turn": "z", "alpha1": "-y", "alpha2": "x"}
    turn_deg: Sequence[float] = limits(-360.0, 360.0)
    alpha1_deg: Sequence[float] = limits(0.0, 360.0)
    alpha2_deg: Sequence[float] = limits(0.0, 360.0)
    _: KW_ONLY
    turn_s: float = number(5.0, 1e-3, 3600.0, SECOND)
    latitude_deg: float = number(34.25, -90.0, 90.0)

    @cached_property
    def settings(self) -> tuple[Setting, ...]:
        """The turn, then the two angles of the fixture."""
        steps = require_steps("step_deg", self.step_deg, len(self.turns))
        given = zip(self.turns, steps, (False, self.periodic, self.periodic), strict=True)
        return tuple(Setting.in_unit(name, getattr(self, f"{name}_deg"), size, around) for name, size, around in given)

    @cached_property
    def surroundings(self) -> Mapping[str, Vector]:
        """Gravity, and the Earth's rate north and up."""
        latitude = math.radians(self.latitude_deg)
        return {"specific_force": UP, "angular_rate": (math.cos(latitude), None, math.sin(latitude))}

    @cached_property
    def samples(self) -> Samples:
        """Of a turn, as many as the longest that the limits allow needs."""
        lower, upper = self.turn_deg
        most = math.floor(math.degrees(2.0 * MOST_HALF))
        half = math.radians(0.5 * max(abs(lower), abs(upper)))
        return samples(half, "turn_deg", [lower, upper], [max(lower, -most), min(upper, most)])

    def stimulus(self, settings: Array) -> Stimulus:
        """What is felt along the turn, settings (..., n, 3) in rad to arrays (..., n, samples, 3)."""
        at = np.repeat(settings[..., None, :], len(self.samples), axis=-2)
        at[..., 0] *= 0.5 * (1.0 + self.samples.places)
        felt = dict(super().stimulus(at))
        rate = settings[..., 0] / (self.turn_s * EARTH_RATE)
        felt["angular_rate"] = felt["angular_rate"] + rate[..., None, None] * felt["specific_force"]
        return Stimulus(felt, weights=self.samples.weights)

    def starts(self, settings: Array) -> Array:
        """Where each turn begins: north."""
        return np.concatenate([np.zeros_like(settings[..., :1]), settings[..., 1:]], axis=-1)
