"""Sensors whose readings are sums of products of parameters and components of the stimulus, given as a table."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import final

import numpy as np

from acalx.errors import ArgumentError
from acalx.numerics.arrays import Array, empty_as
from acalx.options import is_number
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import UNITS_OF, Stimulus, conversion
from acalx.sensors.base import Channel, Factors, Sensor

__all__ = [
    "Components",
    "Factors",
    "Part",
    "Polynomial",
    "Term",
    "components_of",
    "multiplied",
    "require_axis",
    "require_noise",
]

# What is felt by quantity and component, each (..., n).
Components = Mapping[tuple[str, int], Array]

# One letter for each quantity, so that a product is a word: "fx fz" is the specific force along x times that along z.
_LETTERS: Mapping[str, str] = MappingProxyType(
    {"f": "specific_force", "w": "angular_rate", "a": "angular_acceleration", "b": "magnetic_field"}
)
_SCALARS: Mapping[str, str] = MappingProxyType({"t": "temperature"})


@final
@dataclass(frozen=True)
class Term:
    """A parameter and the product of components of the stimulus that it multiplies in a channel.

    Parameters
    ----------
    parameter : Parameter or None
        None: what a sensor without errors reads.
    factors : tuple of (quantity, component), or str
        As in ``(("specific_force", 0), ("specific_force", 2))`` or ``"fx fz"``; empty for a bias. The letters are
        f specific force, w angular rate, a angular acceleration, b magnetic field, and t temperature, which has
        no axis. A quantity is in the unit of the channel that reads it, `Term(None, "wx")` of one in deg/s, where that
        is one of its kind; otherwise in g, in rates of the Earth, rad/s^2, strengths of the field and degC.
    factor : float
        A constant in front, which brings the product into the unit of the reading.
    channel : int
        Of the reading, counted from 0.

    Raises
    ------
    ArgumentError
        A word that is no component.
    """

    parameter: Parameter | None
    factors: Factors | str = ()
    factor: float = 1.0
    channel: int = 0

    def __post_init__(self) -> None:
        if isinstance(self.factors, str):
            object.__setattr__(self, "factors", tuple(_component_named(word) for word in self.factors.split()))

    @property
    def product(self) -> Factors:
        """The factors as quantities with their components."""
        assert not isinstance(self.factors, str)  # words are read at construction
        return self.factors


class Polynomial(Sensor):
    """A sensor that is linear in parameters which multiply products of the stimulus.

    A new sensor gives `terms`, and `channels` where it has other than one in units of its noise; all the
    rest, exact derivatives and the degree for proofs included, follows.
    """

    @property
    @abstractmethod
    def terms(self) -> tuple[Term, ...]:
        """What each parameter multiplies, in each channel; and what a sensor without errors reads."""

    @property
    def noise(self) -> float:
        """Standard deviation of a reading of a sensor with a single channel."""
        return 1.0

    @property
    def channels(self) -> tuple[Channel, ...]:
        """One channel, unless a sensor says otherwise."""
        return (Channel("reading", "1", self.noise),)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters that the terms have, in the order in which they come first."""
        return tuple(dict.fromkeys(term.parameter for term in self.terms if term.parameter is not None))

    @cached_property
    def needs(self) -> Mapping[str, str]:
        """The quantities that occur in the terms, in the units that stands of acalx give; others as they come."""
        names = dict.fromkeys(quantity for term in self.terms for quantity, _ in term.product)
        return {name: self._unit_of(name) for name in names}

    def _unit_of(self, quantity: str) -> str:
        """That of a channel which reads the quantity itself, in a unit of its kind; otherwise that of stands."""
        usual = UNITS_OF.get(quantity, "")
        scaled = ((t.channel, t.factor * t.parameter.nominal, t.product) for t in self.terms if t.parameter is not None)
        for channel, factor, product in (*self.ideal, *scaled):
            own = self.channels[channel].unit
            plain = factor == 1.0 and [name for name, _ in product] == [quantity]
            if plain and conversion(usual, own) is not None:
                return own
        return usual

    @property
    def degree(self) -> int:
        """Number of factors of the longest product that a parameter multiplies."""
        return max(len(term.product) for term in self.terms if term.parameter is not None)

    @cached_property
    def table(self) -> tuple[tuple[int, int, float, Factors], ...]:
        """Channel, parameter, constant and product of each term that has a parameter."""
        numbers = {parameter: k for k, parameter in enumerate(self.parameters)}
        return tuple((t.channel, numbers[t.parameter], t.factor, t.product) for t in self.terms if t.parameter)

    @cached_property
    def ideal(self) -> tuple[tuple[int, float, Factors], ...]:
        """Channel, constant and product of each term of a sensor without errors."""
        return tuple((term.channel, term.factor, term.product) for term in self.terms if term.parameter is None)

    def part(self, numbers: Sequence[int], name: str) -> Sensor:
        """Some of its channels by themselves, with the parameters that show in them."""
        return Part(self, tuple(numbers), name)

    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        """The products, each times its parameter, summed up in each channel: (..., n, k)."""
        columns: list[Array | float] = [0.0] * len(self.channels)
        components = self._components(stimulus)
        for channel, factor, product in self.ideal:
            columns[channel] = columns[channel] + multiplied(factor, product, components)
        spread = parameters[..., None]  # (..., p, 1): along the positions
        for channel, number, factor, product in self.table:
            columns[channel] = columns[channel] + spread[..., number, :] * multiplied(factor, product, components)
        shape = np.broadcast_shapes((*parameters.shape[:-1], 1), _shape(stimulus, self.needs))
        return np.stack([np.broadcast_to(column, shape) for column in columns], axis=-1)

    def by_parameters(self, parameters: Array, stimulus: Stimulus) -> Array:
        """The products themselves, whatever the parameters are: (..., n, k, p)."""
        first = stimulus[next(iter(self.needs))][..., 0]
        rows = empty_as(first, (*first.shape, len(self.channels), len(self.parameters)))
        rows[...] = 0.0
        components = self._components(stimulus)
        for channel, number, factor, product in self.table:
            rows[..., channel, number] += multiplied(factor, product, components)
        return rows

    def by_stimulus(self, parameters: Array, stimulus: Stimulus) -> dict[str, Array]:
        """Exact derivatives of the readings, by the product rule."""
        shape = np.broadcast_shapes((*parameters.shape[:-1], 1), _shape(stimulus, self.needs))
        k, spread = len(self.channels), parameters[..., None]
        slopes = {name: np.zeros((*shape, k, stimulus[name].shape[-1])) for name in self.needs}
        components = self._components(stimulus)
        every: list[tuple[int, Array | float, float, Factors]]
        every = [(channel, 1.0, factor, product) for channel, factor, product in self.ideal]
        every += [(channel, spread[..., number, :], factor, product) for channel, number, factor, product in self.table]
        for channel, size, factor, product in every:
            for i, (quantity, component) in enumerate(product):
                others = product[:i] + product[i + 1 :]
                slopes[quantity][..., channel, component] += size * multiplied(factor, others, components)
        return slopes

    def _components(self, stimulus: Stimulus) -> Components:
        return components_of(stimulus, (term.product for term in self.terms))


@final
@dataclass(frozen=True)
class Part(Polynomial):
    """Some channels of a sensor by themselves, with the parameters that show in them.

    Parameters
    ----------
    whole : Polynomial
    numbers : tuple of int
        Of its channels.
    name : str
        Of the kind of sensors that they are.
    """

    whole: Polynomial
    numbers: tuple[int, ...]
    name: str

    @property
    def kind(self) -> str:
        """As it was given."""
        return self.name

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Those of the numbers."""
        return tuple(self.whole.channels[number] for number in self.numbers)

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """Those in these channels."""
        places = {number: k for k, number in enumerate(self.numbers)}
        return tuple(replace(t, channel=places[t.channel]) for t in self.whole.terms if t.channel in places)

    @cached_property
    def needs(self) -> Mapping[str, str]:
        """What occurs in its terms, and what the whole needs beside its terms, for its noise perhaps."""
        own, every = (
            {quantity for term in terms for quantity, _ in term.product} for terms in (self.terms, self.whole.terms)
        )
        return {name: unit for name, unit in self.whole.needs.items() if name in own or name not in every}

    def deviations(self, stimulus: Stimulus) -> Array:
        """Those of the channels."""
        return np.asarray(self.whole.deviations(stimulus))[..., list(self.numbers)]

    @property
    def noise_varies(self) -> bool:
        """As that of the whole."""
        return self.whole.noise_varies

    def correlation(self, times: Array) -> Array | None:
        """As of the whole: the noise of its channels is that of theirs."""
        return self.whole.correlation(times)


def components_of(stimulus: Stimulus, products: Iterable[Factors]) -> Components:
    """The components (..., n) that occur in products, each once."""
    return {pair: stimulus[pair[0]][..., pair[1]] for product in products for pair in product}


def multiplied(factor: float, product: Factors, components: Components) -> Array | float:
    """A constant times a product of components, (..., n); the constant alone where there are none."""
    if not product:
        return factor
    first, *others = product
    value = components[first] if factor == 1.0 else factor * components[first]
    for pair in others:
        value = value * components[pair]
    return value


def require_noise(name: str, value: object) -> float:
    """A standard deviation as a number, or ArgumentError."""
    if not is_number(value) or value <= 0:
        raise ArgumentError.of(name, value, "a standard deviation is a positive number")
    return float(value)


def require_axis(name: str, value: object) -> int:
    """Number of an axis given by its letter, or ArgumentError."""
    if not isinstance(value, str) or value not in ("x", "y", "z"):
        raise ArgumentError.of(name, value, "an axis is x, y or z")
    return "xyz".index(value)


def three_of(name: str, value: float | Sequence[float]) -> tuple[float, ...]:
    """A standard deviation for each of three axes, from one number or three."""
    values = tuple(value) if isinstance(value, Sequence) and not isinstance(value, str) else (value,) * 3
    if len(values) != 3:
        raise ArgumentError.of(name, value, "give one number, or three for the x, y and z sensor")
    return tuple(require_noise(name, each) for each in values)


def _component_named(word: str) -> tuple[str, int]:
    if word in _SCALARS:
        return _SCALARS[word], 0
    if len(word) != 2 or word[0] not in _LETTERS or word[1] not in "xyz":
        known = ", ".join(f"{letter} {name}" for letter, name in {**_LETTERS, **_SCALARS}.items())
        raise ArgumentError(f"factors: {word!r} is no component; write a letter and an axis, as in fx; {known}")
    return _LETTERS[word[0]], "xyz".index(word[1])


def _shape(stimulus: Stimulus, names: Mapping[str, str]) -> tuple[int, ...]:
    return np.broadcast_shapes(*(stimulus[name].shape[:-1] for name in names))
