"""Scalar calibration of an accelerometer triad whose scale factors are not linear."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import final

from acalx.models.polynomial import Polynomial, Term
from acalx.models.scalar_accel import ScalarAccel
from acalx.quantities.parameter import Parameter

__all__ = ["ScalarAccelQuadratic"]


@final
@dataclass(frozen=True)
class ScalarAccelQuadratic(Polynomial):
    """The nine parameters of `ScalarAccel` and a second-order term of each accelerometer.

    The triad reads W_i + quadratic_i e_i^2, in g, with W as in `ScalarAccel` and the vertical e
    in sensor axes. The residual of the magnitude is then, to first order in the parameters,

        J = h X,   h = (ex, ey, ez, ex^2, ey^2, ez^2, ex ey, ex ez, ez ey, ex^3, ey^3, ez^3).

    Standard deviations come out in units of the standard deviation of J.

    Source: Egorov, Kiryachenko, Popov (2021) for the nine; the cubes follow in the same way.
    """

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """Biases, scales, non-orthogonalities, second-order terms."""
        products = [*"xyz", "xx", "yy", "zz", "xy", "xz", "zy", "xxx", "yyy", "zzz"]
        quadratic = [Parameter(f"quadratic_{axis}", "quadratic", "1/g") for axis in "xyz"]
        return tuple(
            Term(parameter, tuple(("specific_force", "xyz".index(axis)) for axis in product))
            for parameter, product in zip((*ScalarAccel().parameters, *quadratic), products, strict=True)
        )
