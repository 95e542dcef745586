"""Scalar calibration of an accelerometer triad whose scale factors are not linear."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, final

from acalx.models.prior import noise_of, require_told
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

    Standard deviations come out in the units of the parameters where `noise_g` is told, otherwise in units of the
    standard deviation of J.

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

    Source: Egorov, Kiryachenko, Popov (2021) for the nine; the cubes follow in the same way.
    """

    usual: ClassVar[Mapping[str, Any]] = suits(criterion=None, errors="fine", n=15)
    tells_noise: ClassVar[str] = "noise_g"
    noise_g: float | None = None

    def __post_init__(self) -> None:
        self._compare(AccelTriad(order=2, noise_g=noise_of("noise_g", self.noise_g)), Magnitude())
        require_told("noise_g", self.noise_g, self.prior, 1e-4)
