"""Products of criteria with exponents, such as the fair compromise."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.arrays import Array
from acalx.criteria.base import Criterion, Terms
from acalx.errors import ArgumentError
from acalx.information import Information, Parameter

__all__ = ["Product"]


@final
@dataclass(frozen=True)
class Product(Criterion):
    """Product of the values of criteria, each to a power: a weighted sum of their losses.

    The fair compromise is D times the inequality of each group to the power 0.1.

    Parameters
    ----------
    criteria : sequence of Criterion
    exponents : sequence of float, optional
        One positive exponent a criterion; 1 for each where none are given.

    Raises
    ------
    ArgumentError
        No criteria, another number of exponents than of criteria, an exponent that is not positive.

    Source: Egorov, Kiryachenko, Popov (2021) for the fair compromise.
    """

    criteria: Sequence[Criterion]
    exponents: Sequence[float] | None = None

    def __post_init__(self) -> None:
        criteria = tuple(self.criteria) if isinstance(self.criteria, Iterable) else ()
        if not criteria or not all(isinstance(criterion, Criterion) for criterion in criteria):
            raise ArgumentError(f"criteria={self.criteria}: a product takes a list of one or more criteria")
        if not isinstance(self.exponents, Iterable | None):
            raise ArgumentError(f"exponents={self.exponents}: a product takes a list of exponents, one a criterion")
        exponents = (1.0,) * len(criteria) if self.exponents is None else tuple(self.exponents)
        if len(exponents) != len(criteria):
            raise ArgumentError(f"a product of {len(criteria)} criteria takes as many exponents, got {len(exponents)}")
        for exponent in exponents:
            if not (isinstance(exponent, (int, float)) and math.isfinite(exponent) and exponent > 0):
                raise ArgumentError(f"exponent {exponent}: the exponents of a product are positive numbers")
        object.__setattr__(self, "criteria", criteria)
        object.__setattr__(self, "exponents", exponents)

    def _factors(self) -> list[tuple[float, Criterion]]:
        assert self.exponents is not None  # set at construction
        return list(zip(self.exponents, self.criteria, strict=True))

    def check(self, parameters: tuple[Parameter, ...]) -> None:
        """Each factor's own check."""
        for criterion in self.criteria:
            criterion.check(parameters)

    def loss(self, information: Information) -> Array:
        """Weighted sum of the losses."""
        return np.asarray(sum(exponent * criterion.loss(information) for exponent, criterion in self._factors()))

    def gradient(self, information: Information) -> Array:
        """Weighted sum of the gradients."""
        return np.asarray(sum(exponent * criterion.gradient(information) for exponent, criterion in self._factors()))

    def curvature(self, information: Information, directions: Array) -> Array:
        """Weighted sum of the curvatures."""
        each = [exponent * criterion.curvature(information, directions) for exponent, criterion in self._factors()]
        return np.asarray(sum(each))

    def degree(self, p: int) -> float | None:
        """Weighted sum of the degrees, where every factor is smooth and has one.

        A geometric mean of concave functions is concave.
        """
        degrees = [criterion.degree(p) for criterion in self.criteria]
        if self.terms().ceilings or any(degree is None for degree in degrees):
            return None
        return sum(exponent * (degree or 0.0) for (exponent, _), degree in zip(self._factors(), degrees, strict=True))

    def terms(self) -> Terms:
        """The terms of all the factors."""
        smooth: list[tuple[float, Criterion]] = []
        ceilings = []
        for exponent, criterion in self._factors():
            terms = criterion.terms()
            smooth += [(exponent * weight, part) for weight, part in terms.smooth]
            ceilings += [(exponent * weight, part) for weight, part in terms.ceilings]
        return Terms(tuple(smooth), tuple(ceilings))
