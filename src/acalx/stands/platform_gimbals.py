"""The gimbals of an inertial platform."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from acalx.numerics.arrays import Array, components, sin_cos
from acalx.quantities.stimulus import Stimulus
from acalx.stands.base import Setting, Stand
from acalx.stands.options import angle, require_limits, require_number, require_speeds, require_steps, require_switch
from acalx.stands.zones import Zone, read_zones

__all__ = ["PlatformGimbals"]


@final
@dataclass(frozen=True)
class PlatformGimbals(Stand):
    """Turns a platform about its horizontal outer axis, then about its own inner one, and holds it there.

    The platform feels gravity and the Earth's rotation. At gamma = alpha = 0 its x axis lies
    along the outer axis and z points up; with the outer axis east, x, y, z are east, north, up. In
    platform axes

        C = Rz(alpha) Rx(gamma) = [[ca, sa cg, sa sg], [-sa, ca cg, ca sg], [0, -sg, cg]],
        a = C (0, 0, 1)  in g,   w = C (cos phi cos psi, cos phi sin psi, sin phi)  in Earth rates,

    with the latitude phi and the azimuth psi of the outer axis, from north to the east. The
    Earth's rate is `acalx.quantities.stimulus.EARTH_RATE`, 15.041 deg/h. With the outer axis north or
    south, two of three gyros have a coefficient that no position shows.

    Parameters
    ----------
    gamma_deg, alpha_deg : pair of float, degrees
        Limits of the angle of the outer and of the inner axis.
    azimuth_deg : float, degrees
        Of the outer axis: 0 is north, 90, the default, east.
    latitude_deg : float, degrees
        North is positive. The paper's is not known; the default is that of Xi'an.
    step_deg : float or pair of float, degrees, optional
        Resolution, of both angles or of each: they stop at whole multiples of it. None: anywhere.
    periodic : bool
        Whether 360 degrees more is the same setting.
    forbidden : sequence of mappings, degrees
        Boxes of settings that must not be taken, as of `TwoAxis`, by ``gamma_deg, alpha_deg``.
    forbidden_if : str or callable
        Function that says the same, as of `TwoAxis`.
    speed_deg_s : float or pair of float, degrees per second
        How fast the angles turn, all or each; for the order of visit.

    Raises
    ------
    ArgumentError
        Limits the wrong way round or not finite, a latitude beyond a pole, a step that is not
        positive.

    Source: Wang, Wang, Shen, Qin, J. Chin. Inert. Technol. 24(5), 2016, 583-588; gamma before alpha
    and the attitude at zero are printed there, the azimuth is an option of acalx.
    """

    gamma_deg: Sequence[float] = (0.0, 360.0)
    alpha_deg: Sequence[float] = (0.0, 360.0)
    azimuth_deg: float = 90.0
    latitude_deg: float = 34.25
    step_deg: float | Sequence[float | None] | None = None
    periodic: bool = True
    forbidden: Sequence[Mapping[str, Sequence[float]]] = ()
    forbidden_if: str | Callable[..., Any] | None = None
    speed_deg_s: float | Sequence[float] = 10.0

    def __post_init__(self) -> None:
        for name in ("gamma_deg", "alpha_deg"):
            object.__setattr__(self, name, require_limits(name, getattr(self, name)))
        require_number("azimuth_deg", self.azimuth_deg, -360.0, 360.0)
        require_number("latitude_deg", self.latitude_deg, -90.0, 90.0)
        _ = self._steps
        require_switch("periodic", self.periodic)
        _ = self.speeds
        _ = self.settings, self.zones  # built once here so that bad ones are refused at construction

    @cached_property
    def settings(self) -> tuple[Setting, ...]:
        """The two angles, gamma of the outer and alpha of the inner axis."""
        return (
            angle("gamma", self.gamma_deg, self._steps[0], self.periodic),
            angle("alpha", self.alpha_deg, self._steps[1], self.periodic),
        )

    @property
    def _steps(self) -> tuple[float | None, ...]:
        return require_steps("step_deg", self.step_deg, 2)

    @cached_property
    def zones(self) -> tuple[Zone, ...]:
        """The forbidden boxes, then what the function says."""
        return read_zones(self.settings, self.forbidden, self.forbidden_if)

    @property
    def speeds(self) -> Array:
        """Of both angles, in rad/s."""
        return np.array(require_speeds("speed_deg_s", self.speed_deg_s, 2))

    @property
    def frequencies(self) -> tuple[int, ...]:
        """One in each angle."""
        return (1, 1)

    @property
    def circumstances(self) -> str:
        """Azimuth and latitude."""
        return f"azimuth_deg={self.azimuth_deg:g}, latitude_deg={self.latitude_deg:g}"

    @cached_property
    def _earth_rate(self) -> tuple[float, float, float]:
        """In units of itself, along the outer axis, horizontally across it, and up."""
        latitude, azimuth = math.radians(self.latitude_deg), math.radians(self.azimuth_deg)
        # exact zeros: a remainder of 1e-17 would pass for a rate that shows a coefficient
        along, across, up = math.cos(azimuth), math.sin(azimuth), math.sin(latitude)
        level = math.cos(latitude)
        return tuple(0.0 if abs(part) < 1e-15 else part for part in (level * along, level * across, up))  # type: ignore[return-value]

    def stimulus(self, settings: Array) -> Stimulus:
        """Specific force and Earth's rate in platform axes: settings (..., n, 2) in rad."""
        (sg, sa), (cg, ca) = _split(*sin_cos(settings))
        along, across, up = self._earth_rate
        level, rest = across * cg + up * sg, up * cg - across * sg  # after the turn about the outer axis
        return Stimulus(
            specific_force=components(sa * sg, ca * sg, cg),
            angular_rate=components(ca * along + sa * level, ca * level - sa * along, rest),
        )

    @property
    def axis_errors(self) -> tuple[str, ...]:
        """Of the outer axis its azimuth and its tilt, of the inner one how far it is from square to the outer."""
        return ("outer_azimuth", "outer_tilt", "inner_squareness")

    def misaligned(self, settings: Array, errors: Array) -> Stimulus:
        """Both with the axes off by angles (..., n, 3) in rad: C = Rz(alpha) Ry(s) Rx(gamma) Ry(t) Rz(a)."""
        (sg, sa), (cg, ca) = _split(*sin_cos(settings))
        (s_azimuth, s_tilt, s_square), (c_azimuth, c_tilt, c_square) = (np.moveaxis(f, -1, 0) for f in sin_cos(errors))

        def felt(along: float, across: float, up: float) -> Array:
            x, y, z = np.array(along), np.array(across), np.array(up)
            x, y = c_azimuth * x + s_azimuth * y, c_azimuth * y - s_azimuth * x
            x, z = c_tilt * x - s_tilt * z, c_tilt * z + s_tilt * x
            y, z = cg * y + sg * z, cg * z - sg * y
            x, z = c_square * x - s_square * z, c_square * z + s_square * x
            return components(ca * x + sa * y, ca * y - sa * x, z)

        return Stimulus(specific_force=felt(0.0, 0.0, 1.0), angular_rate=felt(*self._earth_rate))

    def derivative(self, settings: Array) -> Stimulus:
        """Derivatives of both, (..., n, 3, 2)."""
        (sg, sa), (cg, ca) = _split(*sin_cos(settings))
        along, across, up = self._earth_rate
        level, rest = across * cg + up * sg, up * cg - across * sg
        zero = np.zeros_like(sg)
        force_by_gamma = components(sa * cg, ca * cg, -sg)
        force_by_alpha = components(ca * sg, -sa * sg, zero)
        rate_by_gamma = components(sa * rest, ca * rest, -level)
        rate_by_alpha = components(ca * level - sa * along, -ca * along - sa * level, zero)
        return Stimulus(
            specific_force=components(force_by_gamma, force_by_alpha),
            angular_rate=components(rate_by_gamma, rate_by_alpha),
        )

    def aim(self, directions: Array) -> Array:
        """Settings for directions of the vertical in platform axes.

        Two attitudes show the same vertical and differ in what is seen of the Earth's rate; of
        the two it is the one with gamma from 0 to 180 degrees, where the limits allow it.
        """
        x, y, z = np.moveaxis(directions, -1, 0)
        first = np.stack([np.arctan2(np.hypot(x, y), z), np.arctan2(x, y)], axis=-1)
        second = np.stack([-first[..., 0], first[..., 1] + math.pi], axis=-1)
        # upright and upside down the inner angle does not matter to the vertical
        return self.either(first, second, free=np.hypot(x, y) < 1e-12)


def _split(sin: Array, cos: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Of both angles each."""
    return (sin[..., 0], sin[..., 1]), (cos[..., 0], cos[..., 1])
