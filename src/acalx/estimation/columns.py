"""Columns of a file that say what was felt: settings of a stand, and quantities with their units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from acalx.errors import DataError
from acalx.files import CsvFile
from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import UNITS_OF, VECTORS, Stimulus, conversion
from acalx.stands import Stand

__all__ = ["COSINES", "Known", "columns_for", "needs_of"]

# Direction cosines in sensor axes, which have no unit: of the vertical, and of the field.
COSINES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"specific_force": ("eta_x", "eta_y", "eta_z"), "magnetic_field": ("field_eta_x", "field_eta_y", "field_eta_z")}
)
_TIMES = {"s": "s", "min": "min", "h": "h"}
# Units by what names of columns end in; the first is what people use.
_SUFFIXES: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "specific_force": {"g": "g", "m_s2": "m/s^2"},
        "angular_rate": {"deg_s": "deg/s", "deg_h": "deg/h", "rad_s": "rad/s", "earth_rate": "earth_rate"},
        "angular_acceleration": {"rad_s2": "rad/s^2", "deg_s2": "deg/s^2"},
        "magnetic_field": {"uT": "uT", "nT": "nT", "G": "G", "T": "T", "field": "field"},
        "temperature": {"degC": "degC", "K": "K"},
        "dwell": _TIMES,
        "time": _TIMES,
    }
)
# Those in which a quantity comes where the name of its column says none: others could be in several.
_UNTOLD = {"specific_force": "g"}
_KELVIN = 273.15
_ZERO = {"K": 0.0, "degC": -_KELVIN}
# Cosine of the angle between what settings and direction cosines say, 5 degrees: what a stand is off by is less.
_ALIKE = 0.9962


def needs_of(model: Model) -> dict[str, str]:
    """The quantities that a model needs with their units, which are empty where it does not say them."""
    needs = model.needs if isinstance(model.needs, Mapping) else dict.fromkeys(model.needs)
    return {name: unit or "" for name, unit in needs.items()}


def columns_for(quantity: str, unit: str = "", width: int = 1) -> str:
    """What columns that tell a quantity are called, for messages; of one that only a sensor knows in its unit."""
    if quantity in COSINES:
        return ", ".join(COSINES[quantity])
    first, *others = _suffixes(quantity, unit) or [""]
    either = f" (or ..{', ..'.join(f'_{other}' for other in others)})" if others else ""
    return ", ".join(_names(quantity, first, width)) + either


class Known:
    """What columns of a file tell of the stimulus: the settings of a stand, and quantities by themselves.

    Parameters
    ----------
    file : CsvFile
    header : list of str
    quantities : mapping, or sequence of str
        Those that columns of their own may tell; a mapping gives the units in which they are needed.
    stand : Stand, optional
    taken : collection of str
        Columns that are something else.

    Raises
    ------
    DataError
        A quantity whose columns do not say their unit; from `stimulus`, one in a unit that can't be converted.
    """

    def __init__(
        self,
        file: CsvFile,
        header: list[str],
        quantities: Mapping[str, str] | Sequence[str],
        stand: Stand | None,
        taken: Sequence[str] = (),
    ) -> None:
        self.file, self.stand = file, stand
        self.settings = () if stand is None or not set(stand.axes.columns) <= set(header) else stand.axes.columns
        self.wanted = dict(quantities) if isinstance(quantities, Mapping) else dict.fromkeys(quantities, "")
        left = [name for name in header if name not in {*taken, *self.settings}]
        found = {quantity: self._told_by(quantity, left) for quantity in self.wanted}
        self.quantities = {quantity: told for quantity, told in found.items() if told is not None}
        self.columns = (*self.settings, *(name for names, _ in self.quantities.values() for name in names))

    @property
    def cosines(self) -> list[tuple[str, ...]]:
        """The columns of direction cosines that are there."""
        return [names for names, _ in self.quantities.values() if names in COSINES.values()]

    def stimulus(self, values: Array) -> Stimulus | None:
        """What the settings tell, and what columns of their own say of each quantity: values (n, columns)."""
        columns = {name: values[:, k] for k, name in enumerate(self.columns)}
        felt = Stimulus()
        if self.settings:
            assert self.stand is not None  # its settings are there
            settings = np.stack([columns[name] for name in self.settings], axis=-1)
            felt = self.stand.stimulus(self.stand.axes.read(settings))
        told, units = {}, felt.units
        for quantity, (names, unit) in self.quantities.items():
            value = np.stack([columns[name] for name in names], axis=-1)
            if names in COSINES.values():
                self._check_alike(quantity, value, felt, values)
                value = value / np.linalg.norm(value, axis=1, keepdims=True)
                if quantity in felt and felt.weights is None and quantity != "specific_force":
                    value, unit = value * np.linalg.norm(felt[quantity], axis=1, keepdims=True), felt.units[quantity]
            told[quantity], units[quantity] = self._in_unit(quantity, value, unit)
            if felt.weights is not None:  # the same throughout a position
                told[quantity] = np.repeat(told[quantity][:, None, :], len(felt.weights), axis=1)
        return Stimulus({**felt, **told}, units=units, weights=felt.weights) if told or felt else None

    def _told_by(self, quantity: str, header: Sequence[str]) -> tuple[tuple[str, ...], str] | None:
        """The columns that tell a quantity, and their unit; None where there are none."""
        if quantity in COSINES and set(COSINES[quantity]) <= set(header):
            return COSINES[quantity], UNITS_OF[quantity]
        suffixes = _suffixes(quantity, self.wanted[quantity])
        for suffix, unit in suffixes.items():
            for names in (_names(quantity, suffix), _names(quantity, suffix, 3)):
                if set(names) <= set(header):
                    return names, unit
        for names in (_names(quantity, ""), _names(quantity, "", 3), (quantity,)):
            if set(names) <= set(header):
                untold = _UNTOLD.get(quantity) if quantity in _SUFFIXES else self.wanted[quantity]
                if untold is None:
                    right = " or ".join(", ".join(_names(quantity, suffix)) for suffix in suffixes)
                    raise DataError(f"{self.file.path}: {', '.join(names)} without a unit in the name; call it {right}")
                return names, untold
        return None

    def _in_unit(self, quantity: str, value: Array, given: str) -> tuple[Array, str]:
        """Values in the unit in which stands give the quantity, or in the wanted one that can't be had from that."""
        if given in _ZERO and (value < _ZERO[given]).any():
            names, _ = self.quantities[quantity]
            raise DataError(f"{self.file.path}: {', '.join(names)}: {value.min():g} {given} is below absolute zero")
        usual, wanted = UNITS_OF.get(quantity, given), self.wanted[quantity]
        unit = wanted if wanted and conversion(usual, wanted) is None else usual
        if {given, unit} == {"degC", "K"}:
            return value + (_KELVIN if unit == "K" else -_KELVIN), unit
        factor = conversion(given, unit)
        if factor is None:
            names, _ = self.quantities[quantity]
            others = "" if quantity not in COSINES or names in COSINES.values() else f": give {columns_for(quantity)}"
            raise DataError(
                f"{self.file.path}: {', '.join(names)} can't be in {unit}, in which the "
                f"{quantity.replace('_', ' ')} is needed{others or ': give it in that'}"
            )
        return value * factor, unit

    def _check_alike(self, quantity: str, cosines: Array, felt: Stimulus, values: Array) -> None:
        """Raise DataError where the settings bring the vector elsewhere than the cosines say."""
        if quantity not in felt or felt.weights is not None:
            return
        lengths = np.linalg.norm(cosines, axis=-1) * np.linalg.norm(felt[quantity], axis=-1)
        wrong = (cosines * felt[quantity]).sum(axis=-1) < _ALIKE * lengths
        if wrong.any():
            row = dict(zip(self.columns, values[np.argmax(wrong)].tolist(), strict=True))
            settings, told = (
                ", ".join(f"{k} {row[k]:.6g}" for k in names) for names in (self.settings, COSINES[quantity])
            )
            what = "vertical" if quantity == "specific_force" else quantity.replace("_", " ")
            raise DataError(
                f"{self.file.path}: {settings} and {told} contradict each other: on stand {type(self.stand).__name__} "
                f"the {what} is more than 5 degrees from there; leave the columns out that are wrong"
            )


def _names(quantity: str, suffix: str, width: int = 1) -> tuple[str, ...]:
    """Columns of a quantity: three with an axis behind the name where it is a vector, then the unit."""
    end = f"_{suffix}" if suffix else ""
    vector = width > 1 or quantity in VECTORS
    return tuple(f"{quantity}_{axis}{end}" for axis in "xyz") if vector else (f"{quantity}{end}",)


def _suffixes(quantity: str, unit: str) -> Mapping[str, str]:
    """Units by what names of columns end in; of a quantity that only a sensor knows the one in which that takes it."""
    own = "".join(each for each in unit.replace("/", "_") if each.isalnum() or each == "_")
    return _SUFFIXES.get(quantity, {own: unit} if own else {})
