"""The noise of a sensor: fixed, or as what is felt makes it; of each position by itself, or shared by several."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus
from acalx.sensors.base import Sensor

__all__ = ["SensorNoise"]


@final
@dataclass(frozen=True, eq=False)
class SensorNoise:
    """What a sensor says of its noise, asked as models need it.

    Parameters
    ----------
    sensor : Sensor
    """

    sensor: Sensor

    @cached_property
    def fixed(self) -> Array | None:
        """Standard deviations of the readings (k,), where they don't depend on the stimulus."""
        return None if self.sensor.noise_varies else np.asarray(self.sensor.deviations(Stimulus()), dtype=float)

    @cached_property
    def independent(self) -> bool:
        """Whether the noise of a position has nothing to do with that of others."""
        return self.sensor.correlation(np.arange(2.0)) is None

    def at(self, felt: Stimulus) -> Array:
        """Standard deviations of the readings, (k,) or (..., n, k), for a stimulus in the sensor's units."""
        if self.fixed is not None:
            return self.fixed
        return np.asarray(self.sensor.deviations(felt.mean()), dtype=float)

    def of_readings(self, parameters: Array, readings: Array, known: Stimulus | None) -> Array:
        """The same where part of what is felt follows from the readings only."""
        if self.fixed is not None or (known is not None and all(name in known for name in self.sensor.needs)):
            return self.at(Stimulus() if known is None else known)
        return self.at(self.sensor.felt(parameters, readings, known))

    def correlation(self, felt: Stimulus | None) -> Array | None:
        """Correlations of the noise of positions, (..., n, n); None where they share none."""
        if self.independent:
            return None
        assert felt is not None  # models of such sensors know and need the time
        return self.sensor.correlation(felt.mean()["time"][..., 0])
