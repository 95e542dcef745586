"""Vector calibration of an accelerometer triad, its orientation known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, final

from acalx.models.comparisons import Outputs
from acalx.models.prior import noise_of, require_told
from acalx.models.sensor_model import SensorModel
from acalx.sensors import AccelTriad
from acalx.sensors.base import suits

__all__ = ["VectorAccel"]


@final
@dataclass(frozen=True)
class VectorAccel(SensorModel):
    """Twelve parameters of an accelerometer triad, from three readings in known orientations.

    With the specific force a in sensor axes, in g, the accelerometer along axis i reads

        W_i = bias_i + (1 + scale_i) a_i + misalignment_ij a_j + misalignment_ik a_k.

    Unlike `ScalarAccel` it needs the attitude of the sensor as well as the readings; in return it
    gives all six misalignments, and four positions are enough.

    Parameters
    ----------
    noise_g : float, g, optional
        Standard deviation of a reading. None: it is 1, and results are in units of it.
    prior : mapping of str to float
        As of `Compared`; it takes a noise that is told.

    Raises
    ------
    ArgumentError
        A noise that is not positive; a prior as of `Compared`, or without a noise.

    Source: IEEE Std 1293-2018, the static model without terms of higher order.
    """

    usual: ClassVar[Mapping[str, Any]] = suits(n=6)
    tells_noise: ClassVar[str] = "noise_g"
    noise_g: float | None = None

    def __post_init__(self) -> None:
        self._compare(AccelTriad("full", noise_g=noise_of("noise_g", self.noise_g)), Outputs())
        require_told("noise_g", self.noise_g, self.prior, 1e-4)
