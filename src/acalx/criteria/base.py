"""The interface of a criterion: a loss of the information matrix, and its gradient."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np

from acalx.arrays import Array
from acalx.information import Information, Parameter

__all__ = ["Ceiling", "Criterion", "Terms"]


class Criterion(ABC):
    """What makes one program better than another; smaller is better.

    A new criterion gives `loss`; its gradient is then numerical until it is given exactly, and
    every optimizer takes it at once. Concrete criteria are frozen dataclasses. Criteria
    multiply and take powers: ``D() * Inequality("bias") ** 0.1``.
    """

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

    def curvature(self, information: Information, directions: Array) -> Array:
        """Second derivatives of the loss along symmetric matrices: (q, p, p) to (q, q).

        The default differentiates `gradient` numerically, by central differences.

        Parameters
        ----------
        information : Information
            With one matrix (p, p).
        directions : array (q, p, p)
        """
        root = np.linalg.inv(np.linalg.cholesky(information.matrix))
        sizes = np.linalg.norm(root @ directions @ root.T, axis=(-2, -1))[:, None, None]
        moves = 1e-4 / sizes * directions
        moved = Information(information.matrix + np.stack([moves, -moves]), information.parameters)
        above, below = self.gradient(moved)
        slopes = (above - below) / (2e-4 / sizes)
        curvature = np.einsum("iab,jab->ij", directions, slopes)
        return np.asarray(0.5 * (curvature + curvature.T))

    @property
    def label(self) -> str:
        """Its name in messages."""
        return type(self).__name__

    @property
    def objectives(self) -> tuple[Criterion, ...]:
        """What is to be made small: this one criterion, or several (see `acalx.criteria.Objectives`)."""
        return (self,)

    @property
    def objective_names(self) -> tuple[str, ...]:
        """What to call the objectives in tables and files."""
        return (self.label,)

    def check(self, parameters: tuple[Parameter, ...]) -> None:  # noqa: B027 - most fit every model
        """Raise ArgumentError where the criterion does not fit a model with these parameters."""

    def degree(self, p: int) -> float | None:
        """The k for which the loss of c M is that of M less k log c, where exp(-loss / k) is concave.

        Such a criterion of p parameters is an information function, and programs can be
        bounded by it (see `acalx.certificate`). None, the default: no bound.
        """
        return None

    def support(self, information: Information, multiplier: Array | None) -> Array:
        """S with which h S h' bounds all programs (see `acalx.certificate`), scaled as it comes.

        The default is minus the gradient at the optimum.

        Parameters
        ----------
        information : Information
            With one matrix (p, p), at or near the optimum.
        multiplier : array or None
            What held a `Ceiling` there.
        """
        return -self.gradient(information)

    def least_loss(self, support: Array, at: Information) -> Array:
        """Least loss of any information M with trace(support M) <= 1.

        The default is for the support that is minus the gradient at `at`, over the degree: by
        concavity it is the loss there.

        Parameters
        ----------
        support : array (p, p)
            Positive semidefinite.
        at : Information
            With one matrix, at or near the optimum.
        """
        return self.loss(at)

    def convex(self, matrix: Any, factor: Array) -> Any:
        """A cvxpy expression that is least where the loss is; None, the default, where there is none.

        The information is factor @ matrix @ factor.T. A form in which the factor is taken out,
        up to a positive factor or a constant, is more accurate where the parameters differ much
        in how well they are seen.

        Parameters
        ----------
        matrix : cvxpy.Variable (p, p)
            Symmetric, not far from the unit matrix.
        factor : array (p, p)
            Lower triangular.

        Returns
        -------
        cvxpy.Expression or None
            A scalar, convex by cvxpy's rules.
        """
        return None

    def terms(self) -> Terms:
        """The loss taken apart for optimizers that need smooth functions."""
        return Terms(smooth=((1.0, self),))

    def __mul__(self, other: Criterion) -> Criterion:
        from acalx.criteria.product import Product

        return Product((self, other))

    def __pow__(self, exponent: float) -> Criterion:
        from acalx.criteria.product import Product

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

    def inequality_matrix(self, p: int) -> Array | None:
        """C (p, p), where the value is the least t with C <= t M as a matrix; None, the default, where it is not."""
        return None

    def smoothed(self) -> Criterion | None:
        """A smooth criterion of the same degree whose best measure is nearly the best for this one; None: none.

        A bound is computed from that measure and its support where there is no `inequality_matrix`.
        """
        return None

    def terms(self) -> Terms:
        """One ceiling, nothing smooth."""
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
