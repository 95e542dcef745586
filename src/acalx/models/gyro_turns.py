"""Calibration of a gyro triad by turns of known angle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, final

from acalx.models.comparisons import Outputs
from acalx.models.sensor_model import SensorModel
from acalx.sensors import GyroTriad
from acalx.sensors.base import suits
from acalx.sensors.polynomial import require_noise

__all__ = ["GyroTurns"]


@final
@dataclass(frozen=True)
class GyroTurns(SensorModel):
    """Twelve parameters of a gyro triad, from turns of known angle: bias, scale and misalignment.

    The gyros read, as `GyroTriad` says without g-sensitivity, the mean rate over a turn: over its time that is the
    angle by which the turntable was turned.

    Parameters
    ----------
    noise_deg_s : float, deg/s
        Standard deviation of a mean over a turn.
    prior : mapping of str to float
        As of `Compared`.

    Raises
    ------
    ArgumentError
        A noise that is not positive.

    Source: Tedaldi, Pretto, Menegatti, ICRA 2014.
    """

    usual: ClassVar[Mapping[str, Any]] = suits(stand="turntable", optimizer="gradient", n=9)
    noise_deg_s: float = 0.01

    def __post_init__(self) -> None:
        require_noise("noise_deg_s", self.noise_deg_s)
        self._compare(GyroTriad(g_sensitivity=False, noise_deg_s=self.noise_deg_s), Outputs())
