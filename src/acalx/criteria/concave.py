"""Criteria by which all programs can be bounded: those that are concave in the information."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from acalx.criteria.base import Criterion, Product
from acalx.numerics.arrays import Array
from acalx.quantities.information import Information

__all__ = ["Concave", "concave_of"]


class Concave(Criterion):
    """A criterion of which exp(-loss / degree) is concave in the information and of degree one.

    Such a function is an information function: its tangents bound all programs (see
    `acalx.bounds`), and optimal weights of candidates are a convex problem. A new one gives
    `degree`; `convex` too where cvxpy is to solve for the weights. A kink asks for more: `support`
    and `least_loss`, and one of `inequality_matrix` and `smoothed`.

    Source: Pukelsheim, Optimal Design of Experiments (1993), chapter 5.
    """

    _bounds: ClassVar[bool] = True

    @abstractmethod
    def degree(self, p: int) -> float:
        """The k for which the loss of c M is that of M less k log c, with p parameters."""

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

    def support(self, information: Information, multiplier: Array | None) -> Array:
        """S with which h S h' bounds all programs (see `acalx.bounds.bound`), scaled as it comes.

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

    def inequality_matrix(self, p: int) -> Array | None:
        """C (p, p), where the value is the least t with C <= t M as a matrix; None, the default, where it is not."""
        return None

    def smoothed(self) -> Concave | None:
        """A smooth criterion of the same degree whose best measure is nearly the best for this one; None: none.

        A bound is computed from that measure and its support where there is no `inequality_matrix`.
        """
        return None


def concave_of(criterion: Criterion) -> Concave | None:
    """The criterion as one by which programs can be bounded; None where it is not.

    A product of such criteria is one too: geometric means of concave functions are concave.
    """
    if isinstance(criterion, Concave):
        return criterion
    if not isinstance(criterion, Product) or criterion.terms().ceilings:
        return None
    factors = [(exponent, concave_of(factor)) for exponent, factor in criterion.factors]
    known = tuple((exponent, factor) for exponent, factor in factors if factor is not None)
    return _ConcaveProduct(criterion, known) if len(known) == len(factors) else None


@final
@dataclass(frozen=True)
class _ConcaveProduct(Concave):
    """A product all of whose factors are concave: degrees and second derivatives add up as the losses do."""

    product: Product
    factors: tuple[tuple[float, Concave], ...]

    @property
    def label(self) -> str:
        return self.product.label

    def loss(self, information: Information) -> Array:
        return self.product.loss(information)

    def gradient(self, information: Information) -> Array:
        return self.product.gradient(information)

    def curvature(self, information: Information, directions: Array) -> Array:
        each = [exponent * factor.curvature(information, directions) for exponent, factor in self.factors]
        return np.asarray(sum(each))

    def degree(self, p: int) -> float:
        return sum(exponent * factor.degree(p) for exponent, factor in self.factors)
