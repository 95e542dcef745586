"""Calibration of a gyro triad on a rate table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, final

from acalx.models.comparisons import Outputs
from acalx.models.prior import noise_of, require_told
from acalx.models.sensor_model import SensorModel
from acalx.sensors import GyroTriad
from acalx.sensors.base import suits

__all__ = ["GyroRateTable"]


@final
@dataclass(frozen=True)
class GyroRateTable(SensorModel):
    """Twenty-one parameters of a gyro triad: bias, scale, misalignment and g-sensitivity.

    With the angular rate w in deg/s and the specific force a in g, both in sensor axes, the
    gyro along axis i reads, in deg/s,

        W_i = bias_i + (1 + scale_i) w_i + misalignment_ij w_j + misalignment_ik w_k
            + g_sensitivity_ix ax + g_sensitivity_iy ay + g_sensitivity_iz az.

    On a table at rest the rate is too small to show scale and misalignment: use the stand
    ``rate_table``, whose rate is a setting of each position.

    Parameters
    ----------
    noise_deg_s : float, deg/s, optional
        Standard deviation of a reading. None: it is 1, and results are in units of it.
    prior : mapping of str to float
        As of `Compared`; it takes a noise that is told.

    Raises
    ------
    ArgumentError
        A noise that is not positive; a prior as of `Compared`, or without a noise.

    Source: IEEE Std 1431-2004 for the terms.
    """

    usual: ClassVar[Mapping[str, Any]] = suits(stand="rate_table", n=12)
    tells_noise: ClassVar[str] = "noise_deg_s"
    noise_deg_s: float | None = None

    def __post_init__(self) -> None:
        self._compare(GyroTriad(noise_deg_s=noise_of("noise_deg_s", self.noise_deg_s)), Outputs())
        require_told("noise_deg_s", self.noise_deg_s, self.prior, 0.01)
