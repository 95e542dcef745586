"""An inertial measurement unit: three accelerometers and three gyros."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, final

from acalx.errors import ArgumentError
from acalx.options import keep
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import EARTH_RATE
from acalx.sensors.base import Channel, suits
from acalx.sensors.polynomial import Polynomial, Term, require_noise

__all__ = ["IMU"]

_G = 9.80665
_RATE = math.degrees(EARTH_RATE)  # stands give rates in units of the Earth's
_TURNING = EARTH_RATE**2 / _G  # 1 m in a rotation at that rate, in g


@final
@dataclass(frozen=True)
class IMU(Polynomial):
    """Three accelerometers and three gyros, 43 parameters, or 45.

    With the specific force a in g, the angular rate w and its change w' in sensor axes, accelerometer and gyro i read

        A_i = bias_i + (1 + scale_i) a_i + misalignment_ij a_j + quadratic_i a_i^2 + (w x (w x r_i) + w' x r_i)_i,
        G_i = bias_i + (1 + scale_i) w_i + misalignment_ij w_j + g_sensitivity_ij a_j,   in g and in deg/s,

    with the lever arm r_i of each accelerometer from the origin in m, the size effect.

    Parameters
    ----------
    arms : sequence of str
        Components of the lever arms that are estimated, as ``xy`` that of the x accelerometer along y. On a table whose
        inner axis is z no rate shows ``xz`` and ``yz``: what both rates do to them cancels, so they are left out.
    accel_noise_g, gyro_noise_deg_s : float
        Standard deviations of a reading of an accelerometer and a gyro. How precise one is beside the other decides
        between positions and turns, so there is no 1 for a default: these are of a MEMS unit, averaged over a second.

    Raises
    ------
    ArgumentError
        Arms that there are not, a noise that is not positive.

    Source: IEEE Std 1293-2018 and 1431-2004 for the terms; Titterton and Weston, Strapdown Inertial Navigation
    Technology (2004), chapter 8, for the size effect.
    """

    usual: ClassVar[Mapping[str, Any]] = suits(
        stand="two_axis_rate_table", optimizer="gradient", n=24, **{"optimizer.starts": 24}
    )
    arms: Sequence[str] = ("xx", "xy", "yx", "yy", "zx", "zy", "zz")
    accel_noise_g: float = 1e-4
    gyro_noise_deg_s: float = 0.01

    def __post_init__(self) -> None:
        known, given = [own + axis for own in "xyz" for axis in "xyz"], self.arms
        if isinstance(given, str) or not isinstance(given, Sequence) or not set(given) <= set(known):
            raise ArgumentError.of("arms", given, f"give some of {', '.join(known)}", ["xx", "yy", "zz"])
        keep(self, "arms")
        require_noise("accel_noise_g", self.accel_noise_g)
        require_noise("gyro_noise_deg_s", self.gyro_noise_deg_s)

    @property
    def kind(self) -> str:
        """One unit: its accelerometers and gyros are read together."""
        return "imu"

    @property
    def parts(self) -> Mapping[str, Sequence[int]]:
        """Accelerometers and gyros, which schemes may design for one after the other."""
        return {"accels": range(3), "gyros": range(3, 6)}

    @property
    def senses(self) -> tuple[str, ...]:
        """The specific force and the rate, where the unit does not turn ever faster."""
        return ("specific_force", "angular_rate")

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """ax, ay, az in g, then gx, gy, gz in deg/s."""
        accels = (Channel(f"a{axis}", "g", self.accel_noise_g) for axis in "xyz")
        return (*accels, *(Channel(f"g{axis}", "deg/s", self.gyro_noise_deg_s) for axis in "xyz"))

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """Of each accelerometer and then of each gyro."""
        accels = (term for k, own in enumerate("xyz") for term in _accel(own, k, self.arms))
        return (*accels, *(term for k, own in enumerate("xyz") for term in _gyro(own, k + 3)))


def _accel(own: str, channel: int, arms: Sequence[str]) -> list[Term]:
    """Bias, scale, misalignments, the square, and the lever arm along the own axis i and the next two, j and k."""
    j, k = tuple("xyzxy"[channel + 1 : channel + 3])

    def named(name: str, group: str, unit: str, scatter: float) -> Parameter:
        return Parameter(f"accel_{own}_{name}", f"accel_{group}", unit, scatter=scatter)

    def of_arm(axis: str, product: str, factor: float) -> list[Term]:
        arm = named(f"arm_{axis}", "arm", "m", 0.01)
        return [Term(arm, product, factor, channel)] if own + axis in arms else []

    return [
        Term(None, f"f{own}", 1.0, channel),
        Term(named("bias", "bias", "g", 0.01), "", 1.0, channel),
        Term(named("scale", "scale", "1", 0.01), f"f{own}", 1.0, channel),
        *(Term(named(f"misalignment_{a}", "misalignment", "rad", 0.01), f"f{a}", 1.0, channel) for a in (j, k)),
        Term(named("quadratic", "quadratic", "1/g", 1e-3), f"f{own} f{own}", 1.0, channel),
        *(term for axis in (j, k) for term in of_arm(own, f"w{axis} w{axis}", -_TURNING)),
        *(term for axis in (j, k) for term in of_arm(axis, f"w{own} w{axis}", _TURNING)),
        *of_arm(j, f"a{k}", -1.0 / _G),
        *of_arm(k, f"a{j}", 1.0 / _G),
    ]


def _gyro(own: str, channel: int) -> list[Term]:
    """Bias, scale, misalignments, and what the specific force does to it."""

    def named(name: str, group: str, unit: str, scatter: float) -> Parameter:
        return Parameter(f"gyro_{own}_{name}", f"gyro_{group}", unit, scatter=scatter)

    others = [axis for axis in "xyz" if axis != own]
    g_sensitivity = (named(f"g_sensitivity_{axis}", "g_sensitivity", "deg/s/g", 0.05) for axis in "xyz")
    return [
        Term(None, f"w{own}", _RATE, channel),
        Term(named("bias", "bias", "deg/s", 0.5), "", 1.0, channel),
        Term(named("scale", "scale", "1", 0.01), f"w{own}", _RATE, channel),
        *(Term(named(f"misalignment_{a}", "misalignment", "rad", 0.01), f"w{a}", _RATE, channel) for a in others),
        *(Term(one, f"f{axis}", 1.0, channel) for axis, one in zip("xyz", g_sensitivity, strict=True)),
    ]
