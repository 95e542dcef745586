"""The best approximate design: a measure on all that a stand can do, in place of n positions.

Its support points and weights are improved together by the descent that improves programs;
peaks of the sensitivity function join the support until none is above 1.

Source: Wynn (1970) and Fedorov (1972) for adding peaks; Yang, Biedermann, Tang, J. Amer.
Statist. Assoc. 108 (2013) 1411 for optimizing all the weights anew each time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from acalx.arrays import Array
from acalx.criteria import Criterion
from acalx.information import Information, Parameter
from acalx.optimizers.base import Account
from acalx.optimizers.bfgs import minimize_stack
from acalx.optimizers.descent import descend
from acalx.problem import Linearization, Problem

__all__ = ["Relaxation", "enumerable", "relax", "sensitivity"]

_GRID = 41  # points of a turn at which peaks are looked for
_ROUNDS = 30
_PATIENCE = 5  # rounds without a much lower peak
_MOST_STOPS = 50_000  # of a stand with steps; with more its steps are too fine to matter for a bound
_SAME = 1e-3  # regressors that differ by less belong to the same support point


@dataclass(frozen=True)
class Relaxation:
    """An approximate design, optimal up to what `peak` is above 1.

    Parameters
    ----------
    settings : array (k, d), in rad
        Support points.
    weights : array (k,)
        Share of the measurements at each; their sum is 1.
    information : Information
        Of one measurement, on average.
    support : array (p, p)
        S of the sensitivity h S h'; trace(S M) = 1 at the optimum.
    peak : float
        Largest sensitivity that was found.
    """

    settings: Array
    weights: Array
    information: Information
    support: Array
    peak: float


@dataclass(frozen=True)
class _Measure:
    """A problem whose programs are measures: each position has an amplitude as last setting.

    A position's weight is its squared amplitude over the sum of all, so that weights are
    positive and sum to 1 without being held to it.
    """

    problem: Problem
    points: Array  # (k, d), where they stay if the stand has steps

    @property
    def criterion(self) -> Criterion:
        return self.problem.criterion

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return self.problem.parameters

    @property
    def limits(self) -> tuple[Array, Array]:
        k, _ = self.points.shape
        limits = []
        for bound, infinity in zip(self.problem.stand.free_bounds.T, (-np.inf, np.inf), strict=True):
            held = self.points if enumerable(self.problem) else np.tile(bound, (k, 1))
            limits.append(np.column_stack([held, np.full(k, infinity)]).ravel())
        return limits[0], limits[1]

    def loss_of(self, information: Information, criterion: Criterion | None = None) -> Array:
        return self.problem.loss_of(information, criterion)

    def gradient_of(self, information: Information, criterion: Criterion | None = None) -> Array:
        return self.problem.gradient_of(information, criterion)

    def loss(self, settings: Array) -> Array:
        return self.loss_of(self.information(settings))

    def information(self, settings: Array) -> Information:
        return self.linearize(settings).information

    def linearize(self, settings: Array) -> _MeasureLinearization:
        amplitudes = settings[..., -1]
        size = np.sqrt((amplitudes**2).sum(axis=-1, keepdims=True))
        plain = self.problem.linearize(settings[..., :-1])
        shares = amplitudes / size
        weighted = plain.regressors * shares[..., None, None]
        information = Information.from_regressors(weighted, self.parameters)
        return _MeasureLinearization(plain, shares, size, information)

    def loss_and_gradient(self, settings: Array) -> tuple[Array, Array]:
        at = self.linearize(settings)
        return self.loss_of(at.information), at.pull(self.gradient_of(at.information))


@dataclass(frozen=True)
class _MeasureLinearization:
    plain: Linearization
    shares: Array
    size: Array
    information: Information

    def pull(self, gradient: Array) -> Array:
        weights = self.shares**2
        rows = self.plain.regressors @ gradient[..., None, :, :]
        worth = (rows * self.plain.regressors).sum(axis=(-2, -1))
        by_settings = weights[..., None] * self.plain.pull(gradient)
        mean = (weights * worth).sum(axis=-1, keepdims=True)
        by_amplitude = 2.0 * self.shares / self.size * (worth - mean)
        return np.concatenate([by_settings, by_amplitude[..., None]], axis=-1)


def relax(problem: Problem, tolerance: float = 1e-7) -> Relaxation:
    """Best measure for the criterion of a problem, which must have a degree.

    Parameters
    ----------
    problem : Problem
        Its n plays no part.
    tolerance : float
        The peak of the sensitivity may be so much above 1.
    """
    grid = _grid(problem)
    rng = np.random.default_rng(0)
    p = len(problem.parameters)
    points = grid[rng.choice(len(grid), min(4 * p, len(grid)), replace=False)]
    weights = np.full(len(points), 1.0 / len(points))
    best: Relaxation | None = None
    idle = 0
    for _ in range(_ROUNDS):
        found = _improve(problem, points, weights)
        peaks, heights = _peaks(problem, found.support, np.concatenate([grid, found.settings]))
        found = replace(found, peak=float(heights.max()))
        if best is None or found.peak < best.peak:
            idle = 0 if best is None or found.peak - 1 < 0.5 * (best.peak - 1) else idle + 1
            best = found
        else:
            idle += 1
        if best.peak <= 1.0 + tolerance or idle == _PATIENCE:
            break
        high = heights > 1.0 + 0.01 * (found.peak - 1.0)
        new, _ = _merged(problem, peaks[high], heights[high])
        new = new[: 2 * p]
        share = min(0.1, found.peak - 1.0) / len(new)
        points = np.concatenate([found.settings, new])
        weights = np.concatenate([found.weights * (1.0 - share * len(new)), np.full(len(new), share)])
    assert best is not None
    return best


def sensitivity(problem: Problem, support: Array, settings: Array) -> tuple[Array, Array]:
    """h S h' summed over outputs, and its gradient: settings (k, d) to (k,) and (k, d)."""
    at = problem.linearize(settings[:, None, :])
    rows = at.regressors @ support
    values = (rows * at.regressors).sum(axis=(-2, -1))[:, 0]
    return values, at.pull(np.broadcast_to(support, (len(settings), *support.shape)))[:, 0]


def enumerable(problem: Problem) -> bool:
    """Whether the stand has so few stops that the sensitivity is computed at every one.

    Otherwise the whole range of its angles is looked at, which bounds the stops in it too.
    """
    settings = problem.stand.settings
    if any(setting.step is None for setting in settings):
        return False
    return math.prod(len(setting.stops()) for setting in settings) <= _MOST_STOPS


def _grid(problem: Problem) -> Array:
    few = enumerable(problem)
    axes = [
        setting.stops() if few else np.linspace(setting.lower, setting.upper, _GRID)
        for setting in problem.stand.settings
    ]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


def _improve(problem: Problem, points: Array, weights: Array) -> Relaxation:
    """Move points and weights together to the nearest optimum; drop and merge points."""
    measure = _Measure(problem, points)
    start = np.concatenate([points, np.sqrt(weights)[:, None]], axis=-1)[None]
    descent = descend(measure, start, account=Account(), tolerance=1e-11)
    settings = descent.settings[0]
    weights = settings[:, -1] ** 2
    keep = weights > 1e-9 * weights.sum()
    points, weights = _merged(problem, settings[keep, :-1], weights[keep])
    weights = weights / weights.sum()
    rows = problem.model.regressors(problem.stand.stimulus(points)) * np.sqrt(weights)[:, None, None]
    information = Information.from_regressors(rows, problem.parameters)
    multiplier = descent.multipliers[0][0] if descent.multipliers else None
    support = problem.criterion.support(information, multiplier)
    support = support / float((support * information.matrix).sum())
    return Relaxation(points, weights, information, support, np.inf)


def _peaks(problem: Problem, support: Array, starts: Array) -> tuple[Array, Array]:
    """Local maxima of the sensitivity, from the best of the starts."""
    values, _ = sensitivity(problem, support, starts)
    order = np.argsort(-values)[:120]
    best = starts[order]
    if enumerable(problem):  # all the stops are among the starts
        return best, values[order]

    def objective(x: Array, index: np.ndarray) -> tuple[Array, Array]:
        value, gradient = sensitivity(problem, support, x)
        return -value, -gradient

    lower, upper = problem.stand.free_bounds.T
    minima = minimize_stack(objective, best, lower, upper, tolerance=1e-10, iterations=200)
    return minima.x, -minima.loss


def _merged(problem: Problem, points: Array, weights: Array) -> tuple[Array, Array]:
    """Points that the sensor feels alike taken together, the heaviest first."""
    rows = problem.model.regressors(problem.stand.stimulus(points)).reshape(len(points), -1)
    kept: list[int] = []
    total: list[float] = []
    for i in np.argsort(-weights):
        same = [j for j, k in enumerate(kept) if np.abs(rows[i] - rows[k]).max() < _SAME]
        if same:
            total[same[0]] += float(weights[i])
        else:
            kept.append(int(i))
            total.append(float(weights[i]))
    return points[kept], np.array(total)
