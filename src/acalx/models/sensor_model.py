"""What follows from a sensor and what of its readings is compared: all that design, simulation and estimation read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from acalx.models.base import Model, Noises, noises_of
from acalx.models.blocks import Blocks, in_blocks, touched
from acalx.models.checks import check_compared
from acalx.models.comparisons import Comparison
from acalx.models.corrected import corrected_of, felt_of
from acalx.models.jacobian import InBlocks, Jacobian
from acalx.models.noise import SensorNoise
from acalx.models.numerical import by_samples, coupled_pull, numerical_derivative
from acalx.models.prior import prior_information
from acalx.models.standins import averaged
from acalx.models.start import generic_least, of_spheres, sphere_start
from acalx.models.table import Table
from acalx.models.whitening import correlated, flat, over_shared, passed_on, whitened
from acalx.numerics.arrays import Array
from acalx.options import keep
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import AT_REST, Stimulus
from acalx.sensors.base import Channel, Sensor

__all__ = ["SensorModel"]


@dataclass(frozen=True)
class SensorModel(Model):
    """A model of a sensor; `Compared` takes it and the comparison as options, others make them of options of their own.

    Parameters
    ----------
    prior : mapping of str to float, optional
        Standard deviations of parameters, or of all of a group, before anything is measured, by name, in
        their unit: information that is there already.
    """

    sensor: Sensor = field(init=False, repr=False, compare=False)
    comparison: Comparison = field(init=False, repr=False, compare=False)
    _: KW_ONLY
    prior: Mapping[str, float] | None = None

    def _compare(self, sensor: Sensor, comparison: Comparison) -> None:
        """What a model without these as options has in their place; looks at the prior too."""
        object.__setattr__(self, "sensor", sensor)
        object.__setattr__(self, "comparison", comparison)
        comparison.check(sensor)
        _ = self.prior_information  # looked at once here so that a bad one is refused at construction
        keep(self, "prior")

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Those of the sensor."""
        return self.sensor.parameters

    @property
    def needs(self) -> Mapping[str, str]:
        """What the sensor needs, each quantity with its unit; with noise that positions share the time too."""
        return self.sensor.needs if self._noise.independent else {**self.sensor.needs, "time": "s"}

    @cached_property
    def _noise(self) -> SensorNoise:
        return SensorNoise(self.sensor)

    @property
    def coupled(self) -> bool:
        """Where the sensor says correlations."""
        return not self._noise.independent

    @cached_property
    def outputs(self) -> int:
        """What the comparison counts in a position."""
        return self.comparison.count(self.sensor)

    @property
    def kind(self) -> str:
        """That of the sensor."""
        return self.sensor.kind

    @property
    def degree(self) -> int | None:
        """Degree of the rows in the stimulus, where they are polynomials."""
        return None if self._table is None else self._table.degree

    @cached_property
    def smallest_n(self) -> int:
        """The fewest positions that determine all the parameters, whatever is felt in them."""
        least = super().smallest_n
        return (
            generic_least(self, least) if self._table is None else max(least, self._table.least(self.prior_information))
        )

    @property
    def entries(self) -> int:
        """Entries of a position's rows in the blocks that the information has."""
        return sum(len(outputs) * len(numbers) for outputs, numbers in self._blocks)

    def check(self, stimulus: Stimulus, stand: Any) -> None:
        """Raise CompatibilityError where the stand lacks what the sensor needs, or can't have it compared."""
        super().check(stimulus, stand)
        check_compared(self.sensor, self.comparison, stimulus, type(stand).__name__)

    def regressors(self, stimulus: Stimulus) -> Array:
        """Rows of the comparison for a sensor without errors, over the noise, (..., n, m, p); means over samples."""
        felt = self.in_units(stimulus)
        if self._table is not None:
            return over_shared(self._noise.correlation(felt), self._table.rows(felt))
        at = self.comparison.rows(self.sensor, felt.mean())
        rows = at.rows
        if felt.weights is not None:  # the mean of products, not the product of means
            slopes = self.sensor.by_parameters(self.nominal, felt.without_samples())
            each = slopes.reshape((*slopes.shape[:-3], -1, len(felt.weights), *slopes.shape[-2:]))
            rows = np.einsum("k,...kjp->...jp", felt.weights, each)
            rows = rows if at.by_readings is None else at.by_readings @ rows
        return whitened(self._noise.at(felt), at.value, rows, at.by_readings, self._noise.correlation(felt))[1]

    def derivative(self, stimulus: Stimulus) -> Stimulus:
        """Derivatives of the rows: exact where they are polynomials."""
        if self._table is not None:
            return stimulus.from_units(self._table.derivative(self.in_units(stimulus)), self.needs)
        if stimulus.weights is None or not self.comparison.of_readings or self._noise.fixed is None or self.coupled:
            return super().derivative(stimulus)
        # rows are means of those in the samples
        each = numerical_derivative(self.regressors, stimulus.without_samples(), self.needs)
        return by_samples(each, stimulus)

    def pull(self, stimulus: Stimulus, rows: Array) -> Stimulus:
        """From a gradient with respect to the rows, (..., n, m, p), to the stimulus."""
        felt = self.in_units(stimulus)
        if self._table is not None:
            rows = over_shared(self._noise.correlation(felt), rows, back=True)
            return stimulus.from_units(self._table.pull(felt, rows), self.needs)
        if self._noise.independent:
            return super().pull(stimulus, rows)
        return coupled_pull(self.regressors, stimulus, self.sensor.needs, rows)

    def jacobian(self, stimulus: Stimulus) -> Jacobian:
        """In blocks where outputs share no parameters, nor their noise with other positions."""
        if self._table is None or len(self._blocks) == 1 or self.coupled:
            return super().jacobian(stimulus)
        return InBlocks(self, stimulus, self._table, self.in_units(stimulus), self.needs)

    def information_of(self, regressors: Array) -> Information:
        """Information of programs whose rows are there already: block by block where outputs share no parameters."""
        if len(self._blocks) == 1:
            return super().information_of(regressors)
        rows = [regressors[..., outputs[:, None], numbers] for outputs, numbers in self._blocks]
        return self.with_prior(in_blocks(self._blocks, rows, self.parameters))

    @cached_property
    def prior_information(self) -> Array:
        """1 / sd^2 of what is known of each parameter before, (p,)."""
        return prior_information(self.prior or {}, self.parameters)

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Those of the sensor."""
        return self.sensor.channels

    @property
    def knows(self) -> tuple[str, ...]:
        """What the comparison must know of each position."""
        known = self.comparison.knows(self.sensor)
        return known if self._noise.independent else (*known, "time")

    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        """What the sensor reads, means over the samples in each position."""
        felt = self.in_units(stimulus)
        if felt.weights is None:
            return self.sensor.readings(parameters, felt)
        each = self.sensor.readings(parameters, felt.without_samples())
        each = each.reshape((*each.shape[:-2], -1, len(felt.weights), each.shape[-1]))
        return np.asarray(np.einsum("k,...kj->...j", felt.weights, each))

    def deviations(self, stimulus: Stimulus) -> Array:
        """Those of the sensor."""
        return self._noise.at(self.in_units(stimulus))

    def shared_noise(self, noise: Array, stimulus: Stimulus) -> Array:
        """The noise of positions with the correlations that the sensor says."""
        return correlated(self._noise.correlation(stimulus), noise)

    def residual(self, parameters: Array, readings: Array, known: Stimulus | None) -> tuple[Array, Array]:
        """What parameters leave of the comparison, over its noise."""
        felt = None if known is None else self.in_units(known)
        found = self.comparison.residual(
            averaged(self.sensor, felt), parameters, readings, None if felt is None else felt.mean()
        )
        sigma = self._noise.of_readings(parameters, readings, felt)
        return flat(*whitened(sigma, found.value, found.rows, found.by_readings, self._noise.correlation(felt)))

    def linearized(self, parameters: Array, readings: Array, known: Stimulus | None) -> tuple[Array, Array]:
        """The same to first order: rows of a sensor without errors, where the attitude is known those of that."""
        residual, rows = self.residual(self.nominal, readings, known)
        if known is not None and all(name in known for name in self.needs):
            of_known = self.regressors(known)
            *stack, n, m, p = of_known.shape
            rows = of_known.reshape((*stack, n * m, p))
        off = parameters - self.nominal
        return residual - (off @ rows.T if rows.ndim == 2 else np.einsum("...np,...p->...n", rows, off)), rows

    def start(self, readings: Array, known: Stimulus | None) -> Array:
        """The parameters of a sensor without errors, or where only a length is known those of a sphere's fit."""
        if not self.comparison.at_once or not of_spheres(self.sensor, self.lengths):
            return super().start(readings, known)
        return sphere_start(self.sensor, readings, None if known is None else self.in_units(known).mean(), self.lengths)

    def felt(self, parameters: Array, readings: Array, known: Stimulus | None) -> Stimulus | None:
        """What is known of it, or where it follows from the readings that, with the length that it has."""
        there = super().felt(parameters, readings, known)
        if there is not None or not self.sensor.senses:
            return there
        others = None if known is None else self.in_units(known).mean()
        if not set(self.corrects_with) <= set(() if others is None else others):
            return None
        return felt_of(self.sensor, self.comparison, parameters, readings, others)

    def corrected(self, parameters: Array, readings: Array, known: Stimulus | None) -> Array:
        """Readings as a sensor without errors would have given them; along a motion that is known by what that does."""
        if known is not None and known.weights is not None and set(self.needs) <= set(known):
            return readings - self.readings(parameters, known) + self.readings(self.nominal, known)
        return corrected_of(self.sensor, parameters, readings, None if known is None else self.in_units(known).mean())

    @property
    def by_length(self) -> bool:
        """Where the comparison is of a length, and the sensor a triad."""
        return self.comparison.by_length and len(self.channels) == 3

    def compares(self, comparison: Comparison) -> bool:
        """Whether that is its comparison."""
        return comparison == self.comparison

    def residual_deviations(self, parameters: Array, readings: Array, known: Stimulus | None, own: Array) -> Array:
        """Those of readings with standard deviations of their own, (n, k), as the comparison passes them on."""
        felt = None if known is None else self.in_units(known).mean()
        by_readings = self.comparison.residual(self.sensor, parameters, readings, felt).by_readings
        sigma = self._noise.of_readings(parameters, readings, felt)
        return passed_on(own, sigma, by_readings, shared=self.coupled)

    @property
    def shows(self) -> np.ndarray:
        """Those of the blocks of its table."""
        return touched(self._blocks, self.outputs, len(self.parameters))

    @cached_property
    def noises(self) -> Noises:
        """One for each unit of the channels where their readings themselves are compared; one in all otherwise."""
        if not self.comparison.of_readings:
            return super().noises
        units = list(dict.fromkeys(channel.unit for channel in self.channels))
        of_outputs = np.array([units.index(channel.unit) for channel in self.channels])
        return noises_of(of_outputs, self.shows)

    @property
    def widths(self) -> Mapping[str, int]:
        """Those of its sensor."""
        return {name: self.sensor.width(name) for name in self.needs}

    @property
    def lengths(self) -> Mapping[str, float]:
        """Those that its comparison knows."""
        return self.comparison.lengths(self.sensor)

    @property
    def corrects_with(self) -> tuple[str, ...]:
        """What the sensor needs and does not sense itself."""
        return tuple(name for name in self.needs if name not in (*self.sensor.senses, *AT_REST))

    @cached_property
    def _table(self) -> Table | None:
        """The rows as polynomials in the stimulus, where they are that."""
        # others than readings are whitened by what is felt elsewhere, and depend on the parameters
        of_readings = self.comparison.of_readings or (self._noise.independent and not self.nominal.any())
        if self._noise.fixed is None or not of_readings:
            return None
        entries = self.comparison.entries(self.sensor, self._noise.fixed)
        return None if entries is None else Table(self.outputs, len(self.parameters), tuple(entries))

    @cached_property
    def _blocks(self) -> Blocks:
        whole = ((np.arange(self.outputs), np.arange(len(self.parameters))),)
        return whole if self._table is None else self._table.blocks

    def in_units(self, stimulus: Stimulus) -> Stimulus:
        """The stimulus in the units that the sensor takes."""
        return stimulus.in_units(self.needs)
