"""Scalar calibration of a magnetometer triad."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import final

from acalx.models.polynomial import Polynomial, Term
from acalx.quantities.parameter import Parameter

__all__ = ["ScalarMagnetometer"]

_PRODUCTS = {
    **{f"bias_{axis}": axis for axis in "xyz"},
    **{f"scale_{axis}": 2 * axis for axis in "xyz"},
    **{f"nonorthogonality_{pair}": pair for pair in ("xy", "xz", "zy")},
}


@final
@dataclass(frozen=True)
class ScalarMagnetometer(Polynomial):
    """Nine parameters of a magnetometer triad, from the magnitude of the field: an ellipsoid's.

    In a field of the direction b in sensor axes the triad reads, in units of the field's
    magnitude,

        W = bias + (I + diag(scale) + N) b,   N = [[0, xy, xz], [0, 0, 0], [0, zy, 0]],

    where the biases hold hard iron, and scale and N soft iron too. The residual J of the
    magnitude is then, to first order in the parameters X,

        J = h X,   h = (bx, by, bz, bx^2, by^2, bz^2, bx by, bx bz, bz by).

    The stand must say where the field is, as ``stand.dip_deg=65`` does for the two-axis table.
    Standard deviations come out in units of the standard deviation of J.

    Source: Gebre-Egziabher, Elkaim, Powell, Parkinson, J. Aerosp. Eng. 19(2), 2006, 87-102, for
    the ellipsoid.
    """

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """Biases in units of the field, relative scale errors, non-orthogonalities in rad."""
        units = {"bias": "field", "scale": "1", "nonorthogonality": "rad"}
        return tuple(
            Term(
                Parameter(name, group := name.split("_")[0], units[group]),
                tuple(("magnetic_field", "xyz".index(axis)) for axis in product),
            )
            for name, product in _PRODUCTS.items()
        )
