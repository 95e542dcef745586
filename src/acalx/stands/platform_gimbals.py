"""The gimbals of an inertial platform."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, final

from acalx.errors import Option
from acalx.stands.fields import limits, number
from acalx.stands.rotary import Rotary
from acalx.stands.turns import UP, Vector

__all__ = ["PlatformGimbals"]


@final
@dataclass(frozen=True)
class PlatformGimbals(Rotary):
    """Turns a platform about its horizontal outer axis, then about its own inner one, and holds it there.

    The platform feels gravity and the Earth's rotation. At gamma = alpha = 0 its x axis lies
    along the outer axis and z points up; with the outer axis east, x, y, z are east, north, up. In
    platform axes

        C = Rz(alpha) Rx(gamma) = [[ca, sa cg, sa sg], [-sa, ca cg, ca sg], [0, -sg, cg]],
        a = C (0, 0, 1)  in g,   w = C (cos phi cos psi, cos phi sin psi, sin phi)  in Earth rates,

    with the latitude phi and the azimuth psi of the outer axis, from north to the east. The
    Earth's rate is `acalx.quantities.stimulus.EARTH_RATE`, 15.041 deg/h. With the outer axis north or
    south, two of three gyros have a coefficient that no position shows.

    Of the outer axis the azimuth a and the tilt t may be off, of the inner one by s how far it is
    from square to the outer: C = Rz(alpha) Ry(s) Rx(gamma) Ry(t) Rz(a).

    Parameters
    ----------
    gamma_deg, alpha_deg : pair of float, degrees
        Limits of the angle of the outer and of the inner axis.
    azimuth_deg : float, degrees
        Of the outer axis: 0 is north, 90, the default, east.
    latitude_deg : float, degrees
        North is positive. The paper's is not known; the default is that of Xi'an.
    step_deg, periodic
        As of `Rotary`.
    forbidden, forbidden_if, speed_deg_s
        As of `Stand`.

    Raises
    ------
    ArgumentError
        Limits the wrong way round or not finite, a latitude beyond a pole, a step that is not
        positive.

    Source: Wang, Wang, Shen, Qin, J. Chin. Inert. Technol. 24(5), 2016, 583-588; gamma before alpha
    and the attitude at zero are printed there, the azimuth is an option of acalx.
    """

    turns: ClassVar[Mapping[str, str]] = {"gamma": "x", "alpha": "z"}
    installed: ClassVar[Mapping[str, str]] = {
        "outer_azimuth": "z",
        "outer_tilt": "y",
        "gamma": "x",
        "inner_squareness": "y",
        "alpha": "z",
    }
    gamma_deg: Sequence[float] = limits(0.0, 360.0)
    alpha_deg: Sequence[float] = limits(0.0, 360.0)
    azimuth_deg: float = number(90.0, -360.0, 360.0)
    latitude_deg: float = number(34.25, -90.0, 90.0)

    @cached_property
    def surroundings(self) -> Mapping[str, Vector]:
        """Gravity, and the Earth's rate along the outer axis, horizontally across it, and up."""
        latitude, azimuth = math.radians(self.latitude_deg), math.radians(self.azimuth_deg)
        level = math.cos(latitude)
        rate = (level * math.cos(azimuth), level * math.sin(azimuth), math.sin(latitude))
        # none for zero: a remainder of 1e-17 would pass for a rate that shows a coefficient
        along, across, up = (None if abs(part) < 1e-15 else part for part in rate)
        return {"specific_force": UP, "angular_rate": (along, across, up)}

    @property
    def circumstances(self) -> list[Option]:
        """The azimuth of the outer axis and the latitude."""
        return [Option("azimuth_deg", self.azimuth_deg), Option("latitude_deg", self.latitude_deg)]
