"""All the sensors of an inertial platform."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, final

from acalx.errors import ArgumentError
from acalx.models.base import Model
from acalx.models.compared import as_model
from acalx.models.composite import Composite
from acalx.options import keep
from acalx.sensors import PlatformAccel, PlatformGyro
from acalx.sensors.base import suits
from acalx.sensors.polynomial import three_of

__all__ = ["Platform"]

_SENSORS = ("gyros", "accels")


@final
@dataclass(frozen=True)
class Platform(Composite):
    """Three gyros and three accelerometers of a gimballed platform: 36 error coefficients.

    Each position gives six readings; see `PlatformGyro` and `PlatformAccel` for their
    coefficients. The information is block-diagonal, so its log det is the sum of the six.

    Parameters
    ----------
    sensors : sequence of str
        Which of ``gyros`` and ``accels`` there are; only the three gyros are 24 coefficients,
        only the three accelerometers 12.
    second_order : pair of str
        Terms of second order of the gyros.
    gyro_noise_deg_h : float or three of them, deg/h
    accel_noise_g : float or three of them, g
        Standard deviations of the readings of the x, y and z sensor. With 1, the default,
        determinants are in unit inputs: g and the Earth's rate. The paper has 0.001 deg/h and
        1e-6 m/s^2, which is 1.02e-7 g.

    Raises
    ------
    ArgumentError
        Unknown sensors or terms, a noise that is not positive.

    Source: Wang, Wang, Shen, Qin, J. Chin. Inert. Technol. 24(5), 2016, 583-588.
    """

    usual: ClassVar[Mapping[str, Any]] = suits(stand="platform_gimbals", errors="platform", optimizer="gradient", n=16)
    sensors: Sequence[str] = _SENSORS
    second_order: Sequence[str] = ("IS", "SS")
    gyro_noise_deg_h: float | Sequence[float] = 1.0
    accel_noise_g: float | Sequence[float] = 1.0

    def __post_init__(self) -> None:
        given = self.sensors
        if isinstance(given, str) or not isinstance(given, Sequence) or not given or not set(given) <= set(_SENSORS):
            raise ArgumentError.of("sensors", given, f"give one or both of {', '.join(_SENSORS)}", list(_SENSORS))
        _ = self.models  # built once here so that bad options are refused at construction
        keep(self, "sensors", "second_order", "gyro_noise_deg_h", "accel_noise_g")

    @cached_property
    def models(self) -> tuple[Model, ...]:
        """The x, y and z gyro, then the x, y and z accelerometer."""
        gyro_noise = three_of("gyro_noise_deg_h", self.gyro_noise_deg_h)
        accel_noise = three_of("accel_noise_g", self.accel_noise_g)
        gyros = [as_model(PlatformGyro(axis, self.second_order, gyro_noise[k])) for k, axis in enumerate("xyz")]
        accels = [as_model(PlatformAccel(axis, accel_noise[k])) for k, axis in enumerate("xyz")]
        return (*(gyros if "gyros" in self.sensors else []), *(accels if "accels" in self.sensors else []))
