"""Units of a stand's settings: how they are written on the command line and in files."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.numerics.arrays import Array

__all__ = ["CELSIUS", "DEGREE", "DEGREE_PER_SECOND", "KELVIN", "METER", "SECOND", "UNITS", "Unit", "unit_of_column"]

# Digits that are written: finer than a double holds in rad, so that 45 degrees stay 45.
_DECIMALS = 12


@final
@dataclass(frozen=True)
class Unit:
    """A unit that people read and write, and its size in SI.

    Parameters
    ----------
    suffix : str
        What names of columns and options end in, ``deg`` in ``alpha1_deg``.
    symbol : str
        Heads a column of a table.
    plural : str
        In a sentence after a number.
    size : float
        One of it in rad, rad/s or another unit of the SI.
    turn : float, optional
        So many are a full turn; None where the setting is no angle.
    """

    suffix: str
    symbol: str
    plural: str
    size: float
    turn: float | None = None

    def column(self, name: str) -> str:
        """Name of a setting's column and option."""
        return f"{name}_{self.suffix}"

    def write(self, values: Array | float) -> Array:
        """Values in this unit, from the SI, free of the rounding that the way there leaves."""
        return np.asarray(np.round(np.asarray(values) / self.size, _DECIMALS) + 0.0)

    def read(self, values: Array | float) -> Array:
        """Values in rad, rad/s or what the SI has, from this unit."""
        return np.asarray(values) * self.size


DEGREE = Unit("deg", "deg", "degrees", math.pi / 180.0, 360.0)
DEGREE_PER_SECOND = Unit("deg_s", "deg/s", "degrees per second", math.pi / 180.0)
SECOND = Unit("s", "s", "seconds", 1.0)
KELVIN = Unit("K", "K", "kelvins", 1.0)
CELSIUS = Unit("degC", "degC", "degrees Celsius", 1.0)
METER = Unit("m", "m", "meters", 1.0)
# Those with the longer names first: a column in deg/s ends like one in s.
UNITS = (DEGREE_PER_SECOND, DEGREE, CELSIUS, SECOND, KELVIN, METER)


def unit_of_column(column: str, further: Sequence[Unit] = ()) -> tuple[str, Unit] | None:
    """Name and unit of the setting that a column is of, in further units or those of acalx; None where of none."""
    for unit in (*further, *UNITS):
        name = column.removesuffix(f"_{unit.suffix}")
        if name != column and name.isidentifier():
            return name, unit
    return None
