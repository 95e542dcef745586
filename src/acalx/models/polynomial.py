"""Models whose regressors are products of components of the stimulus, given as a table."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from acalx.errors import ArgumentError
from acalx.models.base import Model
from acalx.numerics.arrays import Array, empty_as
from acalx.options import is_number
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus

__all__ = ["Polynomial", "Term", "require_axis", "require_noise"]


@final
@dataclass(frozen=True)
class Term:
    """A parameter and the product of components of the stimulus that it multiplies.

    Parameters
    ----------
    parameter : Parameter
    factors : tuple of (quantity, component)
        As in ``(("specific_force", 0), ("specific_force", 2))`` for ax az; empty for a bias.
    factor : float
        A constant in front, which brings the product into the unit of the reading.
    """

    parameter: Parameter
    factors: tuple[tuple[str, int], ...] = ()
    factor: float = 1.0


class Polynomial(Model):
    """A sensor with one output, linear in parameters that multiply products of the stimulus.

    A new model gives `terms`, and `noise` where the reading is not in units of it; all the
    rest, exact derivatives and the degree for certificates included, follows. Several outputs
    are several such models, joined (see `acalx.models.Joined`).
    """

    @property
    @abstractmethod
    def terms(self) -> tuple[Term, ...]:
        """The p parameters with what each of them multiplies."""

    @property
    def noise(self) -> float:
        """Standard deviation of the noise of a reading, in its unit."""
        return 1.0

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters that the terms have, in their order."""
        return tuple(term.parameter for term in self.terms)

    @cached_property
    def needs(self) -> tuple[str, ...]:
        """The quantities that occur in the terms."""
        return tuple(dict.fromkeys(quantity for term in self.terms for quantity, _ in term.factors))

    @property
    def degree(self) -> int:
        """Degree of the rows in the stimulus: the number of factors of the longest product."""
        return max(len(term.factors) for term in self.terms)

    def regressors(self, stimulus: Stimulus) -> Array:
        """Rows h, shape (..., n, 1, p), over the noise."""
        first = _component(stimulus, self.needs[0], 0)
        rows = empty_as(first, (*first.shape, 1, len(self.terms)))
        for k, term in enumerate(self.terms):
            rows[..., 0, k] = term.factor / self.noise
            for quantity, component in term.factors:
                rows[..., 0, k] *= _component(stimulus, quantity, component)
        return rows

    def derivative(self, stimulus: Stimulus) -> Stimulus:
        """Derivatives of the rows with respect to each quantity, (..., n, 1, p, 3)."""
        first = _component(stimulus, self.needs[0], 0)
        shape = (*first.shape, 1, len(self.terms), 3)
        derivatives = {name: empty_as(first, shape) for name in self.needs}
        for rows in derivatives.values():
            rows[...] = 0.0
        for k, term in enumerate(self.terms):
            for i, (quantity, component) in enumerate(term.factors):  # the product rule
                product = np.full(first.shape, term.factor / self.noise)
                for other in term.factors[:i] + term.factors[i + 1 :]:
                    product *= _component(stimulus, *other)
                derivatives[quantity][..., 0, k, component] += product
        return Stimulus(**derivatives)


def require_noise(name: str, value: object) -> float:
    """A standard deviation as a number, or ArgumentError."""
    if not is_number(value) or value <= 0:
        raise ArgumentError.of(name, value, "a standard deviation is a positive number")
    return float(value)


def require_axis(name: str, value: object) -> int:
    """Number of an axis given by its letter, or ArgumentError."""
    if not isinstance(value, str) or value not in ("x", "y", "z"):
        raise ArgumentError.of(name, value, "an axis is x, y or z")
    return "xyz".index(value)


def _component(stimulus: Stimulus, quantity: str, component: int) -> Array:
    return np.asarray(getattr(stimulus, quantity)[..., component])
