"""The interface of a criterion, a loss of the information matrix with its gradient, and products of criteria."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from acalx.errors import ArgumentError, PluginError
from acalx.numerics.arrays import Array
from acalx.options import is_number
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter

__all__ = ["Ceiling", "Criterion", "Product", "Terms"]


class Criterion(ABC):
    """What makes one program better than another; smaller is better.

    A new criterion gives `loss`; its gradient is then numerical until it is given exactly, and
    every optimizer takes it at once. Concrete criteria are frozen dataclasses. Criteria
    multiply and take powers: ``D() * Inequality("bias") ** 0.1``. One by which programs can be
    bounded derives from `acalx.criteria.Concave` and gives its degree.

    Raises
    ------
    PluginError
        As soon as a class is defined that has a `degree` and is not `Concave`: it would be without the bound
        that its author had in mind.
    """

    _bounds: ClassVar[bool] = False  # whether a class is Concave, which is built on this one

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if hasattr(cls, "degree") and not cls._bounds:
            raise PluginError(
                f"{cls.__name__} has a degree, by which programs are bounded: derive it from acalx.criteria.Concave"
            )

    @abstractmethod
    def loss(self, information: Information) -> Array:
        """Logarithm of the published value, for each program of the stack.

        Parameters
        ----------
        information : Information
            With matrices (..., p, p), none of them singular.

        Returns
        -------
        array (...)
        """

    def gradient(self, information: Information) -> Array:
        """Gradient G of the loss with respect to the matrix: dloss = trace(G dM), (..., p, p).

        The default differentiates `loss` numerically in the p (p + 1) / 2 entries of the matrix
        by fourth-order differences. It does so in coordinates in which the matrix is the unit
        matrix, so that no step leaves the positive definite ones and scales don't matter.
        """
        factor = np.linalg.cholesky(information.matrix)
        p = factor.shape[-1]
        rows, columns = np.triu_indices(p)
        directions = np.zeros((len(rows), p, p))
        directions[range(len(rows)), rows, columns] = 1.0
        directions = 0.5 * (directions + directions.swapaxes(-1, -2))
        steps = 1e-3 * np.array([-2.0, -1.0, 1.0, 2.0])
        weights = np.array([1.0, -8.0, 8.0, -1.0]) / 12e-3
        whitened = np.eye(p) + steps[:, None, None, None] * directions
        factor = factor[..., None, None, :, :]
        losses = self.loss(Information(factor @ whitened @ factor.swapaxes(-1, -2), information.parameters))
        # within a step of a singular matrix there is no gradient to be had: zero, as at one
        near = np.any(np.isposinf(losses), axis=(-2, -1), keepdims=True)
        slopes = (weights[:, None] * np.where(near, 0.0, losses)).sum(axis=-2)
        gradient = np.zeros(information.matrix.shape)
        gradient[..., rows, columns] = slopes
        gradient[..., columns, rows] = slopes
        inverse = np.linalg.inv(factor[..., 0, 0, :, :])
        return np.asarray(inverse.swapaxes(-1, -2) @ gradient @ inverse)

    @property
    def label(self) -> str:
        """What messages and tables call the criterion; the name of its class."""
        return type(self).__name__

    def check(self, parameters: tuple[Parameter, ...]) -> None:  # noqa: B027 - most fit every model
        """Raise ArgumentError where the criterion does not fit a model with these parameters."""

    def terms(self) -> Terms:
        """The loss taken apart for optimizers that need smooth functions."""
        return Terms(smooth=((1.0, self),))

    def __mul__(self, other: Criterion) -> Product:
        return Product((self, other))

    def __pow__(self, exponent: float) -> Product:
        return Product((self,), (exponent,))


class Ceiling(Criterion):
    """A criterion that is a maximum, and so has kinks just where programs are good.

    Its value is the least t that lies on or above all the things of which it is the maximum.
    Optimizers that need smooth functions take log t as a further variable and hold it above
    them by an augmented Lagrangian, whose terms the criterion gives here.
    """

    @property
    @abstractmethod
    def log_floor(self) -> float:
        """Least value of log t; -inf where there is none."""

    @abstractmethod
    def start(self, parameters: tuple[Parameter, ...], stack: tuple[int, ...]) -> Array:
        """First multipliers, zeros of the shape (*stack, ...) that `hold` takes and gives."""

    @abstractmethod
    def hold(
        self, information: Information, log_t: Array, multiplier: Array, penalty: Array
    ) -> tuple[Array, Array, Array, Array]:
        """Augmented Lagrangian of holding t above the maximum.

        Parameters
        ----------
        information : Information
            With matrices (..., p, p).
        log_t : array (...)
        multiplier : array (..., *shape of one multiplier)
        penalty : array (...)

        Returns
        -------
        value : array (...)
        gradient : array (..., p, p)
            With respect to the information matrix.
        slope : array (...)
            With respect to log_t.
        multiplier : array
            The next multiplier.
        """

    def terms(self) -> Terms:
        """The loss as this one ceiling, without a smooth part."""
        return Terms(ceilings=((1.0, self),))


@dataclass(frozen=True)
class Terms:
    """A loss as a weighted sum of smooth criteria and of ceilings.

    Parameters
    ----------
    smooth, ceilings : tuple of (weight, criterion)
    """

    smooth: tuple[tuple[float, Criterion], ...] = ()
    ceilings: tuple[tuple[float, Ceiling], ...] = ()


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
            raise ArgumentError.of("criteria", self.criteria, "a product takes a list of one or more criteria")
        given = (1.0,) * len(criteria) if self.exponents is None else self.exponents
        exponents = tuple(given) if isinstance(given, Iterable) and not isinstance(given, str) else ()
        if len(exponents) != len(criteria) or not all(is_number(each) and each > 0 for each in exponents):
            rule = f"a product takes a positive exponent for each criterion, {len(criteria)} of them here"
            raise ArgumentError.of("exponents", given, rule)
        object.__setattr__(self, "criteria", criteria)
        object.__setattr__(self, "exponents", exponents)

    @property
    def factors(self) -> list[tuple[float, Criterion]]:
        """The criteria that are multiplied, each behind its exponent."""
        assert self.exponents is not None  # set at construction
        return list(zip(self.exponents, self.criteria, strict=True))

    @property
    def label(self) -> str:
        """The factors with their exponents: ``D * (Inequality bias)^0.1``."""
        return " * ".join(
            criterion.label if exponent == 1.0 else f"({criterion.label})^{exponent:g}"
            for exponent, criterion in self.factors
        )

    def check(self, parameters: tuple[Parameter, ...]) -> None:
        """Raise ArgumentError where any of the factors does not fit the model."""
        for criterion in self.criteria:
            criterion.check(parameters)

    def loss(self, information: Information) -> Array:
        """Sum of the losses of the factors times their exponents, (...)."""
        return np.asarray(sum(exponent * criterion.loss(information) for exponent, criterion in self.factors))

    def gradient(self, information: Information) -> Array:
        """Sum of the gradients of the factors times their exponents, (..., p, p)."""
        return np.asarray(sum(exponent * criterion.gradient(information) for exponent, criterion in self.factors))

    def terms(self) -> Terms:
        """The terms of all the factors, each weight times the factor's exponent."""
        smooth: list[tuple[float, Criterion]] = []
        ceilings = []
        for exponent, criterion in self.factors:
            terms = criterion.terms()
            smooth += [(exponent * weight, part) for weight, part in terms.smooth]
            ceilings += [(exponent * weight, part) for weight, part in terms.ceilings]
        return Terms(tuple(smooth), tuple(ceilings))
