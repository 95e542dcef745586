"""Scalar calibration of a magnetometer triad."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, final

from acalx.models.prior import noise_of, require_told
from acalx.models.sensor_model import SensorModel
from acalx.models.vectors import Magnitude
from acalx.sensors import MagnetometerTriad
from acalx.sensors.base import suits

__all__ = ["ScalarMagnetometer"]


@final
@dataclass(frozen=True)
class ScalarMagnetometer(SensorModel):
    """Nine parameters of a magnetometer triad, from the magnitude of the field: an ellipsoid's.

    In a field of the direction b in sensor axes the triad reads, in units of the field's
    magnitude,

        W = bias + (I + diag(scale) + N) b,   N = [[0, xy, xz], [0, 0, 0], [0, zy, 0]],

    where the biases hold hard iron, and scale and N soft iron too. The residual J of the
    magnitude is then, to first order in the parameters X,

        J = h X,   h = (bx, by, bz, bx^2, by^2, bz^2, bx by, bx bz, bz by).

    The stand must say where the field is, as ``stand.dip_deg=65`` does for the two-axis table.
    Standard deviations come out in the units of the parameters where `noise_field` is told, otherwise in units of the
    standard deviation of J.

    Parameters
    ----------
    noise_field : float, magnitudes of the field, optional
        Standard deviation of a reading. None: it is 1, and results are in units of it.
    prior : mapping of str to float
        As of `Compared`; it takes a noise that is told.

    Raises
    ------
    ArgumentError
        A noise that is not positive; a prior as of `Compared`, or without a noise.

    Source: Gebre-Egziabher, Elkaim, Powell, Parkinson, J. Aerosp. Eng. 19(2), 2006, 87-102, for
    the ellipsoid.
    """

    usual: ClassVar[Mapping[str, Any]] = suits(stand="magnetic_table", criterion=None, errors="fine", n=9)
    tells_noise: ClassVar[str] = "noise_field"
    noise_field: float | None = None

    def __post_init__(self) -> None:
        noise = noise_of("noise_field", self.noise_field)
        self._compare(MagnetometerTriad(noise_field=noise), Magnitude("magnetic_field"))
        require_told("noise_field", self.noise_field, self.prior, 2e-3)
