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

from acalx.criteria import Concave
from acalx.numerics.arrays import Array
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter

__all__ = ["Balance", "balance", "gap_of", "sensitivities"]

_ITERATIONS = 100
_TO_BOUNDARY = 0.99  # of the way to the boundary that a step goes at most
_FAST = 0.1  # how far the barrier is below the gap, once a step was
_GOOD = 0.5  # part of the full one
_CLOSEST = 0.3  # of the barrier at which the gap is what was asked for
_APART = 100.0  # slacks times weights may differ so much from the barrier
_SHORTEST = 1e-6
_ROUNDING = 1e-14
_PATIENCE = 8  # iterations in which the gap does not halve, from where it is below
_FAR = 1e-2
_SETTLED = 1e-3  # the gap from which it shows which weights are zero at the optimum
_NEGLIGIBLE = 1e-2  # a weight so much smaller than the slack of its sensitivity


@dataclass(frozen=True, eq=False)
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
        The efficiency among all weights of the same positions is at least 1 / (1 + gap).
    """

    weights: Array
    information: Information
    support: Array
    gap: float


def gap_of(criterion: Concave, information: Information, support: Array, peak: float) -> float:
    """How far exp(loss / degree) is above its bound, relative to it.

    The bound is for all measures for whose positions trace(S B) + h S h' is `peak` at most.
    """
    degree = criterion.degree(len(information.parameters))
    loss, least = criterion.loss(information), criterion.least_loss(support, information)
    return max(0.0, float(np.expm1((loss - least) / degree + np.log(peak))))


def sensitivities(rows: Array, support: Array) -> Array:
    """h S h' summed over outputs: rows (k, m, p) to (k,)."""
    k, m, p = rows.shape
    flat = rows.reshape(k * m, p)
    values = np.einsum("ij,ij->i", flat @ support, flat)
    return np.asarray(values.reshape(k, m).sum(axis=1))


def balance(
    rows: Array,
    parameters: tuple[Parameter, ...],
    criterion: Concave,
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
        Smooth.
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
        end, slack = _interior(inside, tolerance)
        everywhere = np.zeros(len(rows))
        everywhere[kept] = end.weights
        found = measure.at(everywhere)
        if best is None or found.gap < best.gap:
            best = found
        # with fewer weights rounding errors are smaller, and these are zero at the optimum
        needed = end.weights > _NEGLIGIBLE * slack
        if best.gap <= tolerance or found.gap > _SETTLED or needed.all():
            return best
        kept = kept[needed]


@dataclass(frozen=True, eq=False)
class _Measure:
    """Positions that share the measurements."""

    rows: Array
    parameters: tuple[Parameter, ...]
    criterion: Concave
    base: Array

    @property
    def degree(self) -> float:
        return self.criterion.degree(len(self.parameters))

    def at(self, weights: Array) -> Balance:
        """Where these weights lead."""
        weighted = (self.rows * np.sqrt(weights)[:, None, None]).reshape(-1, len(self.parameters))
        information = Information(self.base + weighted.T @ weighted, self.parameters)
        if information.singular:
            return Balance(weights, information, np.zeros_like(self.base), np.inf)
        support = self.criterion.support(information, None) / self.degree
        peak = float((support * self.base).sum() + sensitivities(self.rows, support).max())
        return Balance(weights, information, support, gap_of(self.criterion, information, support, peak))


def _interior(measure: _Measure, tolerance: float) -> tuple[Balance, Array]:
    """Along the central path to the optimum: where it ends, and the slacks of the sensitivities there."""
    k = len(measure.rows)
    nearest = _CLOSEST * tolerance / (k + len(measure.parameters))
    here = measure.at(np.full(k, 1.0 / k))
    barrier = max(1.0, here.gap) / k
    slack = barrier / here.weights
    best, goal, idle = (here, slack), 0.5 * here.gap, 0
    for _ in range(_ITERATIONS):
        if best[0].gap <= tolerance or idle == _PATIENCE or here.information.singular:
            break  # singular: an optimum at which not all parameters show, as far as rounding lets it come
        pull = sensitivities(measure.rows, here.support) + barrier / here.weights
        change = _newton(here.weights, slack, _curvature(measure, here))(pull)
        change_slack = barrier / here.weights - slack - slack / here.weights * change
        slope = -float(pull @ change)
        here, reach = _advance(measure, here, change, barrier, slope)
        slack = slack + _TO_BOUNDARY * _reach(slack, change_slack) * change_slack
        slack = np.clip(slack, barrier / (_APART * here.weights), _APART * barrier / here.weights)
        idle = 0 if here.gap < goal or here.gap > _FAR else idle + 1
        goal = 0.5 * here.gap if here.gap < goal else goal
        if here.gap < best[0].gap:
            best = here, slack
        # no further along the path than was asked for: beyond, rounding errors take over
        ahead = (_FAST if reach > _GOOD else 1.0) * here.gap / k
        barrier = max(min(barrier, ahead), nearest)
    return best


def _advance(measure: _Measure, here: Balance, change: Array, barrier: float, slope: float) -> tuple[Balance, float]:
    """As far along a change of the weights as the loss behind the barrier falls."""

    def height(there: Balance) -> float:
        if there.information.singular:
            return np.inf
        loss = float(measure.criterion.loss(there.information)) / measure.degree
        return loss - barrier * float(np.log(there.weights).sum())

    reach = _TO_BOUNDARY * _reach(here.weights, change)
    before = height(here)
    while True:
        weights = here.weights + reach * change
        there = measure.at(weights / weights.sum())
        if height(there) <= before + 1e-4 * reach * slope + _ROUNDING * (1.0 + abs(before)) or reach < _SHORTEST:
            return there, reach
        reach *= 0.5


def _reach(values: Array, changes: Array) -> float:
    """Largest step, up to 1, at which no value becomes negative."""
    ratios = -changes / values
    largest = float(ratios.max())
    return 1.0 if largest <= 1.0 else 1.0 / largest


def _curvature(measure: _Measure, here: Balance) -> tuple[Array, Array]:
    """Second derivative F C F' of loss / degree in the weights: F (k, q) and C (q, q).

    Coordinates are those in which the information is the unit matrix, symmetric matrices
    written in an orthonormal basis.
    """
    rows, p = measure.rows, len(measure.parameters)
    factor = np.linalg.cholesky(here.information.matrix)
    upper = np.triu_indices(p)
    scale = np.where(upper[0] == upper[1], 1.0, np.sqrt(2.0))
    whitened = np.linalg.solve(factor, rows.reshape(-1, p).T).T.reshape(rows.shape)
    features = (whitened[..., upper[0]] * whitened[..., upper[1]]).sum(axis=1) * scale
    # outputs of several sensors have parameters of their own: most of the symmetric matrix is zero then
    shown = np.flatnonzero((features != 0.0).any(axis=0))
    features, scale, upper = features[:, shown], scale[shown], (upper[0][shown], upper[1][shown])
    basis = np.zeros((len(scale), p, p))
    basis[range(len(scale)), upper[0], upper[1]] = 1.0 / scale
    basis[range(len(scale)), upper[1], upper[0]] = 1.0 / scale
    curvature = measure.criterion.curvature(here.information, factor @ basis @ factor.T)
    return features, curvature / measure.degree


def _newton(weights: Array, slack: Array, curvature: tuple[Array, Array]) -> Callable[[Array], Array]:
    """Solver of (F C F' + diag(slack / weights)) change = right + constant, sum change = 0."""
    features, middle = curvature
    k, q = features.shape
    scale = np.sqrt(weights / slack)
    scaled = features * scale[:, None]
    if k <= 2 * q:
        matrix = scaled @ middle @ scaled.T
        matrix[range(k), range(k)] += 1.0

        def solve(right: Array) -> Array:
            return np.asarray(np.linalg.solve(matrix, right))
    else:  # Woodbury, by orthogonal columns so that little cancels
        values, vectors = np.linalg.eigh(middle)
        rooted = scaled @ (vectors * np.sqrt(np.maximum(values, 0.0)))
        columns = np.linalg.qr(np.concatenate([rooted, np.eye(q)]))[0][:k]

        def solve(right: Array) -> Array:
            first = right - columns @ (columns.T @ right)
            residual = right - first - rooted @ (rooted.T @ first)
            return np.asarray(first + residual - columns @ (columns.T @ residual))

    def balanced(right: Array) -> Array:
        free, ones = (scale[:, None] * solve(scale[:, None] * np.column_stack([right, np.ones(k)]))).T
        return np.asarray(free - free.sum() / ones.sum() * ones)

    return balanced
