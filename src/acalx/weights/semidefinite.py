"""Optimal weights of a few regressors for a criterion that is a matrix inequality, such as E.

Maximize t with B + sum w_i h_i'h_i - t C positive semidefinite, w >= 0 and sum w = 1, by a primal-
dual interior point method. The dual matrix S comes with it, which at a multiple eigenvalue no
gradient would give.

Source: Helmberg, Rendl, Vanderbei, Wolkowicz, SIAM J. Optim. 6 (1996) 342 for the direction;
Mehrotra, SIAM J. Optim. 2 (1992) 575 for the way along the central path.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from acalx.criteria import Concave
from acalx.numerics.arrays import Array
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter
from acalx.weights.interior import Balance, gap_of, sensitivities

__all__ = ["balance_semidefinite"]

_ITERATIONS = 60
_TO_BOUNDARY = 0.95
_CLOSEST = 0.3  # of the barrier at which the gap is what was asked for
_ROUNDING = 1e-14
_PATIENCE = 6  # iterations in which the gap does not halve


def balance_semidefinite(
    rows: Array,
    parameters: tuple[Parameter, ...],
    criterion: Concave,
    inequality: Array,
    *,
    base: Array | None = None,
    tolerance: float = 1e-9,
) -> Balance:
    """Optimal weights of positions with regressors (k, m, p).

    Parameters
    ----------
    rows : array (k, m, p)
    parameters : tuple of Parameter, length p
    criterion : Concave
        With a value that is the least 1 / t with t C <= M.
    inequality : array (p, p)
        C, positive semidefinite.
    base : array (p, p), optional
        Information that is there already, in units of one measurement of weight 1.
    tolerance : float
        The gap at which it ends; it may end above, where rounding stops it.
    """
    k, _, p = rows.shape
    base = np.zeros((p, p)) if base is None else base
    even = np.full(k, 1.0 / k)
    # in coordinates in which the information is I at the start, and t = 1
    root = np.linalg.inv(np.linalg.cholesky(_information(rows, base, even)))
    limit = root @ inequality @ root.T
    limit = limit / np.linalg.eigvalsh(limit)[-1]
    inside, ready = rows @ root.T, root @ base @ root.T
    state = _State(even, np.ones(k), np.eye(p) - 0.5 * limit, np.eye(p) / np.trace(limit), inside, limit)
    nearest = _CLOSEST * tolerance / (k + p)

    def judged(state: _State) -> Balance:
        within = _information(inside, ready, state.weights)
        dual = state.dual / float((state.dual * within).sum())
        peak = float((dual * ready).sum() + sensitivities(inside, dual).max())
        information, support = Information(_information(rows, base, state.weights), parameters), root.T @ dual @ root
        return Balance(state.weights, information, support, gap_of(criterion, information, support, peak))

    best = judged(state)
    goal, idle = 0.5 * best.gap, 0
    for _ in range(_ITERATIONS):
        state = state.step(nearest)
        if not state.inside:
            break  # as far as rounding lets it go
        here = judged(state)
        idle = 0 if here.gap < goal else idle + 1
        goal = 0.5 * here.gap if here.gap < goal else goal
        if here.gap < best.gap:
            best = here
        if best.gap <= tolerance or (idle >= _PATIENCE and best.gap < 1e-2):
            break
    return best


def _information(rows: Array, base: Array, weights: Array) -> Array:
    flat = (rows * np.sqrt(weights)[:, None, None]).reshape(-1, rows.shape[-1])
    return base + flat.T @ flat


@dataclass(frozen=True, eq=False)
class _Change:
    weights: Array
    slack: Array
    matrix: Array
    dual: Array


@dataclass(frozen=True)
class _State:
    """Weights and their slacks, the matrix M - t C and its dual."""

    weights: Array
    slack: Array
    matrix: Array
    dual: Array
    rows: Array
    inequality: Array

    @property
    def inside(self) -> bool:
        """Whether both matrices are positive definite to working accuracy."""
        return all(np.linalg.eigvalsh(_unit_diagonal(matrix))[0] > _ROUNDING for matrix in (self.matrix, self.dual))

    def step(self, nearest: float) -> _State:
        """One step of predictor and corrector, to a barrier of `nearest` at least."""
        matrix = self.matrix
        values, vectors = np.linalg.eigh(matrix)
        inverse = (vectors / values) @ vectors.T
        size = len(self.weights) + len(matrix)
        barrier = float(self.weights @ self.slack + (matrix * self.dual).sum()) / size
        solve = self._system(inverse)
        ahead = solve(0.0, np.zeros_like(self.weights), np.zeros_like(matrix))
        one, other = self._reaches(matrix, ahead)
        far = float((self.weights + one * ahead.weights) @ (self.slack + other * ahead.slack))
        far += float(((matrix + one * ahead.matrix) * (self.dual + other * ahead.dual)).sum())
        target = max(min(1.0, max(0.0, far / size / barrier)) ** 3 * barrier, nearest)
        bend = ahead.matrix @ ahead.dual
        change = solve(target, ahead.weights * ahead.slack, bend)
        one, other = (_TO_BOUNDARY * reach for reach in self._reaches(matrix, change))
        return _State(
            self.weights + one * change.weights,
            self.slack + other * change.slack,
            matrix + one * change.matrix,
            self.dual + other * change.dual,
            self.rows,
            self.inequality,
        )

    def _system(self, inverse: Array) -> Callable[[float, Array, Array], _Change]:
        """Solver of the linearized conditions for a barrier and the terms of second order."""
        k, m, p = self.rows.shape
        flat = self.rows.reshape(-1, p)
        both = (flat @ inverse @ flat.T) * (flat @ self.dual @ flat.T)
        hessian = both.reshape(k, m, k, m).sum(axis=(1, 3))
        hessian[range(k), range(k)] += self.slack / self.weights
        mixed = inverse @ self.inequality @ self.dual
        mixed = 0.5 * (mixed + mixed.T)
        border = sensitivities(self.rows, mixed)
        system = np.zeros((k + 2, k + 2))
        system[:k, :k] = hessian
        system[:k, k] = system[k, :k] = -border
        system[k, k] = float((mixed * self.inequality).sum())
        system[:k, k + 1] = system[k + 1, :k] = 1.0
        scale = 1.0 / np.sqrt(np.concatenate([hessian.diagonal(), [system[k, k], 1.0]]))
        inverted = np.linalg.inv(system * scale[:, None] * scale)

        def solve(barrier: float, bend: Array, bend_matrix: Array) -> _Change:
            pull = inverse @ (barrier * np.eye(p) - bend_matrix)
            pull = 0.5 * (pull + pull.T)
            right = np.zeros(k + 2)
            right[:k] = sensitivities(self.rows, pull) + (barrier - bend) / self.weights
            right[k] = 1.0 - float((pull * self.inequality).sum())
            right[k + 1] = 1.0 - self.weights.sum()
            solution = scale * (inverted @ (scale * right))
            residual = right - system @ solution
            solution += scale * (inverted @ (scale * residual))
            weights, t = solution[:k], float(solution[k])
            matrix = np.einsum("k,kma,kmb->ab", weights, self.rows, self.rows) - t * self.inequality
            product = inverse @ matrix @ self.dual
            dual = pull - self.dual - 0.5 * (product + product.T)
            slack = (barrier - bend - self.slack * weights) / self.weights - self.slack
            return _Change(weights, slack, matrix, dual)

        return solve

    def _reaches(self, matrix: Array, change: _Change) -> tuple[float, float]:
        """Largest steps, up to 1, of the weights and of the dual."""
        one = min(_reach(self.weights, change.weights), _reach_matrix(matrix, change.matrix))
        other = min(_reach(self.slack, change.slack), _reach_matrix(self.dual, change.dual))
        return one, other


def _reach(values: Array, changes: Array) -> float:
    """Largest step, up to 1, at which no value becomes negative."""
    largest = float((-changes / values).max())
    return 1.0 if largest <= 1.0 else 1.0 / largest


def _unit_diagonal(matrix: Array) -> Array:
    scale = 1.0 / np.sqrt(np.maximum(matrix.diagonal(), np.finfo(float).tiny))
    return matrix * scale[:, None] * scale


def _reach_matrix(matrix: Array, change: Array) -> float:
    """Largest step, up to 1, at which the matrix stays positive semidefinite."""
    root = np.linalg.inv(np.linalg.cholesky(matrix))
    return _reach(np.ones(len(matrix)), np.asarray(np.linalg.eigvalsh(root @ change @ root.T), dtype=float))
