"""How far a program is from the best possible: a bound that no program of n positions can beat.

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

import numpy as np

from acalx.criteria import Ceiling, Criterion, Product
from acalx.problem import Problem
from acalx.relaxation import Relaxation, enumerable, looked_at_stops, relax, sensitivity, stops_of
from acalx.stands import Stand
from acalx.supremum import Cells, cells_between, cells_of, supremum

__all__ = ["Certificate", "certify"]

# The efficiency from which a program counts as proved optimal is one less this.
_PROVED = 1e-6
# How far above the largest sensitivity found the proof starts: the margin that is given away.
_MARGIN = 3e-8
# Cells a turn at which branch and bound begins, and half the width in rad below which a zone known
# as a function is not asked more finely: the certificate says so.
_FIRST_CELLS = 24
_FINEST = math.radians(0.02)
_DIGITS = 7


@dataclass(frozen=True)
class Certificate:
    """A lower bound on the value of a criterion for programs of n positions.

    Parameters
    ----------
    bound : float or None
        In the units of the criterion's published value: for D a determinant. None where the
        criterion can't be bounded.
    efficiency : float or None
        Of the program, 0 to 1, on the scale of a variance: (bound / value) to the power 1 / k.
    gap : float or None
        Loss of the program less the loss of the bound.
    method : str
        How the bound was proved, or why there is none.
    margin : float
        By how much the bound was lowered, in loss, for what lies between the points at which
        the sensitivity was computed.
    proved : bool
        Whether the program is proved optimal, to an efficiency of 1 - 1e-6.
    parts : dict
        Where the criterion is a product: what each factor is bounded by.
    """

    bound: float | None
    efficiency: float | None
    gap: float | None
    method: str
    margin: float = 0.0
    proved: bool = False
    parts: dict[str, float] = field(default_factory=dict)

    def __str__(self) -> str:
        if self.bound is None:
            return f"no bound: {self.method}"
        if self.efficiency is None:
            return f"no program of as many positions gets the criterion below {self.bound:.6g} ({self.method})"
        if self.proved:
            return f"proved optimal: no program of as many positions is better (efficiency {self.efficiency:.6f})"
        value = math.exp(math.log(self.bound or 0.0) + (self.gap or 0.0))
        return (
            f"efficiency {self.efficiency:.5f}: the criterion is {value:.6g} here, "
            f"and no program of as many positions gets it below {self.bound:.6g}"
        )


@dataclass(frozen=True)
class _Bound:
    """Least loss of one factor for programs of n positions."""

    loss: float
    margin: float
    method: str
    proved: bool = True


def certify(problem: Problem, loss: float) -> Certificate:
    """Bound the loss of all programs of a problem and compare one program with it.

    Parameters
    ----------
    problem : Problem
    loss : float
        Of the program.
    """
    p = len(problem.parameters)
    factors = _factors(problem.criterion, p)
    total, margin, scale, parts, methods = 0.0, 0.0, 0.0, {}, []
    holds = True
    for weight, criterion in factors:
        degree = criterion.degree(p)
        if degree is not None:
            found = _bound(problem.with_criterion(criterion), degree)
            scale += weight * degree
        elif isinstance(criterion, Ceiling) and np.isfinite(criterion.log_floor):
            found = _Bound(criterion.log_floor, 0.0, "floor")
        else:
            return Certificate(None, None, None, f"{criterion.label} does not say how it can be bounded")
        total += weight * found.loss
        margin += weight * found.margin
        holds &= found.proved
        name = criterion.label
        parts[name] = math.exp(found.loss)
        methods.append(found.method if len(factors) == 1 else f"{name}: {found.method}")
    gap = loss - total
    efficiency = math.exp(-gap / scale) if scale else None
    proved = holds and efficiency is not None and efficiency >= 1.0 - _PROVED
    method = "; ".join(dict.fromkeys(methods))
    return Certificate(math.exp(total), efficiency, gap, method, margin, proved, parts if len(factors) > 1 else {})


def _factors(criterion: Criterion, p: int) -> list[tuple[float, Criterion]]:
    """What is bounded by itself: the smooth part together where it has a degree, and each ceiling."""
    terms = criterion.terms()
    smooth: list[tuple[float, Criterion]] = list(terms.smooth)
    if len(smooth) > 1:
        weights, criteria = zip(*smooth, strict=True)
        together = Product(criteria, weights)
        if together.degree(p) is not None:
            smooth = [(1.0, together)]
    return [*smooth, *terms.ceilings]


def _bound(problem: Problem, degree: float) -> _Bound:
    """Least loss for n positions, from the relaxation and a proof of its largest sensitivity."""
    relaxation = relax(problem)
    if enumerable(problem) and not problem.replicates:
        peak, method, proved = _mean_of_highest(problem, relaxation), "relaxation, every stop used once at most", True
    else:
        peak, method, proved = _proved_peak(problem, relaxation)
    least = float(problem.criterion.least_loss(relaxation.support, relaxation.information))
    loss = least - degree * math.log((problem.n - problem.held) * peak)
    return _Bound(loss, degree * math.log(peak / min(relaxation.peak, peak)), method, proved)


def _mean_of_highest(problem: Problem, relaxation: Relaxation) -> float:
    """Mean sensitivity over as many stops as there are positions to choose, the highest, each direction once."""
    stops = stops_of(problem.stand)
    felt = np.concatenate([felt for _, felt in problem.stand.stimulus(stops).quantities()], axis=-1)
    # what rounding tells apart counts twice, which leaves the bound a bound
    _, first = np.unique(np.round(felt, _DIGITS) + 0.0, axis=0, return_index=True)
    values = np.sort(sensitivity(problem, relaxation.support, stops[first])[0])[::-1][: problem.n - problem.held]
    return float(values.mean() + (relaxation.support * problem.base_share).sum())


def _proved_peak(problem: Problem, relaxation: Relaxation) -> tuple[float, str, bool]:
    """Upper bound on the sensitivity over all that the stand can do."""
    if enumerable(problem):
        return relaxation.peak, "relaxation, sensitivity at every stop", True
    frequencies, degree = problem.stand.frequencies, problem.model.degree
    if frequencies is None or degree is None:
        return relaxation.peak, "relaxation, sensitivity not proved between the points where it was computed", False
    degrees = [2 * degree * frequency for frequency in frequencies]
    share = float((relaxation.support * problem.base_share).sum())

    def values(points: np.ndarray) -> np.ndarray:
        return sensitivity(problem, relaxation.support, points)[0] + share

    zones = problem.stand.zones

    def forbidden(cells: Cells) -> np.ndarray:
        return np.asarray(np.logical_or.reduce([zone.covers(cells.centers, cells.half) for zone in zones]))

    exact = all(zone.exact for zone in zones)
    proof = supremum(
        values,
        degrees,
        cells_of(_axes(problem.stand)),
        relaxation.peak + _MARGIN,
        forbidden if zones else None,
        0.0 if exact else _FINEST,
    )
    method = f"relaxation, sensitivity as a trigonometric polynomial on {proof.cells} cells"
    return proof.value, method if exact else f"{method}; forbidden_if known only where it was asked", exact


def _axes(stand: Stand) -> list[tuple[np.ndarray, np.ndarray]]:
    """First cells in each angle: its stops, or intervals that end at boxes, so that no cell is partly in one."""
    axes = []
    for axis, (setting, stops) in enumerate(zip(stand.settings, looked_at_stops(stand), strict=True)):
        if stops:
            axes.append((setting.stops(), np.zeros(len(setting.stops()))))
            continue
        axes.append(cells_between(stand.divided(axis, _FIRST_CELLS + 1)))
    return axes
