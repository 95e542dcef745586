"""Optimal weights of a few positions by cvxpy."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from acalx.criteria import Concave
from acalx.errors import AcalxError
from acalx.numerics.arrays import Array
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter
from acalx.weights.interior import Balance, gap_of, sensitivities

__all__ = ["Conic", "SolverError", "choose_solvers", "installed_solvers"]

# In this order where none is named; both solve semidefinite and exponential cones.
_PREFERRED = ("CLARABEL", "SCS")
# What each calls its limit of time, so that one that gets lost does not take all of it.
_LIMITS = {"CLARABEL": {"time_limit": 10.0}, "SCS": {"time_limit_secs": 3.0}}
# A gap of the weights of the active positions that says that the solver got lost.
_POOR = 0.01


class SolverError(AcalxError):
    """A solver of cvxpy that did not solve."""


def installed_solvers() -> list[str]:
    """Names of cvxpy's solvers on this machine; none where cvxpy itself is missing."""
    try:
        import cvxpy
    except ImportError:
        return []
    return [str(name) for name in cvxpy.installed_solvers()]


def choose_solvers() -> list[str]:
    """The installed ones of those that can solve all convex forms here, the best first."""
    installed = installed_solvers()
    return [name for name in _PREFERRED if name in installed]


@dataclass
class Conic:
    """A master for `acalx.weights.optimal_weights`.

    cvxpy sees a p x p matrix that equals the stacked outer products times the weights; the
    multiplier of that equation is the support S for any convex form. A dense H' diag(w) H would
    take gigabytes from thousands of positions on.

    Parameters
    ----------
    criterion : Concave
    parameters : tuple of Parameter, length p
    solver : str
        cvxpy's name of it.
    """

    criterion: Concave
    parameters: tuple[Parameter, ...]
    solver: str
    inaccurate: bool = field(default=False, init=False)

    @property
    def fits(self) -> bool:
        """Whether the criterion gives cvxpy an expression."""
        import cvxpy

        p = len(self.parameters)
        return self.criterion.convex(cvxpy.Variable((p, p), symmetric=True), np.eye(p)) is not None

    def __call__(self, rows: Array, base: Array, tolerance: float) -> Balance:
        """Optimal weights of positions with regressors (k, m, p), to what the solver reaches.

        Raises
        ------
        SolverError
            The solver raised, or ended without a solution.
        """
        mean = np.einsum("kma,kmb->ab", rows, rows) / len(rows) + base
        factor = np.linalg.cholesky(mean)
        root = np.linalg.inv(factor)
        outer = np.einsum("kma,kmb->kab", rows, rows)
        weights, multiplier = self._solve(root @ outer @ root.T, root @ base @ root.T, factor)
        multiplier = root.T @ multiplier @ root
        weights = np.maximum(weights, 0.0)
        weights /= weights.sum()
        information = Information(base + np.tensordot(weights, outer, 1), self.parameters)
        if information.singular:
            raise SolverError(f"{self.solver} ended with weights that can't estimate all the parameters")
        support = self.criterion.support(information, multiplier)
        support = support / float((support * information.matrix).sum())
        peak = float((support * base).sum() + sensitivities(rows, support).max())
        found = Balance(weights, information, support, gap_of(self.criterion, information, support, peak))
        if found.gap > _POOR:
            raise SolverError(f"{self.solver} ended at a relative gap of {found.gap:.0e}")
        return found

    def _solve(self, outer: Array, base: Array, factor: Array) -> tuple[Array, Array]:
        """Weights and the multiplier of the equation for the matrix, in coordinates in which it is near I."""
        import cvxpy

        k, p, _ = outer.shape
        weights, matrix = cvxpy.Variable(k, nonneg=True), cvxpy.Variable((p, p), symmetric=True)
        upper = np.triu_indices(p)  # the rest would be the same equations again, which solvers stumble over
        weighted = outer[:, upper[0], upper[1]].T @ weights
        equation = weighted + base[upper] == matrix[upper[0], upper[1]]
        form: Any = self.criterion.convex(matrix, factor)
        problem = cvxpy.Problem(cvxpy.Minimize(form), [equation, cvxpy.sum(weights) == 1])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what they say is in the status
            try:
                problem.solve(solver=self.solver, **_LIMITS.get(self.solver, {}))
            except (cvxpy.error.SolverError, cvxpy.error.DCPError, ArithmeticError, ValueError) as error:
                raise SolverError(f"{self.solver} failed: {_first_line(error)}") from error
        if problem.status not in (cvxpy.OPTIMAL, cvxpy.OPTIMAL_INACCURATE):
            raise SolverError(f"{self.solver} ended with status {problem.status}")
        self.inaccurate |= problem.status == cvxpy.OPTIMAL_INACCURATE
        dual = np.zeros((p, p))
        dual[upper] = -np.asarray(equation.dual_value)
        values, vectors = np.linalg.eigh(0.5 * (dual + dual.T))
        return np.asarray(weights.value), (vectors * np.maximum(values, 0.0)) @ vectors.T


def _first_line(error: BaseException) -> str:
    return str(error).strip().split("\n")[0]
