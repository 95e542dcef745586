"""The alphabetic criteria D, A and E, of the covariance K of the estimates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from acalx.criteria.base import Ceiling
from acalx.criteria.concave import Concave
from acalx.numerics.arrays import Array
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter

__all__ = ["A", "D", "E"]


@final
@dataclass(frozen=True)
class D(Concave):
    """log det K: the volume of the confidence ellipsoid of all the parameters together.

    It does not depend on the units of the parameters. Source: Wald (1943), Kiefer (1959).
    """

    def loss(self, information: Information) -> Array:
        """log det K = -log det M, of each program (...)."""
        return -information.log_det

    def gradient(self, information: Information) -> Array:
        """The derivative of -log det M, which is minus the covariance, (..., p, p)."""
        return -information.covariance

    def curvature(self, information: Information, directions: Array) -> Array:
        """trace(K D_i K D_j) for directions D_i (q, p, p): (q, q)."""
        moved = information.covariance @ directions
        q = len(moved)
        return np.asarray(moved.reshape(q, -1) @ moved.swapaxes(-1, -2).reshape(q, -1).T)

    def convex(self, matrix: Any, factor: Array) -> Any:
        """-log det of the matrix: the factor only adds a constant."""
        import cvxpy

        return -cvxpy.log_det(matrix)

    def degree(self, p: int) -> float:
        """The number of parameters p: the determinant of c M is that of M times c^p."""
        return float(p)


@final
@dataclass(frozen=True)
class A(Concave):
    """log tr K: the sum of the variances of the parameters, in the units that they have.

    Source: Chernoff (1953).
    """

    def loss(self, information: Information) -> Array:
        """Logarithm of the sum of the variances, (...)."""
        return np.asarray(np.log(information.variances.sum(axis=-1)))

    def gradient(self, information: Information) -> Array:
        """The derivative of log tr inv(M), -K K / tr K, (..., p, p)."""
        covariance = information.covariance
        trace = information.variances.sum(axis=-1)[..., None, None]
        return np.asarray(-(covariance @ covariance) / trace)

    def curvature(self, information: Information, directions: Array) -> Array:
        """2 trace(K D_i K D_j K) / tr K - trace(K D_i K) trace(K D_j K) / (tr K)^2."""
        covariance = information.covariance
        q, trace = len(directions), float(information.variances.sum())
        along = covariance @ directions
        twice = (along @ covariance).reshape(q, -1)
        slopes = np.einsum("iab,ba->i", along, covariance) / trace
        return np.asarray(2.0 * along.swapaxes(-1, -2).reshape(q, -1) @ twice.T / trace - np.outer(slopes, slopes))

    def convex(self, matrix: Any, factor: Array) -> Any:
        """tr K, in units in which it is of the order of one."""
        import cvxpy

        root = np.linalg.inv(factor)
        return cvxpy.matrix_frac(root / np.linalg.norm(root), matrix)

    def degree(self, p: int) -> float:
        """1: variances fall as the information grows."""
        return 1.0


@final
@dataclass(frozen=True)
class E(Ceiling, Concave):
    """log of the largest eigenvalue of K: the variance of the worst combination of parameters.

    Source: Ehrenfeld (1955).
    """

    def loss(self, information: Information) -> Array:
        """Minus the logarithm of the smallest eigenvalue of M, (...); inf where there is none above zero."""
        smallest = information.smallest_eigenvalue
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(smallest > 0, -np.log(smallest), np.inf)

    def gradient(self, information: Information) -> Array:
        """-v v' / mu, with mu the smallest eigenvalue of M and v its eigenvector."""
        worst, smallest = information.weakest, information.smallest_eigenvalue[..., None, None]
        return np.asarray(-worst[..., :, None] * worst[..., None, :] / smallest)

    def convex(self, matrix: Any, factor: Array) -> Any:
        """Minus the smallest eigenvalue of M, in units in which it is of the order of one."""
        import cvxpy

        root = np.linalg.inv(factor)
        units = 2.0 ** np.round(np.log2(np.linalg.norm(root)))  # by a power of two no digit changes
        return -cvxpy.lambda_min((units * factor) @ matrix @ (units * factor).T)

    def degree(self, p: int) -> float:
        """1: variances fall as the information grows."""
        return 1.0

    def least_loss(self, support: Array, at: Information) -> Array:
        """log trace of the support: of all M with trace(support M) <= 1 the least eigenvalue is largest for I."""
        return np.asarray(np.log(np.trace(support)))

    def support(self, information: Information, multiplier: Array | None) -> Array:
        """The multiplier: at a multiple eigenvalue the gradient would take one eigenvector of many."""
        return -self.gradient(information) if multiplier is None else multiplier

    def inequality_matrix(self, p: int) -> Array:
        """The unit matrix (p, p): t is at least the largest eigenvalue of K where I <= t M."""
        return np.eye(p)

    @property
    def log_floor(self) -> float:
        """No floor, minus infinity: a variance can be as small as it will."""
        return -np.inf

    def start(self, parameters: tuple[Parameter, ...], stack: tuple[int, ...]) -> Array:
        """Multipliers (*stack, p, p) of the matrix inequality I <= t M."""
        p = len(parameters)
        return np.zeros((*stack, p, p))

    def hold(
        self, information: Information, log_t: Array, multiplier: Array, penalty: Array
    ) -> tuple[Array, Array, Array, Array]:
        """Augmented Lagrangian of I - t M <= 0 on the cone of semidefinite matrices."""
        # Giving all of the p eigenvalues up must cost more than any log t saves.
        penalty = 10.0 * penalty
        scaled = np.exp(log_t)[..., None, None] * information.matrix
        excess = np.eye(scaled.shape[-1]) - scaled
        values, vectors = np.linalg.eigh(multiplier + penalty[..., None, None] * excess)
        kept = np.maximum(values, 0.0)
        following = (vectors * kept[..., None, :]) @ vectors.swapaxes(-1, -2)
        value = ((kept**2).sum(axis=-1) - (multiplier**2).sum(axis=(-2, -1))) / (2 * penalty)
        slope = -(following * scaled).sum(axis=(-2, -1))
        return value, -np.exp(log_t)[..., None, None] * following, slope, following
