"""What several sensors of the same vector say of it, held against each other and against its length."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.errors import CompatibilityError
from acalx.models.comparisons import Comparison, Residual
from acalx.models.sensed import unit_length
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus
from acalx.sensors.base import Sensor

__all__ = ["Agreement"]

# Newton's steps of each part by itself; one that is linear in what it feels needs one.
_STEPS, _SETTLED = 8, 1e-14


@final
@dataclass(frozen=True)
class Agreement(Comparison):
    """Several triads feel the same vector, whose length alone is known.

    The residuals are the length of what the first triad says less the known one, and what each other triad says less
    what the first says: 1 + 3 (k - 1) for k triads. Of the attitude nothing need be known.
    """

    def check(self, sensor: Sensor) -> None:
        """Refuse a sensor that is no set of triads of one vector."""
        if len(sensor.senses) != 1 or len(sensor.channels) % 3 or len(sensor.channels) < 6:
            raise CompatibilityError(
                f"{type(sensor).__name__} is no array: two triads or more that sense the same vector can be compared so"
            )

    def count(self, sensor: Sensor) -> int:
        """A length, and three differences for each triad after the first."""
        return len(sensor.channels) - 2

    def knows(self, sensor: Sensor) -> tuple[str, ...]:
        """What the sensor needs beside what it senses."""
        return tuple(name for name in sensor.needs if name not in sensor.senses)

    @property
    def by_length(self) -> bool:
        """The length is the same in all positions."""
        return True

    def lengths(self, sensor: Sensor) -> Mapping[str, float]:
        """That of the vector which all of them feel."""
        return {name: unit_length(sensor, name) for name in sensor.senses}

    def residual(self, sensor: Sensor, parameters: Array, readings: Array, known: Stimulus | None) -> Residual:
        """Length and differences of what the triads say, their rows and their derivatives by the readings."""
        (quantity,) = sensor.senses
        vectors, slopes, by_parameters = _each(sensor, parameters, readings, known)
        length = np.sqrt((vectors[0] ** 2).sum(axis=-1, keepdims=True))
        left = length - unit_length(sensor, quantity)
        value = np.concatenate([left, *(vector - vectors[0] for vector in vectors[1:])], axis=-1)
        with np.errstate(invalid="ignore", divide="ignore"):
            along = (vectors[0] / length)[..., None, :]
        rows, by_readings = [along @ by_parameters[0]], [along @ slopes[0]]
        for k in range(1, len(vectors)):
            rows.append(by_parameters[k] - by_parameters[0])
            by_readings.append(slopes[k] - slopes[0])
        return Residual(value, np.concatenate(rows, axis=-2), np.concatenate(by_readings, axis=-2))


def _each(
    sensor: Sensor, parameters: Array, readings: Array, known: Stimulus | None
) -> tuple[list[Array], list[Array], list[Array]]:
    """What each triad says was felt, (..., n, 3), and how much a reading, (..., n, 3, k), and a parameter add to it."""
    (quantity,), k = sensor.senses, len(sensor.channels)
    others = {} if known is None else {name: known[name] for name in sensor.needs if name != quantity}
    shape = np.broadcast_shapes(readings.shape[:-1], (*parameters.shape[:-1], 1))
    vectors, slopes, by_parameters = [], [], []
    for first in range(0, k, 3):
        own = slice(first, first + 3)
        vector = np.zeros((*shape, 3))
        for _ in range(_STEPS):
            at = Stimulus({**others, quantity: vector})
            left = readings[..., own] - sensor.readings(parameters, at)[..., own]
            step = (_inverse(sensor, parameters, at, own, shape) @ left[..., None])[..., 0]
            vector = vector + step
            if not (np.abs(step) > _SETTLED * (1.0 + np.abs(vector))).any():
                break
        at = Stimulus({**others, quantity: vector})
        by_reading = np.zeros((*shape, 3, k))
        by_reading[..., own] = _inverse(sensor, sensor.nominal, at, own, shape)
        vectors.append(vector)
        slopes.append(by_reading)
        by_own = sensor.by_parameters(parameters, at)[..., own, :]
        by_parameters.append(_inverse(sensor, parameters, at, own, shape) @ by_own)
    return vectors, slopes, by_parameters


def _inverse(sensor: Sensor, parameters: Array, at: Stimulus, own: slice, shape: tuple[int, ...]) -> Array:
    """How the vector follows from the readings of a triad, (..., n, 3, 3)."""
    slopes = sensor.by_stimulus(parameters, at)[sensor.senses[0]][..., own, :]
    try:
        return np.linalg.inv(np.broadcast_to(slopes, (*shape, 3, 3)))
    except np.linalg.LinAlgError:  # parameters that went anywhere: `converged` tells
        return np.full((*shape, 3, 3), np.nan)
