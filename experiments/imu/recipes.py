"""The usual recipes for an inertial measurement unit, as settings of a two-axis rate table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from acalx.numerics.arrays import Array
from acalx.programs import Program
from acalx.stands import TwoAxisRateTable

__all__ = ["RECIPES", "Recipe", "program_of"]

Position = tuple[float, float, float, float]

# Outer and inner angle in degrees, then their rates in degrees per second. The inner axis is z and the outer one, which
# is level, lies along x at inner 0 and against y at inner 90: there it turns the sensor about y.
FACES: list[Position] = [(0, 0, 0, 0), (180, 0, 0, 0), *((90, inner, 0, 0) for inner in (0, 90, 180, 270))]
STEPS = range(0, 360, 45)
TUMBLES: list[Position] = [
    *((angle, 0, 0, 0) for angle in STEPS),
    *((angle, 90, 0, 0) for angle in STEPS),
    *((90, angle, 0, 0) for angle in STEPS),
]
EDGES = [position for position in TUMBLES if position[0] % 90 or position[1] % 90]


def turns(*rates: float) -> list[Position]:
    """Turns about x, y and z of the sensor, each at all the rates in both directions."""
    signed = [sign * rate for rate in rates for sign in (1, -1)]
    about_x: list[Position] = [(0, 0, rate, 0) for rate in signed]
    about_y: list[Position] = [(0, 90, rate, 0) for rate in signed]
    return [*about_x, *about_y, *((0, 0, 0, rate) for rate in signed)]


@dataclass(frozen=True)
class Recipe:
    """A program as it is found in laboratories and standards.

    Parameters
    ----------
    title : str
        As tables and figures call it.
    positions : list of tuple of float
        Angles in degrees and rates in degrees per second.
    """

    title: str
    positions: list[Position]

    @property
    def n(self) -> int:
        """Number of positions, turns among them."""
        return len(self.positions)

    def settings(self, stand: TwoAxisRateTable) -> Array:
        """The positions in rad and rad/s, (n, 4)."""
        return stand.axes.read(np.array(self.positions, dtype=float))


RECIPES = {
    "six_faces_and_turns_12": Recipe("six faces and three turns both ways", [*FACES, *turns(100)]),
    "tumbles_24": Recipe("24 positions", TUMBLES),
    "multi_position_and_rates_36": Recipe("18 positions and rate steps", [*FACES, *EDGES, *turns(20, 50, 100)]),
}


def program_of(name: str, settings: Array, stand: TwoAxisRateTable) -> Program:
    """Settings (n, 4) in rad as a program with a name."""
    units = tuple(setting.unit for setting in stand.settings)
    return Program(name, name, name, settings, settings_names=stand.axes.names, settings_units=units)
