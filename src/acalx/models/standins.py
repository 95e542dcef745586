"""Sensors that stand in for others: read along a motion, or without errors."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np

from acalx.numerics.arrays import Array
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus
from acalx.sensors.base import Channel, Sensor

__all__ = ["Faultless", "averaged"]


class _StandIn(Sensor):
    """Another sensor, but for what a stand-in says itself."""

    def __init__(self, sensor: Sensor, felt: Stimulus) -> None:
        self.sensor, self.samples = sensor, felt

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The same as of the sensor itself."""
        return self.sensor.parameters

    @property
    def channels(self) -> tuple[Channel, ...]:
        """The same as of the sensor itself."""
        return self.sensor.channels

    @property
    def needs(self) -> Mapping[str, str]:
        """What the sensor needs."""
        return self.sensor.needs

    @property
    def senses(self) -> tuple[str, ...]:
        """What the sensor senses."""
        return self.sensor.senses

    @property
    def vectors(self) -> tuple[str, ...]:
        """The same as of the sensor itself."""
        return self.sensor.vectors

    def deviations(self, stimulus: Stimulus) -> Array:
        """The same as of the sensor itself."""
        return self.sensor.deviations(stimulus)

    @property
    def noise_varies(self) -> bool:
        """The same as of the sensor itself."""
        return self.sensor.noise_varies


class Averaged(_StandIn):
    """A sensor whose readings are means over the samples of a known stimulus in each position."""

    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        """Means of its readings over the samples, whatever `stimulus` says."""
        return self._mean(self.sensor.readings(parameters, self.samples.without_samples()), 1)

    def by_parameters(self, parameters: Array, stimulus: Stimulus) -> Array:
        """Means of their derivatives."""
        return self._mean(self.sensor.by_parameters(parameters, self.samples.without_samples()), 2)

    def _mean(self, values: Array, behind: int) -> Array:
        weights = self.samples.weights
        assert weights is not None
        own = values.shape[values.ndim - behind :]
        each = values.reshape((*values.shape[: -1 - behind], -1, len(weights), *own))
        return np.asarray(np.tensordot(each, weights, axes=([each.ndim - behind - 1], [0])))


def averaged(sensor: Sensor, felt: Stimulus | None) -> Sensor:
    """The sensor, or one that reads means where what was felt has samples."""
    return sensor if felt is None or felt.weights is None else Averaged(sensor, felt)


class Faultless(_StandIn):
    """A sensor without errors in positions whose stimulus is known: what it felt is just that.

    Several comparisons ask it for the same derivatives; it works them out once.
    """

    def felt(self, parameters: Array, readings: Array, known: Stimulus | None = None) -> Stimulus:
        """The stimulus, which is known here."""
        return self.samples

    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        """The same as of the sensor itself."""
        return self.sensor.readings(parameters, stimulus)

    def by_parameters(self, parameters: Array, stimulus: Stimulus) -> Array:
        """The same as of the sensor itself."""
        if self._here(parameters, stimulus):
            return self._by_parameters
        return self.sensor.by_parameters(parameters, stimulus)

    def by_stimulus(self, parameters: Array, stimulus: Stimulus) -> dict[str, Array]:
        """The same as of the sensor itself."""
        if self._here(parameters, stimulus):
            return self._by_stimulus
        return self.sensor.by_stimulus(parameters, stimulus)

    def _here(self, parameters: Array, stimulus: Stimulus) -> bool:
        return stimulus is self.samples and np.array_equal(parameters, self.nominal)

    @cached_property
    def nominal(self) -> Array:
        """The parameters of a sensor without errors, (p,)."""
        return self.sensor.nominal

    @cached_property
    def _by_parameters(self) -> Array:
        return self.sensor.by_parameters(self.nominal, self.samples)

    @cached_property
    def _by_stimulus(self) -> dict[str, Array]:
        return self.sensor.by_stimulus(self.nominal, self.samples)
