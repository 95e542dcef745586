"""The front of several objectives by gradient alone.

First the best programs under each objective alone. From them the ends of the front: the other
objectives at their least where one is at its best. Between the ends goals are laid out evenly
and reached from the ends, from random or given programs, and from one another, all in stacks.

Source: goals on the plane through the ends after Das and Dennis, SIAM J. Optim. 8 (1998) 631.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from math import comb

import numpy as np

from acalx.numerics.arrays import Array
from acalx.problem import Problem
from acalx.search.account import Account
from acalx.search.agreement import distinct_solutions
from acalx.search.aims import Aims, Goals
from acalx.search.lagrangian import Lagrangian
from acalx.search.pareto import SAME, nondominated, spread
from acalx.search.runs import Runs
from acalx.search.starts import descend_from_many

__all__ = ["FrontSearch", "lattice"]

# Best programs under one objective from which ends of the front are sought.
_ENDS = 8
# Weights of the other objectives on the way to the end of one: the last changes its loss by
# about the square.
_WEIGHTS = (1e-2, 1e-3)
# An end that rises by more has left the best program for another minimum.
_STRAYED = 1e-3
# Goals of the first, coarse layer, and how often goals are tried again from their neighbors.
_COARSE = 9
_SWEEPS = 4
# Ranges of losses that are smaller are no conflict.
_NO_RANGE = 1e-5
# By how much losses of an end may still change from one round to the next.
_SETTLED = 1e-6
# Tolerance between the ends over that at the ends: a loss changes by the square of a slope that is left.
_LOOSER = 100.0
# Weight of all the losses beside a goal, so that none is larger than it needs to be.
_SLIGHT = 1e-4
# Goals that are reached closer by less, in parts of the smallest range, are as they were.
_GAIN = 1e-3


def lattice(k: int, count: int) -> Array:
    """The finest even lattice of at most `count` weights (m, k) that add up to 1, the k ends included."""
    if k == 2:
        first = np.linspace(1.0, 0.0, max(count, 2))
        return np.stack([first, 1.0 - first], axis=-1)
    steps = 1
    while comb(steps + k, k - 1) <= count:
        steps += 1
    bars = np.array(list(combinations(range(steps + k - 1), k - 1)))
    edges = np.concatenate([np.full((len(bars), 1), -1), bars, np.full((len(bars), 1), steps + k - 1)], axis=1)
    return np.asarray((np.diff(edges, axis=1) - 1) / steps)


@dataclass(frozen=True)
class FrontSearch:
    """Search for a front from given programs.

    Parameters
    ----------
    points : int
        Most points of the front.
    starts, batch, agreement, tolerance, iterations
        Of the descents, as the options of `acalx.optimizers.Gradient`.
    """

    points: int
    starts: int = 200
    batch: int = 8
    agreement: float = 1e-5
    tolerance: float = 1e-7
    iterations: int = 2000

    def run(self, problem: Problem, rng: np.random.Generator, account: Account, seeds: Array) -> bool:
        """Leave the front in the account; whether the descents under each objective alone agreed.

        Parameters
        ----------
        seeds : array (s, n, d)
            Programs from which goals are tried beside the ends.
        """
        search = _Search(self, problem, account)
        search.add(seeds, problem.losses(seeds))
        settled = search.find_ends(rng, seeds)
        if search.conflict:
            search.find_between()
        return settled


class _Search:
    """One search: all the points seen, the ends, and the runs that other runs go on from."""

    def __init__(self, options: FrontSearch, problem: Problem, account: Account) -> None:
        self.options, self.problem, self.account = options, problem, account
        self.k = len(problem.singles)
        objectives = tuple(single.objective for single in problem.singles)
        self.lagrangian = Lagrangian(objectives, problem.restrictions, (problem.n, problem.d))
        self.settings = np.empty((0, problem.n, problem.d))
        self.losses = np.empty((0, self.k))
        self.ideal = np.full(self.k, np.inf)
        self.before = account.fraction

    def add(self, settings: Array, losses: Array) -> None:
        """Points that were found; the account holds the front of all."""
        self.settings = np.concatenate([self.settings, settings])
        self.losses = np.concatenate([self.losses, losses])
        kept = nondominated(self.losses)
        self.settings, self.losses = self.settings[kept], self.losses[kept]
        chosen = spread(self.losses, self.options.points)
        self.account.hold(self.settings[chosen], self.losses[chosen])

    def _progress(self, share: float) -> None:
        self.account.fraction = self.before + (1.0 - self.before) * share

    def find_ends(self, rng: np.random.Generator, seeds: Array) -> bool:
        """Each objective alone, then the others at its best, and weighted sums from the seeds."""
        options, starts, owners, settled = self.options, [], [], True
        for k, single in enumerate(self.problem.singles):
            inner = Account(lambda _: self.account.tick())
            ends = descend_from_many(
                single,
                rng,
                inner,
                starts=options.starts,
                batch=options.batch,
                agreement=options.agreement,
                tolerance=options.tolerance,
                iterations=options.iterations,
            )
            self.account.evaluations += inner.evaluations
            settled &= ends.settled
            if not np.isfinite(ends.losses).any():
                return False
            best = distinct_solutions(single, ends.settings, ends.losses, options.agreement)[:_ENDS]
            self.ideal[k] = best[0].loss
            starts += [solution.settings for solution in best]
            owners += [k] * len(best)
            found = np.stack([solution.settings for solution in best])
            self.add(found, self.problem.losses(found))
            self._progress(0.4 * (k + 1) / self.k)
        self._descend_to_ends(np.concatenate([np.stack(starts), seeds]), np.array(owners))
        return settled

    def _descend_to_ends(self, starts: Array, owners: np.ndarray) -> None:
        """Ends with falling weights of the other objectives; seeds by weights spread evenly."""
        count, free = len(owners), len(starts) - len(owners)
        losses = self.problem.losses(starts)
        spread_out = np.resize(lattice(self.k, _COARSE if self.k == 2 else 5 * self.k)[::-1], (free, self.k))
        runs = None
        for weight in _WEIGHTS:
            span = np.maximum(losses[:count].max(axis=0) - self.ideal, _NO_RANGE)
            unit = span.min()
            weights = np.where(np.arange(self.k) == owners[:, None], 1.0, weight)
            weights = np.concatenate([weights, spread_out * unit / span])
            aims = Aims(weights, Goals(np.full(weights.shape, np.inf), np.ones(self.k), unit))
            every = np.arange(len(starts))
            if runs is None or self._strayed(losses[:count], owners):
                runs = Runs(self.lagrangian, aims, self.account, starts)
            else:
                runs = runs.again(every, aims)
            runs.descend(self.options.tolerance, self.options.iterations, agreement=_SETTLED)
            losses = runs.losses
            self.add(runs.settings, losses)
        assert runs is not None
        self.runs = runs
        self.ends = [int(np.where(owners == k, runs.merit[:count], np.inf).argmin()) for k in range(self.k)]
        self.free = np.arange(count, len(starts))
        self._progress(0.5)

    def _strayed(self, losses: Array, owners: np.ndarray) -> bool:
        """Whether under some objective no run is at its best program any more."""
        own = losses[np.arange(len(owners)), owners]
        return any(own[owners == k].min() > self.ideal[k] + _STRAYED for k in range(self.k))

    @property
    def conflict(self) -> bool:
        """Whether no program seen is the best in all objectives."""
        return bool(len(self.losses)) and bool((self.losses.max(axis=0) - self.losses.min(axis=0) > _NO_RANGE).any())

    def find_between(self) -> None:
        """A coarse layer of goals from the ends and seeds, then all goals from the nearest of these."""
        coarse = self._goals(lattice(self.k, _COARSE if self.k == 2 else 5 * self.k))
        every = np.concatenate([self.ends, self.free]).astype(int)
        index = np.repeat(self.ends, len(coarse))
        targets = np.tile(coarse, (self.k, 1))
        if len(self.free):  # each seed to the goal that it is the closest to
            merits = self._merits(coarse, self.runs.losses[self.free])
            index = np.concatenate([index, self.free])
            targets = np.concatenate([targets, coarse[merits.argmin(axis=0)]])
        assert len(every)
        self._reach(index, targets)
        self._progress(0.6)
        fine = self._goals(lattice(self.k, self.options.points))
        least = np.full(len(fine), np.inf)
        sources, reached = self._nearest(fine)
        for sweep in range(_SWEEPS):
            self._reach(sources, fine[reached])
            self.lay_out(fine)
            self._progress(0.6 + 0.4 * (sweep + 1) / _SWEEPS)
            before = least
            least = self._merits(fine, self.losses).min(axis=1)
            if sweep and not (least < before - _GAIN * self.span.min()).any():
                break
            sources, reached = self._beside(fine)
            if not len(sources):
                break

    def _nearest(self, goals: Array) -> tuple[np.ndarray, np.ndarray]:
        """For each goal the closest of the runs: numbers of runs and of their goals."""
        return self._merits(goals, self.runs.losses).argmin(axis=1), np.arange(len(goals))

    def _beside(self, goals: Array) -> tuple[np.ndarray, np.ndarray]:
        """For each goal and loss the closest of the runs that are below its best in that loss.

        They come from all sides, since another side may belong to another branch of the front
        that goes on below this one.
        """
        alone = nondominated(self.runs.losses)
        losses = self.runs.losses[alone]
        merits = self._merits(goals, losses)
        best = merits.argmin(axis=1)
        sources, reached = [], []
        for k in range(self.k):
            below = losses[None, :, k] < losses[best, None, k] - SAME
            beside = np.where(below, merits, np.inf)
            there = np.flatnonzero(np.isfinite(beside).any(axis=1))
            sources.append(alone[beside[there].argmin(axis=1)])
            reached.append(there)
        return np.concatenate(sources), np.concatenate(reached)

    def lay_out(self, goals: Array) -> None:
        """Choose from the points the ends and the closest to each goal, and fill up with the farthest from these."""
        wanted = np.concatenate([self.losses.argmin(axis=0), self._merits(goals, self.losses).argmin(axis=1)])
        chosen = spread(self.losses, self.options.points, tuple(dict.fromkeys(int(k) for k in wanted)))
        self.account.hold(self.settings[chosen], self.losses[chosen])

    def _goals(self, weights: Array) -> Array:
        """Targets on the plane through the ends of the front as it is now, the ends themselves left out."""
        least, largest = self.losses.min(axis=0), self.losses.max(axis=0)
        ends = self.losses[self.losses.argmin(axis=0)]
        self.span = np.maximum(largest - least, 1e-3 * (largest - least).max())
        inner = weights[weights.max(axis=-1) < 1.0 - 1e-9]
        return np.asarray(inner @ ends)

    def _aims(self, targets: Array) -> Aims:
        unit = float(self.span.min())
        rates = self.span / unit
        return Aims(np.broadcast_to(_SLIGHT / rates, targets.shape), Goals(targets, rates, unit))

    def _merits(self, targets: Array, losses: Array) -> Array:
        """Of each of m losses for each of g goals, (g, m)."""
        g, m = len(targets), len(losses)
        aims = self._aims(np.repeat(targets, m, axis=0))
        return aims.merit(np.tile(losses, (g, 1))).reshape(g, m)

    def _reach(self, index: np.ndarray, targets: Array) -> None:
        self.runs = self.runs.again(index, self._aims(targets))
        self.runs.descend(_LOOSER * self.options.tolerance, self.options.iterations)
        self.add(self.runs.settings, self.runs.losses)
