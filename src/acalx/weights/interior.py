"""Optimal weights of a few regressors, by Newton steps from the interior of the simplex.

A primal-dual interior point method for: minimize loss(B + sum w_i h_i'h_i) over w >= 0 with
sum w = 1. The loss of a criterion with a degree is convex, and its second derivative has the
rank p (p + 1) / 2 of the symmetric matrices at most, however many weights there are: a step
costs time in proportion to their number.

Source: Mehrotra, SIAM J. Optim. 2 (1992) 575 for predictor and corrector; Lu and Pong, Comput.
Optim. Appl. 54 (2013) 405 for interior points on optimal designs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from acalx.arrays import Array
from acalx.criteria import Criterion
from acalx.information import Information, Parameter

__all__ = ["Balance", "balance", "sensitivities"]

_ITERATIONS = 80
_TO_BOUNDARY = 0.99  # of the way to the boundary that a step goes at most
_CLOSEST = 0.3  # of the mean complementarity at which the gap is what was asked for
_OVERSHOOT = 2.0  # a step that lets the largest sensitivity grow more is halved
_SHORTEST = 1e-4
_PATIENCE = 8  # iterations in which the gap does not halve
_SETTLED = 1e-3  # the gap from which it shows which weights are zero at the optimum
_NEGLIGIBLE = 1e-2  # a weight so much smaller than the slack of its sensitivity


@dataclass(frozen=True)
class Balance:
    """Weights that are optimal for some positions, up to what `gap` says.

    Parameters
    ----------
    weights : array (k,)
        Not negative, their sum is 1.
    information : Information
        Of the base and the weighted positions.
    support : array (p, p)
        S, minus the gradient over the degree; trace(S M) = 1.
    gap : float
        How much lower exp(loss / degree) could be with other weights on the same positions,
        relative to it, at most.
    """

    weights: Array
    information: Information
    support: Array
    gap: float


def sensitivities(rows: Array, support: Array) -> Array:
    """h S h' summed over outputs: rows (k, m, p) to (k,)."""
    k, m, p = rows.shape
    flat = rows.reshape(k * m, p)
    values = np.einsum("ij,ij->i", flat @ support, flat)
    return values if m == 1 else values.reshape(k, m).sum(axis=1)


def balance(
    rows: Array,
    parameters: tuple[Parameter, ...],
    criterion: Criterion,
    *,
    base: Array | None = None,
    tolerance: float = 1e-9,
) -> Balance:
    """Optimal weights of positions with regressors (k, m, p).

    Parameters
    ----------
    rows : array (k, m, p)
    parameters : tuple of Parameter, length p
    criterion : Criterion
        Smooth, with a degree.
    base : array (p, p), optional
        Information that is there already, in units of one measurement of weight 1.
    tolerance : float
        The gap at which it ends; it may end above, where rounding stops it.
    """
    measure = _Measure(rows, parameters, criterion, np.zeros((rows.shape[-1],) * 2) if base is None else base)
    kept = np.arange(len(rows))
    best: Balance | None = None
    while True:
        inside = _Measure(rows[kept], parameters, criterion, measure.base)
        weights, slack = _interior(inside, tolerance)
        everywhere = np.zeros(len(rows))
        everywhere[kept] = weights
        found = measure.at(everywhere)[0]
        if best is None or found.gap < best.gap:
            best = found
        # with fewer weights rounding errors are smaller, and these are zero at the optimum
        needed = weights > _NEGLIGIBLE * slack
        if best.gap <= tolerance or found.gap > _SETTLED or needed.all():
            return best
        kept = kept[needed]


@dataclass(frozen=True)
class _Measure:
    """Positions that share the measurements."""

    rows: Array
    parameters: tuple[Parameter, ...]
    criterion: Criterion
    base: Array

    @property
    def degree(self) -> float:
        degree = self.criterion.degree(len(self.parameters))
        assert degree is not None  # refused before
        return degree

    def at(self, weights: Array) -> tuple[Balance, Array]:
        """Where these weights lead, and the sensitivity of each position."""
        weighted = (self.rows * np.sqrt(weights)[:, None, None]).reshape(-1, len(self.parameters))
        information = Information(self.base + weighted.T @ weighted, self.parameters)
        support = self.criterion.support(information, None) / self.degree
        heights = sensitivities(self.rows, support)
        gap = float((support * self.base).sum() + heights.max()) - 1.0
        return Balance(weights, information, support, gap), heights


def _interior(measure: _Measure, tolerance: float) -> tuple[Array, Array]:
    """Weights, and slacks of their sensitivities, on the way along the central path to the optimum."""
    k = len(measure.rows)
    here, heights = measure.at(np.full(k, 1.0 / k))
    level = 1.1 * heights.max()
    slack = level - heights
    best, idle = (here.gap, here.weights, slack), 0
    for _ in range(_ITERATIONS):
        if best[0] <= tolerance or idle == _PATIENCE:
            break
        solve = _newton(here.weights, slack, _curvature(measure, here.information))
        mean = here.weights @ slack / k
        change, _ = solve(heights - level)
        change_slack = -slack * (1.0 + change / here.weights)
        reach = min(_reach(here.weights, change), _reach(slack, change_slack))
        predicted = (here.weights + reach * change) @ (slack + reach * change_slack) / k
        # no further along the path than was asked for: beyond, rounding errors take over
        central = max((max(predicted, 0.0) / mean) ** 3 * mean, _CLOSEST * tolerance / k)
        target = central - change * change_slack
        change, rise = solve(heights - level + target / here.weights)
        change_slack = (target - slack * change) / here.weights - slack
        reach = _TO_BOUNDARY * min(_reach(here.weights, change), _reach(slack, change_slack))
        highest = float(heights.max())
        while True:
            weights = here.weights + reach * change
            there, heights = measure.at(weights / weights.sum())
            if heights.max() <= _OVERSHOOT * highest or reach < _SHORTEST:
                break
            reach *= 0.5
        here = there
        level += reach * rise
        slack = slack + reach * change_slack
        # the loss is not quadratic: the slack is what it is, where that is not far off
        exact = level - heights
        slack = np.where((exact > 0.5 * slack) & (exact < 2.0 * slack), exact, slack)
        idle = 0 if here.gap < 0.5 * best[0] else idle + 1
        if here.gap < best[0]:
            best = here.gap, here.weights, slack
    return best[1], best[2]


def _reach(values: Array, changes: Array) -> float:
    """Largest step, up to 1, at which no value becomes negative."""
    ratios = -changes / values
    largest = float(ratios.max())
    return 1.0 if largest <= 1.0 else 1.0 / largest


def _curvature(measure: _Measure, information: Information) -> tuple[Array, Array]:
    """Second derivative F C F' of loss / degree in the weights: F (k, q) and C (q, q).

    Coordinates are those in which the information is the unit matrix, symmetric matrices
    written in an orthonormal basis.
    """
    rows, p = measure.rows, len(measure.parameters)
    factor = np.linalg.cholesky(information.matrix)
    upper = np.triu_indices(p)
    scale = np.where(upper[0] == upper[1], 1.0, np.sqrt(2.0))
    whitened = np.linalg.solve(factor, rows.reshape(-1, p).T).T.reshape(rows.shape)
    features = (whitened[..., upper[0]] * whitened[..., upper[1]]).sum(axis=1) * scale
    basis = np.zeros((len(scale), p, p))
    basis[range(len(scale)), upper[0], upper[1]] = 1.0 / scale
    basis[range(len(scale)), upper[1], upper[0]] = 1.0 / scale
    curvature = measure.criterion.curvature(information, factor @ basis @ factor.T)
    return features, curvature / measure.degree


def _newton(weights: Array, slack: Array, curvature: tuple[Array, Array]) -> Callable[[Array], tuple[Array, float]]:
    """Solver of (F C F' + diag(slack / weights)) change + rise = right, sum change = 0."""
    features, middle = curvature
    k, q = features.shape
    spread = weights / slack
    if k <= 2 * q:
        matrix = features @ middle @ features.T
        matrix[range(k), range(k)] += 1.0 / spread
        root = np.linalg.inv(np.linalg.cholesky(matrix))

        def solve(right: Array) -> Array:
            return np.asarray(root.T @ (root @ right))
    else:  # Woodbury
        scaled = features * spread[:, None]
        inner = np.eye(q) + (features.T @ scaled) @ middle
        inverse = middle @ np.linalg.inv(inner)

        def once(right: Array) -> Array:
            plain = spread * right
            return np.asarray(plain - scaled @ (inverse @ (features.T @ plain)))

        def solve(right: Array) -> Array:
            first = once(right)  # what cancels in it is put right by a second one
            return first + once(right - first / spread - features @ (middle @ (features.T @ first)))

    ones = solve(np.ones(k))

    def balanced(right: Array) -> tuple[Array, float]:
        free = solve(right)
        rise = float(free.sum() / ones.sum())
        return free - rise * ones, rise

    return balanced
