"""Calibration programs: positions of a sensor that are given."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.errors import CompatibilityError, ProgramError
from acalx.numerics.arrays import Array
from acalx.quantities.units import DEGREE, Unit
from acalx.stands import Stand

__all__ = ["Program", "first_not_unit", "lengths_of"]

# Cosines printed with three decimals are this far from a unit vector at most.
_UNIT_TOLERANCE = 1e-3


@final
@dataclass(frozen=True, eq=False)
class Program:
    """n positions of a sensor, as angles of a stand or as directions of the vertical.

    Parameters
    ----------
    name : str
        What `find_program` takes to give it again.
    title : str
        One line for a table.
    source : str
        Who printed it, or the file that it was read from.
    settings : array (n, d), rad or the SI unit, optional
        Settings of a stand. Either these or the directions are given.
    settings_names : tuple of str, length d
        Names of the stand's settings, without a unit.
    directions : array (n, 3), optional
        Unit vectors of the vertical in sensor axes. Lengths within 0.1 % of 1, as of
        rounded cosines, are made 1.
    settings_units : tuple of Unit, length d, optional
        Units of the settings where people read them; degrees where none are given.

    Raises
    ------
    ProgramError
        Both or neither of them, a wrong shape, numbers that are not finite, vectors whose
        length is not 1.
    """

    name: str
    title: str
    source: str
    settings: Array | None = None
    settings_names: tuple[str, ...] = ()
    directions: Array | None = None
    settings_units: tuple[Unit, ...] = ()

    def __post_init__(self) -> None:
        if (self.settings is None) == (self.directions is None):
            raise ProgramError(f"program {self.name}: give either settings or directions")
        if self.settings is not None:
            object.__setattr__(
                self, "settings", _finite(self.name, "settings", self.settings, len(self.settings_names))
            )
        if self.directions is not None:
            directions = _finite(self.name, "directions", self.directions, 3)
            lengths = lengths_of(directions)
            if (k := first_not_unit(lengths)) is not None:
                raise ProgramError(
                    f"program {self.name}, position {k + 1}: a direction of length {lengths[k]:.6g}, expected 1"
                )
            object.__setattr__(self, "directions", directions / lengths[:, None])

    @property
    def n(self) -> int:
        """How many positions there are, however they are given."""
        positions = self.directions if self.settings is None else self.settings
        assert positions is not None  # refused at construction
        return len(positions)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the settings with their units, as in files."""
        units = self.settings_units or (DEGREE,) * len(self.settings_names)
        return tuple(unit.column(name) for name, unit in zip(self.settings_names, units, strict=True))

    def suits(self, stand: Stand) -> bool:
        """Whether it gives angles of this stand, or directions that the stand can be aimed at."""
        try:
            self.settings_for(stand)
        except CompatibilityError:
            return False
        return True

    def settings_for(self, stand: Stand) -> Array:
        """Settings that put the sensor into the positions on this stand.

        They come in the order of the stand's settings; directions are aimed at. Settings that are no
        angles and that the program does not name are at rest, 0. Limits and steps are not looked
        at: `Axes.allows` says which positions a stand can take.

        Parameters
        ----------
        stand : Stand with d settings

        Returns
        -------
        array (n, d), rad or the SI unit

        Raises
        ------
        CompatibilityError
            Settings of a stand with other settings, or directions for a stand that can't be
            aimed; the message names the angles that the stand needs.
        """
        needed = ", ".join(stand.axes.columns)
        if self.settings is None:
            assert self.directions is not None  # refused at construction
            try:
                return stand.aim(self.directions)
            except CompatibilityError as error:
                raise CompatibilityError(
                    f"program {self.name} gives directions of the vertical, "
                    f"but stand {type(stand).__name__} needs its settings, {needed} ({error})"
                ) from error
        resting = [s.column for s in stand.settings if s.column not in self.columns and not s.angle]
        if {*self.columns, *resting} != set(stand.axes.columns):
            raise CompatibilityError(
                f"program {self.name} gives {', '.join(self.columns)}, but stand {type(stand).__name__} needs {needed}"
            )
        given = dict(zip(self.columns, self.settings.T, strict=True))
        return np.stack([given.get(column, np.zeros(self.n)) for column in stand.axes.columns], axis=-1)


def _finite(name: str, what: str, values: Array, width: int) -> Array:
    array = np.array(values, dtype=float)
    if array.ndim != 2 or 0 in array.shape or array.shape[1] != width:
        raise ProgramError(f"program {name}: {what} of shape {array.shape}, expected (n, {width})")
    if not np.isfinite(array).all():
        raise ProgramError(f"program {name}: {what} must be finite numbers")
    return array


def lengths_of(vectors: Array) -> Array:
    """Lengths (n,) of vectors (n, 3), as they come."""
    with np.errstate(over="ignore"):
        return np.asarray(np.hypot(np.hypot(vectors[:, 0], vectors[:, 1]), vectors[:, 2]))


def first_not_unit(lengths: Array) -> int | None:
    """Index of the first length that is none of a unit vector, rounding of printed cosines aside."""
    wrong = np.abs(lengths - 1.0) > _UNIT_TOLERANCE
    return int(wrong.argmax()) if wrong.any() else None
