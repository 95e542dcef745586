"""Scalar calibration of an accelerometer triad whose scale factors are not linear."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, final

from acalx.models.sensor_model import SensorModel
from acalx.models.vectors import Magnitude
from acalx.sensors import AccelTriad
from acalx.sensors.base import suits

__all__ = ["ScalarAccelQuadratic"]


@final
@dataclass(frozen=True)
class ScalarAccelQuadratic(SensorModel):
    """The nine parameters of `ScalarAccel` and a second-order term of each accelerometer.

    The triad reads W_i + quadratic_i e_i^2, in g, with W as in `ScalarAccel` and the vertical e
    in sensor axes. The residual of the magnitude is then, to first order in the parameters,

        J = h X,   h = (ex, ey, ez, ex^2, ey^2, ez^2, ex ey, ex ez, ez ey, ex^3, ey^3, ez^3).

    Standard deviations come out in units of the standard deviation of J.

    Parameters
    ----------
    prior : mapping of str to float
        As of `Compared`, in units of the standard deviation of J.

    Source: Egorov, Kiryachenko, Popov (2021) for the nine; the cubes follow in the same way.
    """

    usual: ClassVar[Mapping[str, Any]] = suits(criterion=None, errors="fine", n=15)

    def __post_init__(self) -> None:
        self._compare(AccelTriad(order=2), Magnitude())
