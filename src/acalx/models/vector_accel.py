"""Vector calibration of an accelerometer triad, its orientation known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, final

from acalx.models.comparisons import Outputs
from acalx.models.sensor_model import SensorModel
from acalx.sensors import AccelTriad
from acalx.sensors.base import suits
from acalx.sensors.polynomial import require_noise

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
    noise_g : float, g
        Standard deviation of a reading. With 1, the default, standard deviations are in units
        of it.
    prior : mapping of str to float
        As of `Compared`.

    Raises
    ------
    ArgumentError
        A noise that is not positive.

    Source: IEEE Std 1293-2018, the static model without terms of higher order.
    """

    usual: ClassVar[Mapping[str, Any]] = suits(n=6)
    noise_g: float = 1.0

    def __post_init__(self) -> None:
        require_noise("noise_g", self.noise_g)
        self._compare(AccelTriad("full", noise_g=self.noise_g), Outputs())
