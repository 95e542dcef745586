"""What a sensor feels in a position."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import final

import numpy as np

from acalx.errors import ArgumentError
from acalx.numerics.arrays import Array

__all__ = ["AT_REST", "EARTH_RATE", "UNITS_OF", "VECTORS", "Stimulus", "conversion", "same_kind"]

# In rad/s, 15.041 deg/h: the unit of angular rate. Source: IERS Conventions (2010), table 1.2.
EARTH_RATE = 7.292115e-5

# Units of the quantities that stands of acalx give; a quantity of another name says its own.
UNITS_OF: Mapping[str, str] = MappingProxyType(
    {
        "specific_force": "g",
        "angular_rate": "earth_rate",
        "angular_acceleration": "rad/s^2",
        "magnetic_field": "field",
        "temperature": "degC",
        "dwell": "s",
        "time": "s",
    }
)
# Those of them that are vectors in sensor axes; a sensor says which quantities of its own are.
VECTORS = ("specific_force", "angular_rate", "angular_acceleration", "magnetic_field")
# Those that are zero where nobody tells them.
AT_REST = ("angular_acceleration",)
# What units of the same kind are in SI. The others are read as they are given, or not at all.
_SIZES: Mapping[str, tuple[str, float]] = MappingProxyType(
    {
        "g": ("force", 9.80665),
        "m/s^2": ("force", 1.0),
        "earth_rate": ("rate", EARTH_RATE),
        "rad/s": ("rate", 1.0),
        "deg/s": ("rate", np.pi / 180.0),
        "deg/h": ("rate", np.pi / 180.0 / 3600.0),
        "T": ("field", 1.0),
        "G": ("field", 1e-4),
        "uT": ("field", 1e-6),
        "nT": ("field", 1e-9),
        "rad/s^2": ("angular acceleration", 1.0),
        "deg/s^2": ("angular acceleration", np.pi / 180.0),
        "s": ("time", 1.0),
        "min": ("time", 60.0),
        "h": ("time", 3600.0),
    }
)


def conversion(given: str, wanted: str) -> float | None:
    """By what a value in one unit is multiplied to be in another; None where neither is known as of the other's kind.

    What is wanted in no unit, ``""``, is taken as it comes.

    Examples
    --------
    >>> conversion("rad/s", "rad/s"), conversion("degC", "K"), conversion("T", "field")
    (1.0, None, None)
    >>> round(conversion("rad/s", "deg/s"), 4)
    57.2958
    """
    if given == wanted or not wanted:
        return 1.0
    if given not in _SIZES or wanted not in _SIZES:  # a kind is no unit: "field" is no tesla
        return None
    (kind, size), (other, unit) = _SIZES[given], _SIZES[wanted]
    return size / unit if kind == other else None


def same_kind(unit: str) -> list[str]:
    """Other units that values in this one can be converted to."""
    return [name for name in _SIZES if name != unit and conversion(unit, name) is not None]


@final
class Stimulus(Mapping[str, Array]):
    """What is felt, in sensor axes, for stacks of programs: quantities by name, each with its unit.

    A stand makes it from its settings, a sensor reads it. A position may be an interval in which what
    is felt changes, a turn perhaps: then each array has K samples of it, and readings are means over
    them. The same class carries derivatives: there each array has further axes behind those given here.

    Parameters
    ----------
    quantities : mapping, or by keyword
        Arrays (..., n, width) by name: ``specific_force``, ``angular_rate``, ``magnetic_field``
        with three components, ``temperature`` with one, or whatever a stand provides. With
        `weights` (..., n, K, width).
    units : mapping, optional
        Of the quantities whose names are not those of `UNITS_OF`, or that come in another unit.
    weights : array (K,), optional
        Of the samples in a position; their sum is 1.

    Examples
    --------
    >>> felt = Stimulus(specific_force=np.array([[0.0, 0.0, 1.0]]), temperature=np.array([[20.0]]))
    >>> felt["specific_force"].shape, felt.units["temperature"]
    ((1, 3), 'degC')
    """

    __slots__ = ("_quantities", "_units", "weights")

    def __init__(
        self,
        quantities: Mapping[str, Array] | None = None,
        /,
        *,
        units: Mapping[str, str] | None = None,
        weights: Array | None = None,
        **named: Array,
    ) -> None:
        self._quantities = {**quantities, **named} if quantities else named
        self._units = units
        self.weights = weights

    def __getitem__(self, name: str) -> Array:
        return self._quantities[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._quantities)

    def __len__(self) -> int:
        return len(self._quantities)

    def __repr__(self) -> str:
        return f"Stimulus({', '.join(f'{name}: {np.shape(value)}' for name, value in self.items())})"

    @property
    def units(self) -> dict[str, str]:
        """Unit of each quantity; empty for one that nobody has told."""
        own = self._units or {}
        return {name: own.get(name, UNITS_OF.get(name, "")) for name in self}

    @property
    def plain(self) -> bool:
        """Whether each position is one and not a motion, and each quantity in the unit of `UNITS_OF`."""
        return self.weights is None and self._units is None

    def made(self, quantities: Mapping[str, Array]) -> Stimulus:
        """Other quantities, with the same units and weights."""
        return Stimulus(quantities, units=self._units, weights=self.weights)

    def in_units(self, wanted: Mapping[str, str]) -> Stimulus:
        """The same with quantities in these units, by name.

        Raises
        ------
        ArgumentError
            A unit that the one in which a quantity comes can't be converted to.
        """
        factors = self.factors(wanted)
        if all(factor == 1.0 for factor in factors.values()):
            return self
        units = {**self.units, **{name: wanted[name] for name in factors}}
        changed = {name: factor * self[name] for name, factor in factors.items()}
        return Stimulus({**self, **changed}, units=units, weights=self.weights)

    def factors(self, wanted: Mapping[str, str]) -> dict[str, float]:
        """By what each quantity that is there and wanted is multiplied to be in the wanted unit."""
        given = self.units
        return {name: require_unit(name, given[name], unit) for name, unit in wanted.items() if name in self}

    def from_units(self, gradient: Stimulus, wanted: Mapping[str, str]) -> Stimulus:
        """A gradient by quantities in the wanted units, as one by them in the units in which they come here."""
        factors = self.factors({name: wanted[name] for name in gradient})
        if all(factor == 1.0 for factor in factors.values()):
            return gradient
        return gradient.made({name: factors[name] * value for name, value in gradient.items()})

    def without_samples(self) -> Stimulus:
        """All the samples one behind the other as positions, (..., n K, width); itself where there are none."""
        if self.weights is None:
            return self
        flat = {name: value.reshape((*value.shape[:-3], -1, value.shape[-1])) for name, value in self.items()}
        return Stimulus(flat, units=self._units)

    def timed(self, needs: Iterable[str], dwell_s: float) -> Stimulus:
        """The same with the time in each position, and since the start, where they are needed and not told.

        Parameters
        ----------
        needs : iterable of str
            Names of quantities; ``dwell`` and ``time`` are given, each (..., n, 1) in s. The time is that in the middle
            of a position, one after the other with nothing between.
        dwell_s : float, s
            In each position, where the stand does not say.
        """
        wanted = [name for name in ("dwell", "time") if name in needs and name not in self]
        if not wanted:
            return self
        some = next(iter(self.values()))
        shape = some.shape[:-1] if self.weights is None else some.shape[:-2]
        if "dwell" in self:
            dwell = require_unit("dwell", self.units["dwell"], "s") * self["dwell"]
            across = dwell if self.weights is None else dwell[..., 0, :]
        else:
            across = np.full((*shape, 1), dwell_s)
        told = {"dwell": across, "time": np.cumsum(across, axis=-2) - 0.5 * across}
        if self.weights is not None:  # the same throughout a position
            told = {name: np.repeat(value[..., None, :], len(self.weights), axis=-2) for name, value in told.items()}
        return self.made({**self, **{name: told[name] for name in wanted}})

    def untimed(self, gradient: Stimulus) -> Stimulus:
        """A gradient by the time since the start as one by the times in the positions that make it, if there is one."""
        if "time" not in gradient:
            return gradient
        by_time = gradient["time"] if self.weights is None else gradient["time"].sum(axis=-2)
        later = np.flip(np.cumsum(np.flip(by_time, axis=-2), axis=-2), axis=-2) - 0.5 * by_time
        by_dwell = later / require_unit("dwell", "s", self.units.get("dwell", "s"))
        if self.weights is not None:  # the same throughout a position, whose first sample is read
            by_dwell = np.concatenate(
                [by_dwell[..., None, :], np.zeros((*by_dwell.shape[:-1], len(self.weights) - 1, 1))], axis=-2
            )
        return gradient.made({**gradient, "dwell": gradient.get("dwell", 0.0) + by_dwell})

    def vertical(self) -> Array | None:
        """The specific force where it is one in each position, (..., n, 3); None where it changes, or is not there."""
        return self.get("specific_force") if self.weights is None else None

    def mean(self) -> Stimulus:
        """What is felt on average in each position, (..., n, width)."""
        if self.weights is None:
            return self
        means = {name: np.einsum("k,...kw->...w", self.weights, value) for name, value in self.items()}
        return Stimulus(means, units=self._units)


def require_unit(name: str, given: str, wanted: str) -> float:
    """The factor between units of a quantity, or ArgumentError that names both."""
    factor = conversion(given, wanted)
    if factor is None:
        raise ArgumentError(f"{name} comes in {given or 'no unit that is known'}, but {wanted} is needed")
    return factor
