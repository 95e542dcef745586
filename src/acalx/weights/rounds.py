"""Best weights on a large set of candidates, with a proof.

Few candidates carry weight. So weights are optimal for a few active ones at a time, and the
candidates whose sensitivity is then too high join them; those without weight leave. A sample of
the candidates is worked through first, so that there are few rounds over all.

For any candidates whatever, a measure with information M0 = B + sum w_i h_i'h_i has an efficiency
of at least 1 / (1 + gap), where for a criterion with support S, trace(S M0) = 1,

    1 + gap = trace(S B) + max over all the candidates of h S h'

(for E the bound is log trace S in the place of the loss). See `acalx.bounds.bound`.

Source: Kiefer and Wolfowitz (1960); Wynn (1970) for adding the worst; Yang, Biedermann, Tang,
J. Amer. Statist. Assoc. 108 (2013) 1411 for optimal weights in every round.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from acalx.criteria import Concave, Criterion, concave_of
from acalx.errors import CompatibilityError, NoProgramError
from acalx.numerics.arrays import Array
from acalx.quantities.information import Information
from acalx.weights.candidates import Candidates
from acalx.weights.interior import gap_of, sensitivities
from acalx.weights.master import Master, newton_master
from acalx.weights.support import Cosines, thinned

__all__ = ["Weights", "optimal_weights"]

_SAMPLE = 20_000
_SAMPLE_GAP = 1e-3
_ALIKE = 0.98  # squared cosine between regressors, in the metric of the covariance
_PER_CHUNK = 200
_POOL = 4000
_LIGHT = 1e-7  # candidates of so much less weight than the largest leave
_PATIENCE = 6  # rounds in which neither the gap nor the loss falls noticeably


@dataclass(frozen=True, eq=False)
class Weights:
    """An approximate design on candidates.

    Parameters
    ----------
    index : array (k,) of int
        Numbers of the candidates that have weight.
    weights : array (k,)
        Positive, their sum is 1.
    information : Information
        Of the base and one measurement, on average.
    support : array (p, p)
        S of the sensitivity h S h'; trace(S M) = 1.
    loss : float
        Of that information.
    gap : float
        The efficiency among all measures on the candidates is at least 1 / (1 + gap).
    rounds : int
        How often the sensitivity of every candidate was computed.
    """

    index: np.ndarray
    weights: Array
    information: Information
    support: Array
    loss: float
    gap: float
    rounds: int

    @property
    def efficiency(self) -> float:
        """At least so much of the best possible, on the scale of a variance."""
        return 1.0 / (1.0 + self.gap)


def optimal_weights(
    candidates: Candidates,
    criterion: Criterion,
    *,
    base: Array | None = None,
    tolerance: float = 1e-6,
    rounds: int = 60,
    master: Master | None = None,
    start: np.ndarray | None = None,
) -> Weights:
    """Weights of candidate positions for which a criterion is least, and the proof.

    Parameters
    ----------
    candidates : Candidates
    criterion : Criterion
        Concave, or a product of concave ones.
    base : array (p, p), optional
        Information of measurements already made, over the number of those to come.
    tolerance : float
        The gap at which it ends.
    rounds : int
        Most rounds over the candidates; what was reached by then is returned with its gap.
    master : Master, optional
        What finds the weights of a few positions; Newton's method where none is given.
    start : array of int, optional
        Numbers of candidates with which to start, such as those of a coarser solution. They
        must be able to estimate all the parameters.

    Raises
    ------
    CompatibilityError
        A criterion that is not concave, or with kinks of which it says nothing, and no master.
    NoProgramError
        Candidates that together can't estimate all the parameters.
    """
    concave = concave_of(criterion)
    if concave is None:
        raise CompatibilityError(
            f"weights can't be optimized for criterion {criterion.label}, which does not say that it is convex; "
            "take D, A or E, or derive the criterion from acalx.criteria.Concave"
        )
    parameters = candidates.parameters
    there = np.zeros((len(parameters), len(parameters))) if base is None else base
    search = _Search(candidates, concave, there, newton_master(concave, parameters) if master is None else master)
    return search.run(tolerance, rounds, start)


@dataclass
class _Search:
    """Candidates and the criterion by which weights are put on them, beside information that is there already."""

    candidates: Candidates
    criterion: Concave
    base: Array
    master: Master

    def run(self, tolerance: float, rounds: int, start: np.ndarray | None) -> Weights:
        if start is not None:
            return self._thinned(self._improve(start, None, tolerance, rounds), tolerance)
        size, p = len(self.candidates), len(self.candidates.parameters)
        rng = np.random.default_rng(0)
        few = 2 * p * (p + 1) + 100
        active = self._complete(self._different(_sample(rng, size, few)))
        if size > 3 * _SAMPLE:
            found = self._improve(active, _sample(rng, size, _SAMPLE), max(tolerance, _SAMPLE_GAP), rounds)
            active = found.index
        return self._thinned(self._improve(active, None, tolerance, rounds), tolerance)

    def _improve(self, active: np.ndarray, index: np.ndarray | None, tolerance: float, rounds: int) -> Weights:
        """Rounds over the candidates of an index, or over all of them."""
        best: Weights | None = None
        goal, lowest, idle, inner = np.inf, np.inf, 0, 0.1 * tolerance
        for count in range(1, rounds + 1):
            found = self.master(self.candidates.regressors(active), self.base, inner)
            offset = float((found.support * self.base).sum())
            peak, new = self._offenders(
                found.support, found.information.covariance, index, 1.0 - offset + 0.5 * tolerance
            )
            gap = gap_of(self.criterion, found.information, found.support, offset + peak)
            loss = float(self.criterion.loss(found.information))
            advance = gap < goal or loss < lowest - 1e-3 * min(gap, 1.0)
            idle = 0 if advance else idle + 1
            goal = 0.5 * gap if gap < goal else goal
            lowest = min(lowest, loss)
            if best is None or gap < best.gap:
                kept = found.weights > 0.0
                best = Weights(active[kept], found.weights[kept], found.information, found.support, loss, gap, count)
            heavy = active[found.weights > _LIGHT * found.weights.max()]
            if best.gap <= tolerance or idle == _PATIENCE or np.isin(new, active).all():
                break
            active = self._sufficient(np.union1d(heavy, new), np.union1d(active, new))
        assert best is not None
        return best

    def _sufficient(self, few: np.ndarray, more: np.ndarray) -> np.ndarray:
        """The few candidates if they can estimate all the parameters: an optimum may not need all of them."""
        rows = self.candidates.regressors(few)
        matrix = self.base + np.einsum("kma,kmb->ab", rows, rows) / len(few)
        return more if Information(matrix, self.candidates.parameters).singular else few

    def _thinned(self, found: Weights, tolerance: float) -> Weights:
        """The same information from fewer candidates, where that costs nothing."""
        rows = self.candidates.regressors(found.index)
        weights = np.where(found.weights < 0.01 * tolerance, 0.0, found.weights)
        kept = weights > 0.0
        weights[kept] = thinned(rows[kept], weights[kept])
        kept = weights > 0.0
        matrix = self.base + np.einsum("k,kma,kmb->ab", weights[kept], rows[kept], rows[kept])
        information = Information(matrix, found.information.parameters)
        support = self.criterion.support(information, found.support)
        support = support / float((support * matrix).sum())
        peak, _ = self._offenders(support, information.covariance, None, np.inf)
        gap = gap_of(self.criterion, information, support, float((support * self.base).sum()) + peak)
        if gap > max(tolerance, 1.01 * found.gap):
            return found
        loss = float(self.criterion.loss(information))
        return Weights(found.index[kept], weights[kept], information, support, loss, gap, found.rounds + 1)

    def _complete(self, active: np.ndarray) -> np.ndarray:
        """Enough active candidates to estimate all the parameters."""
        parameters = self.candidates.parameters
        total = self.base + self._mean_information()
        everything = Information(total, parameters)
        if everything.singular:
            unseen = "; ".join(everything.inestimable())
            raise NoProgramError(f"no weights on these {len(self.candidates)} candidates can estimate {unseen}")
        root = np.linalg.inv(np.linalg.cholesky(total))
        for _ in range(len(parameters)):
            rows = self.candidates.regressors(active)
            information = self.base + np.einsum("kma,kmb->ab", rows, rows) / len(active)
            values, vectors = np.linalg.eigh(root @ information @ root.T)
            weak = vectors[:, values < 1e-6].T @ root
            if not len(weak):
                break
            _, new = self._offenders(weak.T @ weak, root.T @ root, None, 0.0)
            active = np.union1d(active, new)
        return active

    def _different(self, active: np.ndarray) -> np.ndarray:
        """Equal ones only once."""
        rows = self.candidates.regressors(active).reshape(len(active), -1)
        _, first = np.unique(rows, axis=0, return_index=True)
        return active[np.sort(first)]

    def _mean_information(self) -> Array:
        p = len(self.candidates.parameters)
        total = np.zeros((p, p))
        for _, rows in self.candidates.chunks():
            flat = rows.reshape(-1, p)
            total += flat.T @ flat
        return total / len(self.candidates)

    def _offenders(
        self, support: Array, covariance: Array, index: np.ndarray | None, level: float
    ) -> tuple[float, np.ndarray]:
        """Largest sensitivity, and numbers of candidates above a level, unlike each other."""
        peak = -np.inf
        pools: list[tuple[Array, np.ndarray]] = []
        for numbers, rows in self.candidates.chunks(index):
            heights = sensitivities(rows, support)
            peak = max(peak, float(heights.max()))
            high = np.flatnonzero(heights > level + 0.05 * (peak - level))
            if len(high) > _PER_CHUNK:
                high = high[np.argpartition(-heights[high], _PER_CHUNK)[:_PER_CHUNK]]
            pools.append((heights[high], numbers[high]))
        heights, numbers = (np.concatenate(parts) for parts in zip(*pools, strict=True))
        order = np.argsort(-heights, kind="stable")[:_POOL]
        numbers = numbers[order[heights[order] > level + 0.05 * (peak - level)]]
        return peak, self._unlike(numbers, covariance)

    def _unlike(self, numbers: np.ndarray, covariance: Array) -> np.ndarray:
        """The first of each set of candidates that are alike, where the best come first."""
        cosines = Cosines(self.candidates.regressors(numbers), covariance)
        left = np.arange(len(numbers))
        kept: list[int] = []
        while len(left) and len(kept) < 3 * len(covariance):
            kept.append(int(left[0]))
            left = left[cosines(left, kept[-1]) < _ALIKE]
        return numbers[kept]


def _sample(rng: np.random.Generator, size: int, count: int) -> np.ndarray:
    """About so many different numbers, all of them where there are not more."""
    return np.arange(size) if count >= size else np.unique(rng.integers(0, size, count))
