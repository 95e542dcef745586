"""What the readings of a calibrated sensor say of what was felt."""

from __future__ import annotations

import numpy as np

from acalx.models.comparisons import Comparison
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus
from acalx.sensors.base import Sensor

__all__ = ["corrected_of", "felt_of"]


def felt_of(
    sensor: Sensor, comparison: Comparison, parameters: Array, readings: Array, others: Stimulus | None
) -> Stimulus:
    """What was felt of the quantities that a sensor senses; where their length is known, of that length.

    Parameters
    ----------
    sensor : Sensor
    comparison : Comparison
        Says whether lengths are known.
    parameters : array (..., p)
    readings : array (..., n, k)
    others : arrays (..., n, width), optional
        What else the readings depend on, in the sensor's units.
    """
    felt, units = sensor.felt(parameters, readings, others), dict(sensor.needs)
    known = comparison.lengths(sensor).items()
    sized = {name: felt[name] * (length / np.linalg.norm(felt[name], axis=-1, keepdims=True)) for name, length in known}
    return Stimulus({**felt, **sized}, units=units)


def corrected_of(sensor: Sensor, parameters: Array, readings: Array, known: Stimulus | None) -> Array:
    """Readings (..., n, k) as a sensor without errors would have given them.

    By what was felt where that follows from them, otherwise by what is known of it.
    """
    nominal = sensor.nominal
    if sensor.senses:
        return sensor.readings(nominal, sensor.felt(parameters, readings, known))
    assert known is not None  # the model says what it takes
    return readings - sensor.readings(parameters, known) + sensor.readings(nominal, known)
