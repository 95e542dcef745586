"""Comparisons whose rows are polynomials in the stimulus, as tables."""

from __future__ import annotations

import numpy as np

from acalx.models.comparisons import Comparison, Outputs
from acalx.models.table import Entry, Table
from acalx.models.vectors import Magnitude, Projection, of_sensor
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import UNITS_OF
from acalx.sensors.base import Sensor
from acalx.sensors.polynomial import Polynomial

__all__ = ["table_of"]


def table_of(sensor: Sensor, comparison: Comparison, noise: Array) -> Table | None:
    """The whitened rows of a comparison for a sensor without errors; None where they are no polynomials.

    Parameters
    ----------
    sensor : Sensor
    comparison : Comparison
    noise : array (k,)
        Standard deviations of the readings.
    """
    if not isinstance(sensor, Polynomial) or sensor.nominal.any():
        return None
    entries = _entries(sensor, comparison, noise)
    return None if entries is None else Table(comparison.count(sensor), len(sensor.parameters), tuple(entries))


def _entries(sensor: Polynomial, comparison: Comparison, noise: Array) -> list[Entry] | None:
    if isinstance(comparison, Outputs):
        return [
            (channel, number, factor / noise[channel], product) for channel, number, factor, product in sensor.table
        ]
    if isinstance(comparison, Magnitude | Projection):
        return _along(sensor, comparison, noise)
    return None


def _along(sensor: Polynomial, comparison: Magnitude | Projection, noise: Array) -> list[Entry] | None:
    """u' G for a vector u of length one that the channels read, component by component, with the same noise."""
    quantity = of_sensor(sensor, comparison.quantity)
    ideal = {channel: (factor, product) for channel, factor, product in sensor.ideal}
    factor = sensor.ideal[0][1] if sensor.ideal else 0.0
    plain = ideal == {k: (factor, ((quantity, k),)) for k in range(3)} and len(sensor.ideal) == 3
    of_length_one = sensor.needs.get(quantity) == UNITS_OF.get(quantity) and quantity != "angular_rate"
    varies = isinstance(comparison, Magnitude) and comparison.varies
    if not plain or varies or not of_length_one or np.ptp(noise) > 0.0:
        return None
    return [
        (0, number, each / noise[0], ((quantity, channel), *product)) for channel, number, each, product in sensor.table
    ]
