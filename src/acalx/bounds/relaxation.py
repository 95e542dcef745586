"""The best approximate design: a measure on all that a stand can do, in place of n positions.

Weights are optimal on a grid at first; then peaks of the sensitivity function between its points
join the support and the weights are optimized anew, until no peak is above 1.

Source: Wynn (1970) and Fedorov (1972) for adding peaks; Yang, Biedermann, Tang, J. Amer.
Statist. Assoc. 108 (2013) 1411 for optimizing all the weights anew each time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from acalx.criteria import Ceiling, Concave, concave_of
from acalx.errors import CompatibilityError
from acalx.numerics.arrays import Array
from acalx.numerics.bfgs import minimize_stack
from acalx.numerics.compass import creep
from acalx.problem import Problem, comparable
from acalx.quantities.information import Information
from acalx.stands import Stand
from acalx.weights import Rows, Weights, optimal_weights

__all__ = ["Relaxation", "enumerable", "looked_at_stops", "relax", "sensitivity", "stops_of"]

_GRID_POINTS = 1681  # at which weights are optimized first, where settings have no stops
_GRID_GAP = 1e-4
_ROUNDS = 30
_PATIENCE = 5  # rounds without a much lower peak
_MOST_STOPS = 50_000  # with more of them, steps are too fine to matter for a bound
_MOST_LINES = 1_000  # of stops of one setting where another has no steps
_MOST_PEAKS = 54
_STARTS = 600  # of the grid, from which peaks are climbed
_CLIMB = 1e-10  # a climb ends where two steps raise the sensitivity by less; a flat one would go on for ever
_SAME = 1e-5  # regressors that differ by less, over the largest of an output, belong to the same support point
# The gap to which weights are optimized; a matrix inequality stops short of the accuracy of smooth criteria.
_SMOOTH_GAP, _CEILING_GAP = 1e-10, 1e-8


@dataclass(frozen=True, eq=False)
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


def relax(problem: Problem, tolerance: float = 1e-8) -> Relaxation:
    """Best measure for the criterion of a problem on all that its stand can do.

    Parameters
    ----------
    problem : Problem
        Its n plays a part only where positions are fixed.
    tolerance : float
        The peak of the sensitivity may be so much above 1.

    Raises
    ------
    CompatibilityError
        A criterion by which nothing can be bounded, or whose weights can't be optimized.
    AcalxError
        Positions that together can't estimate all the parameters.
    """
    criterion = concave_of(problem.objective.criterion)
    if criterion is None:
        raise CompatibilityError(f"{problem.criterion.label} does not say how it can be bounded")
    grid = _grid(problem)
    every = enumerable(problem)
    found = _weights(problem, criterion, grid, None if every else _GRID_GAP)
    points = grid[found.index]
    best: Relaxation | None = None
    idle = 0
    for _ in range(_ROUNDS):
        peaks, heights = _peaks(problem, found.support, grid, points)
        peak = float(heights.max() + (found.support * problem.base_share).sum())
        halved = best is None or peak - 1.0 < 0.5 * (best.peak - 1.0)
        idle = 0 if halved else idle + 1
        if best is None or peak < best.peak:
            best = Relaxation(points, found.weights, found.information, found.support, peak)
        if best.peak <= 1.0 + tolerance or idle == _PATIENCE or every:
            break
        high = heights > heights.max() - 0.99 * max(0.0, peak - 1.0)
        new = _merged(problem, peaks[high])[:_MOST_PEAKS]
        points = _merged(problem, np.concatenate([new, points]))
        found = _weights(problem, criterion, points)
        points = points[found.index]
    assert best is not None
    return best


def sensitivity(problem: Problem, support: Array, settings: Array) -> tuple[Array, Array]:
    """h S h' summed over outputs, and its gradient: settings (k, d) to (k,) and (k, d)."""
    at = problem.response.at(settings[:, None, :])
    matrices = np.broadcast_to(support, (len(settings), *support.shape))
    rows = at.jacobian.regressors
    values = ((rows @ support) * rows).sum(axis=(-2, -1))[:, 0]
    return values, at.pull(matrices)[:, 0]


def looked_at_stops(stand: Stand) -> tuple[bool, ...]:
    """Which settings are looked at at their stops only.

    None of them where there are too many stops: then the whole range of the angles is looked at, which
    bounds the stops in it too.
    """
    stepped = tuple(setting.step is not None for setting in stand.settings)
    stops = math.prod(len(setting.stops()) for setting in stand.settings if setting.step is not None)
    few = stops <= (_MOST_STOPS if all(stepped) else _MOST_LINES)
    return stepped if few else (False,) * len(stepped)


def enumerable(problem: Problem) -> bool:
    """Whether the stand has so few stops that the sensitivity is computed at every one."""
    return all(looked_at_stops(problem.stand))


def stops_of(stand: Stand) -> Array:
    """All the stops (k, d) of a stand that has steps in every setting, those that are allowed."""
    axes = np.meshgrid(*(setting.stops() for setting in stand.settings), indexing="ij")
    stops = np.stack(axes, axis=-1).reshape(-1, len(axes))
    return np.asarray(stops[~stand.axes.forbids(stops)])


def _grid(problem: Problem) -> Array:
    stand = problem.stand
    at_stops = looked_at_stops(stand)
    count = round(_GRID_POINTS ** (1.0 / max(1, at_stops.count(False))))
    axes = [
        setting.stops() if few else stand.axes.divided(axis, count)
        for axis, (setting, few) in enumerate(zip(stand.settings, at_stops, strict=True))
    ]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    grid = grid[~stand.axes.forbids(grid)]
    if all(zone.exact for zone in stand.zones):
        return np.asarray(grid)
    # what a function leaves may be smaller than the grid is wide
    return np.concatenate([grid, stand.axes.random(np.random.default_rng(0), (_GRID_POINTS,))])


def _weights(problem: Problem, criterion: Concave, points: Array, gap: float | None = None) -> Weights:
    """Optimal weights of positions (k, d)."""
    rows = Rows(problem.response.regressors(points), problem.parameters)
    kinks = isinstance(criterion, Ceiling)
    return optimal_weights(
        rows,
        criterion,
        base=problem.base_share if problem.based else None,
        tolerance=gap or (_CEILING_GAP if kinks else _SMOOTH_GAP),
    )


def _peaks(problem: Problem, support: Array, grid: Array, points: Array) -> tuple[Array, Array]:
    """Local maxima of the sensitivity, the highest first, from the best of a grid and from the support."""
    values, _ = sensitivity(problem, support, grid)
    order = np.argsort(-values)[:_STARTS]
    if enumerable(problem):  # all the stops are on the grid
        return grid[order], values[order]
    best = np.concatenate([grid[order], points])

    def objective(x: Array, index: np.ndarray) -> tuple[Array, Array]:
        value, gradient = sensitivity(problem, support, x)
        return np.where(stand.axes.forbids(x), np.inf, -value), -gradient

    stand = problem.stand
    lower, upper = stand.axes.limits_around(best, looked_at_stops(stand))
    sizes = stand.axes.sizes
    minima = minimize_stack(
        objective, best, lower, upper, tolerance=1e-10, loss_tolerance=_CLIMB, iterations=200, sizes=sizes
    )
    order = np.argsort(minima.loss)
    if all(zone.exact for zone in stand.zones):
        return minima.x[order], -minima.loss[order]

    def values_at(x: Array, index: np.ndarray) -> Array:
        flat = x.reshape(-1, x.shape[-1])
        return np.where(stand.axes.forbids(flat), np.inf, -sensitivity(problem, support, flat)[0]).reshape(x.shape[:2])

    crept, lowest = creep(values_at, minima.x, minima.loss, lower, upper, radius=math.radians(5.0))
    order = np.argsort(lowest)
    return crept[order], -lowest[order]


def _merged(problem: Problem, points: Array) -> Array:
    """Points (k, d) that the sensor feels alike taken together, the first of each."""
    rows = comparable(problem.response.regressors(points))
    kept: list[int] = []
    for i in range(len(points)):
        if not kept or np.abs(rows[kept] - rows[i]).max(axis=1).min() >= _SAME:
            kept.append(i)
    return points[kept]
