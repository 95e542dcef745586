"""An inertial measurement unit: three accelerometers and three gyros."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, final

from acalx.errors import ArgumentError
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import EARTH_RATE
from acalx.sensors.base import Channel, suits
from acalx.sensors.polynomial import Polynomial, Term, require_noise
from acalx.sensors.triads import axis_terms, g_sensitivity_terms, part_terms

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
        object.__setattr__(self, "arms", tuple(arm for arm in known if arm in given))
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
        axes = list(enumerate("xyz"))
        accels = (t for k, axis in axes for t in (*axis_terms("f", "g", axis, k, 2), *self._of_arm(axis, k)))
        gyros = (t for k, a in axes for t in (*axis_terms("w", "deg/s", a, k, 1, _RATE), *g_sensitivity_terms(a, k)))
        return (*part_terms(accels, "accel_", 0), *part_terms(gyros, "gyro_", 3))

    def _of_arm(self, own: str, channel: int) -> Iterator[Term]:
        """What the lever arm along the own axis i, and the next two, j and k, adds to an accelerometer."""
        j, k = tuple("xyzxy"[channel + 1 : channel + 3])
        products = {
            own: ((f"w{j} w{j}", -_TURNING), (f"w{k} w{k}", -_TURNING)),
            j: ((f"w{own} w{j}", _TURNING), (f"a{k}", -1.0 / _G)),
            k: ((f"w{own} w{k}", _TURNING), (f"a{j}", 1.0 / _G)),
        }
        for axis in "xyz":
            if own + axis in self.arms:
                arm = Parameter(f"arm_{own}{axis}", "arm", "m", scatter=0.01)
                yield from (Term(arm, product, factor, channel) for product, factor in products[axis])
