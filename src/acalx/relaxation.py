"""The best approximate design: a measure on all that a stand can do, in place of n positions.

Its support points and weights are improved together by the descent that improves programs;
peaks of the sensitivity function join the support until none is above 1.

Source: Wynn (1970) and Fedorov (1972) for adding peaks; Yang, Biedermann, Tang, J. Amer.
Statist. Assoc. 108 (2013) 1411 for optimizing all the weights anew each time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from acalx.arrays import Array
from acalx.criteria import Criterion
from acalx.information import Information, Parameter
from acalx.optimizers.base import Account
from acalx.optimizers.bfgs import minimize_stack
from acalx.optimizers.compass import creep
from acalx.optimizers.descent import descend
from acalx.problem import Linearization, Problem
from acalx.stands import Stand

__all__ = ["Relaxation", "enumerable", "looked_at_stops", "relax", "sensitivity", "share_of_fixed"]

_GRID = 41  # points of a turn at which peaks are looked for
_ROUNDS = 30
_PATIENCE = 5  # rounds without a much lower peak
_MOST_STOPS = 50_000  # with more of them, steps are too fine to matter for a bound
_MOST_LINES = 1_000  # of stops of one setting where another has no steps
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
        Of one measurement, on average, with its share of that of fixed positions.
    support : array (p, p)
        S of the sensitivity h S h'; trace(S M) = 1.
    peak : float
        Largest sensitivity that was found, and the share of fixed positions in trace(S M); 1 at
        the optimum.
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

    @property
    def criterion(self) -> Criterion:
        return self.problem.criterion

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return self.problem.parameters

    def limits_around(self, settings: Array) -> tuple[Array, Array]:
        points = settings[..., :-1]
        lower, upper = self.problem.stand.limits_around(points, looked_at_stops(self.problem.stand))
        infinite = np.full((*points.shape[:-1], 1), np.inf)
        shape = (*points.shape[:-2], -1)
        return (
            np.concatenate([lower, -infinite], axis=-1).reshape(shape),
            np.concatenate([upper, infinite], axis=-1).reshape(shape),
        )

    @property
    def restricted(self) -> bool:
        return bool(self.problem.stand.zones)

    def project(self, settings: Array, allowed: Array) -> Array:
        points = self._anywhere.project(settings[..., :-1], allowed[..., :-1])
        return np.concatenate([points, settings[..., -1:]], axis=-1)

    def loss_of(self, information: Information, criterion: Criterion | None = None) -> Array:
        return self.problem.loss_of(information, criterion)

    def gradient_of(self, information: Information, criterion: Criterion | None = None) -> Array:
        return self.problem.gradient_of(information, criterion)

    def loss(self, settings: Array) -> Array:
        return self._loss_at(self.linearize(settings))

    def _loss_at(self, at: _MeasureLinearization) -> Array:
        loss = self.loss_of(at.information)
        return loss if at.permitted is None else np.where(at.permitted, loss, np.inf)

    def information(self, settings: Array) -> Information:
        return self.linearize(settings).information

    def linearize(self, settings: Array) -> _MeasureLinearization:
        amplitudes = settings[..., -1]
        size = np.sqrt((amplitudes**2).sum(axis=-1, keepdims=True))
        plain = self._anywhere.linearize(settings[..., :-1])
        shares = amplitudes / size
        weighted = plain.regressors * shares[..., None, None]
        moved = Information.from_regressors(weighted, self.parameters)
        information = Information(moved.matrix + share_of_fixed(self.problem), self.parameters)
        return _MeasureLinearization(plain, shares, size, information, plain.permitted)

    @cached_property
    def _anywhere(self) -> Problem:
        """The problem without what holds for its n positions only."""
        return replace(self.problem, fixed=None, replicates=True)

    def loss_and_gradient(self, settings: Array) -> tuple[Array, Array]:
        at = self.linearize(settings)
        return self._loss_at(at), at.pull(self.gradient_of(at.information))


@dataclass(frozen=True)
class _MeasureLinearization:
    plain: Linearization
    shares: Array
    size: Array
    information: Information
    permitted: np.ndarray | None

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
        Its n plays a part only where positions are fixed.
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
        found = replace(found, peak=float(heights.max() + (found.support * share_of_fixed(problem)).sum()))
        if best is None or found.peak < best.peak:
            idle = 0 if best is None or found.peak - 1 < 0.5 * (best.peak - 1) else idle + 1
            best = found
        else:
            idle += 1
        at_the_edge = bool(found.information.singular)  # of what can be estimated, where no descent can begin
        if best.peak <= 1.0 + tolerance or idle == _PATIENCE or at_the_edge:
            break
        high = heights > heights.max() - 0.99 * max(0.0, found.peak - 1.0)
        new, _ = _merged(problem, peaks[high], heights[high])
        new = new[: 2 * p]
        share = min(0.1, found.peak - 1.0) / len(new)
        points = np.concatenate([found.settings, new])
        weights = np.concatenate([found.weights * (1.0 - share * len(new)), np.full(len(new), share)])
    assert best is not None
    return best


def sensitivity(problem: Problem, support: Array, settings: Array) -> tuple[Array, Array]:
    """h S h' summed over outputs, and its gradient: settings (k, d) to (k,) and (k, d)."""
    stimulus = problem.stand.stimulus(settings[:, None, :])
    regressors = problem.model.regressors(stimulus)
    matrices = np.broadcast_to(support, (len(settings), *support.shape))
    at = Linearization(problem, settings[:, None, :], stimulus, regressors, Information(matrices, problem.parameters))
    values = ((regressors @ support) * regressors).sum(axis=(-2, -1))[:, 0]
    return values, at.pull(matrices)[:, 0]


def share_of_fixed(problem: Problem) -> Array:
    """Information (p, p) of the fixed positions for each of the others."""
    return problem.base / (problem.n - problem.held)


def looked_at_stops(stand: Stand) -> tuple[bool, ...]:
    """Which settings are looked at at their stops only.

    None where there are too many stops: then the whole range of the angles is looked at, which
    bounds the stops in it too.
    """
    stepped = tuple(setting.step is not None for setting in stand.settings)
    stops = math.prod(len(setting.stops()) for setting in stand.settings if setting.step is not None)
    few = stops <= (_MOST_STOPS if all(stepped) else _MOST_LINES)
    return stepped if few else (False,) * len(stepped)


def enumerable(problem: Problem) -> bool:
    """Whether the stand has so few stops that the sensitivity is computed at every one."""
    return all(looked_at_stops(problem.stand))


def _grid(problem: Problem) -> Array:
    stand = problem.stand
    axes = [
        setting.stops() if few else np.linspace(setting.lower, setting.upper, _GRID)
        for setting, few in zip(stand.settings, looked_at_stops(stand), strict=True)
    ]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    return np.asarray(grid[~stand.forbids(grid)])


def _improve(problem: Problem, points: Array, weights: Array) -> Relaxation:
    """Move points and weights together to the nearest optimum; drop and merge points."""
    measure = _Measure(problem)
    start = np.concatenate([points, np.sqrt(weights)[:, None]], axis=-1)[None]
    descent = descend(measure, start, account=Account(), tolerance=1e-11)
    settings = descent.settings[0]
    weights = settings[:, -1] ** 2
    keep = weights > 1e-9 * weights.sum()
    points, weights = _merged(problem, settings[keep, :-1], weights[keep])
    weights = weights / weights.sum()
    rows = problem.model.regressors(problem.stand.stimulus(points)) * np.sqrt(weights)[:, None, None]
    moved = Information.from_regressors(rows, problem.parameters)
    information = Information(moved.matrix + share_of_fixed(problem), problem.parameters)
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
        return np.where(stand.forbids(x), np.inf, -value), -gradient

    stand = problem.stand
    lower, upper = stand.limits_around(best, looked_at_stops(stand))
    minima = minimize_stack(objective, best, lower, upper, tolerance=1e-10, iterations=200)
    if all(zone.exact for zone in stand.zones):
        return minima.x, -minima.loss

    def values_at(x: Array, index: np.ndarray) -> Array:
        flat = x.reshape(-1, x.shape[-1])
        return np.where(stand.forbids(flat), np.inf, -sensitivity(problem, support, flat)[0]).reshape(x.shape[:2])

    crept, lowest = creep(values_at, minima.x, minima.loss, lower, upper, radius=math.radians(5.0))
    return crept, -lowest


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
