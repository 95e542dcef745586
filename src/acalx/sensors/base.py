"""The interface of a sensor: what it reads, given its error parameters and what it feels."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, final

import numpy as np

from acalx.errors import ArgumentError
from acalx.numerics.arrays import Array
from acalx.numerics.differences import STEP, differences, differences_at, settled, steps_at
from acalx.options import is_number
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import AT_REST, VECTORS, Stimulus

__all__ = ["Channel", "Factors", "Sensor", "suits"]

# Quantities with the component of each that a product has.
Factors = tuple[tuple[str, int], ...]

# Steps of Newton's method to what was felt; a sensor that is linear in it needs one.
_MOST_STEPS = 50
_SETTLED = 1e-13


def suits(**options: Any) -> Mapping[str, Any]:
    """What suits a sensor or a model where a user does not say: options of groups by their names, and `n`.

    D does not depend on units; errors are what the sensor itself says of its noise and of its make. None: not said.
    """
    given = {"criterion": "d", "errors": "usual", **options}
    return MappingProxyType({option: choice for option, choice in given.items() if choice is not None})


@final
@dataclass(frozen=True)
class Channel:
    """One of the numbers that a sensor gives in each position.

    Parameters
    ----------
    name : str
        Of its column in files, e.g. ``ax``.
    unit : str
        Of its readings, e.g. ``g``.
    noise : float
        Standard deviation of a reading in that unit; of a mean of many samples, that of the mean.

    Raises
    ------
    ArgumentError
        A noise that is not positive.
    """

    name: str
    unit: str
    noise: float = 1.0

    def __post_init__(self) -> None:
        if not is_number(self.noise) or not 0.0 < self.noise < np.inf:
            raise ArgumentError.of("noise", self.noise, "a standard deviation is a positive number")


class Sensor(ABC):
    """A sensor with p error parameters and k channels, one file.

    A new sensor gives `parameters`, `channels`, `needs` and `readings`; derivatives are numerical, good to
    ten digits and more, until they are given exactly. One that is a sum of products, as most are, is
    a `Polynomial` and gives a table instead. Concrete sensors are frozen dataclasses.
    """

    # What suits the sensor where a user does not say: options by their groups (`stand`, `criterion`), and `n`.
    usual: ClassVar[Mapping[str, Any]] = suits()

    @property
    @abstractmethod
    def parameters(self) -> tuple[Parameter, ...]:
        """The p error parameters; at their nominal values the sensor reads as it should."""

    @property
    @abstractmethod
    def channels(self) -> tuple[Channel, ...]:
        """The k channels, in the order of the readings."""

    @property
    @abstractmethod
    def needs(self) -> Mapping[str, str]:
        """The quantities of the stimulus that the readings depend on, each with the unit in which they take it."""

    @abstractmethod
    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        """What the sensor reads, without noise, each channel in its unit.

        Parameters
        ----------
        parameters : array (..., p)
        stimulus : arrays (..., n, width)
            In the units of `needs`. Leading axes broadcast against those of the parameters.

        Returns
        -------
        array (..., n, k)
        """

    @property
    def senses(self) -> tuple[str, ...]:
        """The quantities that follow from the readings once the errors are known; none by default.

        With no more components than there are channels. Magnitudes and angles are compared of
        them, and readings are corrected to them.
        """
        return ()

    @property
    def vectors(self) -> tuple[str, ...]:
        """Quantities of its own that are vectors of three components; others that acalx does not name are numbers."""
        return ()

    def width(self, quantity: str) -> int:
        """How many components a quantity has: three of a vector, one of others."""
        return 3 if quantity in VECTORS or quantity in self.vectors else 1

    @property
    def kind(self) -> str:
        """What sensors like it are called; those of a kind are designed for together."""
        return type(self).__name__

    @property
    def parts(self) -> Mapping[str, Sequence[int]]:
        """Channels by the kind of sensor that they are of, where there are several in one; by default one of all."""
        return {self.kind: range(len(self.channels))}

    def deviations(self, stimulus: Stimulus) -> Array:
        """Standard deviations of the readings, (k,), or (..., n, k) where they depend on what is felt.

        The default is the noise of each channel. A noise that falls with the time in a position
        takes that from ``stimulus["dwell"]``, (..., n, 1) in s, which is among `needs` then.
        """
        return np.array([channel.noise for channel in self.channels])

    @property
    def noise_varies(self) -> bool:
        """Whether `deviations` depend on what is felt; where a sensor gives its own it is asked in every position."""
        return type(self).deviations is not Sensor.deviations

    def correlation(self, times: Array) -> Array | None:
        """Correlations (..., n, n) of the noise between positions at times (..., n) in s; None, the default: none.

        As of a drift that readings share; the same for all channels. The order of the positions then matters.
        """
        return None

    # ---- what follows, and may be given exactly

    @property
    def table(self) -> Sequence[tuple[int, int, float, Factors]] | None:
        """Channel, parameter, constant and product of each term, of a sensor that is nothing else; None, the default.

        Rows that are sums of products are evaluated all at once, and proofs know their degree.
        """
        return None

    @property
    def ideal(self) -> Sequence[tuple[int, float, Factors]]:
        """Channel, constant and product of what a sensor without errors reads, of one that has a table."""
        return ()

    def part(self, numbers: Sequence[int], name: str) -> Sensor | None:
        """Some of its channels by themselves, as a sensor of that kind; None, the default, where there is no such."""
        return None

    @property
    def nominal(self) -> Array:
        """The parameters of a sensor without errors, (p,)."""
        return np.array([parameter.nominal for parameter in self.parameters])

    def by_parameters(self, parameters: Array, stimulus: Stimulus) -> Array:
        """Derivatives of the readings by the parameters, (..., n, k, p); numerical by default."""
        sizes = [max(abs(one.nominal), min(1.0, 100.0 * (one.scatter or 1.0))) for one in self.parameters]
        few = stimulus.made({name: stimulus[name][..., :2, :] for name in self.needs})
        steps = settled(lambda shift: self.readings(self.nominal + shift, few), STEP * np.array(sizes))
        return differences(lambda shift: self.readings(parameters + shift, stimulus), steps)

    def by_stimulus(self, parameters: Array, stimulus: Stimulus) -> dict[str, Array]:
        """Derivatives of the readings by each quantity of `needs`, arrays (..., n, k, width); numerical by default."""
        found = {}
        for name in self.needs:
            value = stimulus[name]

            def shifted(shift: Array, name: str = name, value: Array = value) -> Array:
                return self.readings(parameters, stimulus.made({**stimulus, name: value + shift}))

            found[name] = differences_at(shifted, value, steps_at(value), 1)
        return found

    def felt(self, parameters: Array, readings: Array, known: Stimulus | None = None) -> Stimulus:
        """What was felt of the quantities that it senses, by Newton's method; with more channels by least squares.

        Parameters
        ----------
        parameters : array (..., p)
        readings : array (..., n, k)
        known : arrays (..., n, width), optional
            The other quantities that the readings depend on.

        Returns
        -------
        Stimulus
            Arrays (..., n, width) of `senses`, and what was known; nan where no stimulus gives the readings.
        """
        shape = np.broadcast_shapes(readings.shape[:-1], (*parameters.shape[:-1], 1))
        others = self._others(known, shape)
        widths = self._widths
        z = np.zeros((*shape, sum(widths)))
        cuts = np.cumsum(widths)[:-1]
        with np.errstate(all="ignore"):
            for _ in range(_MOST_STEPS):
                at = Stimulus({**others, **dict(zip(self.senses, np.split(z, cuts, axis=-1), strict=True))})
                left = readings - self.readings(parameters, at)
                slopes = self.by_stimulus(parameters, at)
                matrix = np.concatenate([slopes[name] for name in self.senses], axis=-1)
                if matrix.shape[-1] < matrix.shape[-2]:
                    turned = matrix.swapaxes(-1, -2)
                    matrix, left = turned @ matrix, (turned @ left[..., None])[..., 0]
                step = _solved(np.broadcast_to(matrix, (*shape, *matrix.shape[-2:])), left)
                z = z + step
                size = np.abs(step) - _SETTLED * (1.0 + np.abs(z))
                if not (size > 0.0).any():
                    break
            else:
                z = np.where((size > 1e-9).any(axis=-1, keepdims=True), np.nan, z)
        return Stimulus({**others, **dict(zip(self.senses, np.split(z, cuts, axis=-1), strict=True))})

    def _others(self, known: Stimulus | None, shape: tuple[int, ...]) -> dict[str, Array]:
        """What the readings depend on and do not tell."""
        others = {} if known is None else {name: known[name] for name in self.needs if name in known}
        zero = {name: np.zeros((*shape, 3)) for name in AT_REST if name in self.needs and name not in others}
        return {name: value for name, value in {**others, **zero}.items() if name not in self.senses}

    @property
    def _widths(self) -> list[int]:
        """Components of each quantity that is sensed."""
        widths = [self.width(name) for name in self.senses]
        if not widths or sum(widths) > len(self.channels):
            raise ArgumentError(
                f"{type(self).__name__}: its {len(self.channels)} channels can't give "
                f"{', '.join(self.senses) or 'what it feels'}"
            )
        return widths


def _solved(matrix: Array, vector: Array) -> Array:
    """Solutions (..., k) of equations (..., k, k); nan where there are none."""
    try:
        return np.asarray(np.linalg.solve(matrix, vector[..., None])[..., 0])
    except np.linalg.LinAlgError:
        regular = np.array(np.isfinite(matrix).all(axis=(-2, -1)))
        regular[regular] = np.linalg.matrix_rank(matrix[regular]) == matrix.shape[-1]
        found = np.full(vector.shape, np.nan)
        found[regular] = np.linalg.solve(matrix[regular], vector[regular][..., None])[..., 0]
        return found
