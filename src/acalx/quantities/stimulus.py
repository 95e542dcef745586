"""What a sensor feels in a position."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from acalx.numerics.arrays import Array

__all__ = ["EARTH_RATE", "Stimulus"]

# In rad/s, 15.041 deg/h: the unit of angular rate. Source: IERS Conventions (2010), table 1.2.
EARTH_RATE = 7.292115e-5


@dataclass(frozen=True, eq=False)
class Stimulus:
    """Specific force, angular rate and magnetic field at the sensor, in sensor axes, for stacks of programs.

    A stand makes it from its settings, a model reads it; a quantity that a stand does not
    provide is ``None``. The same class carries derivatives: there each array has further
    axes behind those given here.

    Parameters
    ----------
    specific_force : array (..., n, 3), in g
        At rest this is the unit vector of the vertical.
    angular_rate : array (..., n, 3), in units of the Earth's rate, optional
    magnetic_field : array (..., n, 3), in units of the field's magnitude, optional
    """

    specific_force: Array | None = None
    angular_rate: Array | None = None
    magnetic_field: Array | None = None

    def quantities(self) -> Iterator[tuple[str, Array]]:
        """Names and arrays of the quantities that are there."""
        return ((name, value) for name, value in vars(self).items() if value is not None)
