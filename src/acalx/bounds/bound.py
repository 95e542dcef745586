"""A bound that no program of n positions can beat.

A program of n positions is a measure on the stand's domain with n equal weights; over all
measures the problem is convex. Write Phi(M) = exp(-loss(M) / k) for a criterion whose value
falls with the k-th power of a multiple of M: where Phi is concave, the tangent at any M0 gives

    Phi(M) <= max over positions x of s(x) * Phi(M0),   s(x) = -trace(G h(x)'h(x)) / k,

with G the gradient of the loss at M0. So loss(M) >= loss(M0) - k log(max s) for every measure
M, and k log n less for the sum over n positions. M0 need not be the optimum; the closer it is,
the closer max s is to 1. What has to be proved is max s.

Source: Kiefer, Ann. Statist. 2 (1974) 849; Pukelsheim, Optimal Design of Experiments (1993).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal, final, get_args

import numpy as np

from acalx.bounds.relaxation import Relaxation, enumerable, looked_at_stops, relax, sensitivity, stops_of
from acalx.criteria import Ceiling, Concave, Criterion, Product, concave_of
from acalx.errors import CompatibilityError, PluginError
from acalx.numerics.cosine import Cosines
from acalx.numerics.supremum import Cells, cells_between, cells_of, supremum
from acalx.options import require_part
from acalx.problem import Problem
from acalx.stands import Stand
from acalx.stands.degrees import wrong_degree

__all__ = ["Bound", "bound"]

# How far above the largest sensitivity found the proof starts: the margin that is given away.
_MARGIN = 3e-8
# Cells a turn at which branch and bound begins, and half the width in rad below which a zone known
# as a function is not asked more finely: the bound says so.
_FIRST_CELLS = 24
_FINEST = math.radians(0.02)
_DIGITS = 7

Status = Literal["computed", "proved at every stop", "proved"]
_STATUSES: tuple[Status, ...] = get_args(Status)  # the least certain first


@final
@dataclass(frozen=True)
class Bound:
    """Least loss of any program of n positions.

    Parameters
    ----------
    loss : float
        Logarithm of the least value of the criterion.
    scale : float
        So many times the logarithm of a variance the loss is: the degree of the criterion. 0 where only
        floors bound it.
    status : str
        ``proved`` on all that the stand can do; ``proved at every stop`` of a stand with steps;
        ``computed``: nothing says that it holds between the points that were looked at.
    method : str
        How it was found.
    margin : float
        By how much it was lowered, in loss, for what lies between the points at which the
        sensitivity was computed.
    parts : dict of str to float
        Of a product: the least loss of each factor.
    """

    loss: float
    scale: float
    status: Status
    method: str
    margin: float = 0.0
    parts: dict[str, float] = field(default_factory=dict)

    @property
    def proved(self) -> bool:
        """Whether it is certain that no program is better."""
        return self.status != "computed"


def bound(problem: Problem) -> Bound:
    """Bound the loss of all programs of a problem.

    Raises
    ------
    CompatibilityError
        A criterion of which nothing bounds a factor, several objectives, or a model to which the order matters.
    """
    require_part("problem", problem, Problem)
    if problem.model.ordered:
        raise CompatibilityError(
            f"what model {problem.model.called} reads depends on the order of the positions, and nothing bounds that"
        )
    found = [
        (weight, factor.label, _of_factor(problem, factor)) for weight, factor in _factors(problem.objective.criterion)
    ]
    alone = len(found) == 1
    methods = [part.method if alone else f"{name}: {part.method}" for _, name, part in found]
    return Bound(
        loss=sum(weight * part.loss for weight, _, part in found),
        scale=sum(weight * part.scale for weight, _, part in found),
        status=min((part.status for _, _, part in found), key=_STATUSES.index),
        method="; ".join(dict.fromkeys(methods)),
        margin=sum(weight * part.margin for weight, _, part in found),
        parts={} if alone else {name: part.loss for _, name, part in found},
    )


def _factors(criterion: Criterion) -> list[tuple[float, Criterion]]:
    """What is bounded by itself: the smooth part together where it is concave, and each ceiling."""
    terms = criterion.terms()
    smooth: list[tuple[float, Criterion]] = list(terms.smooth)
    if len(smooth) > 1:
        weights, criteria = zip(*smooth, strict=True)
        together = Product(criteria, weights)
        if concave_of(together) is not None:
            smooth = [(1.0, together)]
    return [*smooth, *terms.ceilings]


def _of_factor(problem: Problem, factor: Criterion) -> Bound:
    concave = concave_of(factor)
    if concave is not None:
        return _by_relaxation(problem.with_criterion(factor), concave)
    if isinstance(factor, Ceiling) and np.isfinite(factor.log_floor):
        return Bound(factor.log_floor, scale=0.0, status="proved", method="floor")
    raise CompatibilityError(f"{factor.label} does not say how it can be bounded")


def _by_relaxation(problem: Problem, criterion: Concave) -> Bound:
    """Least loss for n positions, from the relaxation and a proof of its largest sensitivity."""
    degree = criterion.degree(len(problem.parameters))
    relaxation = relax(problem)
    status: Status
    if enumerable(problem) and not problem.replicates:
        peak, method = _mean_of_highest(problem, relaxation), "relaxation, every stop used once at most"
        status = "proved at every stop"
    else:
        peak, method, status = _proved_peak(problem, relaxation)
    least = float(criterion.least_loss(relaxation.support, relaxation.information))
    loss = least - degree * math.log((problem.n - problem.held) * peak)
    return Bound(loss, degree, status, method, degree * math.log(peak / min(relaxation.peak, peak)))


def _mean_of_highest(problem: Problem, relaxation: Relaxation) -> float:
    """Mean sensitivity over as many stops as there are positions to choose, the highest, each direction once."""
    stops = stops_of(problem.stand)
    felt = np.concatenate(list(problem.stand.stimulus(stops).values()), axis=-1).reshape(len(stops), -1)
    # what rounding tells apart counts twice, which leaves the bound a bound
    _, first = np.unique(np.round(felt, _DIGITS) + 0.0, axis=0, return_index=True)
    values = np.sort(sensitivity(problem, relaxation.support, stops[first])[0])[::-1][: problem.n - problem.held]
    return float(values.mean() + (relaxation.support * problem.base_share).sum())


def _proved_peak(problem: Problem, relaxation: Relaxation) -> tuple[float, str, Status]:
    """Upper bound on the sensitivity over all that the stand can do."""
    if enumerable(problem):
        return relaxation.peak, "relaxation, sensitivity at every stop", "proved at every stop"
    frequencies, degree = problem.stand.frequencies, problem.model.degree
    if wrong := wrong_degree(problem.stand):
        raise PluginError(
            f"{type(problem.stand).__name__}.frequencies: what is felt is no polynomial of that degree in {wrong}; say "
            "the right degree, or None, with which bounds are computed and not proved"
        )
    if frequencies is None or degree is None:
        method = "relaxation, sensitivity not proved between the points where it was computed"
        return relaxation.peak, method, "computed"
    degrees = [2 * degree * frequency for frequency in frequencies]
    share = float((relaxation.support * problem.base_share).sum())
    stand, zones = problem.stand, problem.stand.zones
    settings = Cosines(stand.axes.bounds, [not setting.angle for setting in stand.settings])

    def values(angles: np.ndarray) -> np.ndarray:
        return sensitivity(problem, relaxation.support, settings.points(angles))[0] + share

    def forbidden(cells: Cells) -> np.ndarray:
        taken = settings.cells(cells)
        return np.asarray(np.logical_or.reduce([zone.covers(taken.centers, taken.half) for zone in zones]))

    exact = all(zone.exact for zone in zones)
    proof = supremum(
        values,
        degrees,
        cells_of(_axes(stand, settings)),
        relaxation.peak + _MARGIN,
        forbidden if zones else None,
        0.0 if exact else _FINEST,
    )
    method = f"relaxation, sensitivity as a trigonometric polynomial on {proof.cells} cells"
    if exact:
        return proof.value, method, "proved"
    return proof.value, f"{method}; forbidden_if known only where it was asked", "computed"


def _axes(stand: Stand, settings: Cosines) -> list[tuple[np.ndarray, np.ndarray]]:
    """First cells in each angle: its stops, or intervals that end at boxes, so that no cell is partly in one."""
    axes = []
    for axis, (setting, stops) in enumerate(zip(stand.settings, looked_at_stops(stand), strict=True)):
        if stops:
            angles = settings.angles(axis, setting.stops())
            axes.append((angles, np.zeros(len(angles))))
            continue
        count = _FIRST_CELLS if setting.angle else 1  # what is no angle may play no part: it is split where it does
        axes.append(cells_between(settings.angles(axis, stand.axes.divided(axis, count + 1))))
    return axes
