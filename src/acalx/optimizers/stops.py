"""Descent over the stops of a stand with steps, one position at a time."""

from __future__ import annotations

import itertools

import numpy as np

from acalx.arrays import Array
from acalx.optimizers.base import Account
from acalx.optimizers.descent import Descent
from acalx.problem import Problem

__all__ = ["descend_stops"]

# Up to so many stops in all, each position is tried at every one; with more, one angle at a time.
_WHOLE_GRID = 1024
# A gain that is less is rounding.
_GAIN = 1e-12


def descend_stops(problem: Problem, starts: Array, *, account: Account) -> Descent:
    """Programs (s, n, d) on the stops in which no change of one position is better.

    Each start goes through its positions in turn and moves each to the best stop, until none
    moves. Source: coordinate exchange after Meyer and Nachtsheim, Technometrics 37 (1995) 60.
    """
    moves = _moves(problem)
    ends = [_descend_one(problem, start, moves, account) for start in starts]
    losses = np.array([loss for _, loss in ends])
    return Descent(np.stack([settings for settings, _ in ends]), losses, np.isfinite(losses))


def _moves(problem: Problem) -> list[tuple[list[int], Array]]:
    """Which settings change together, and the values (k, settings) that they can take."""
    stops = {k: s.stops() for k, s in enumerate(problem.stand.settings) if s.step is not None}
    if np.prod([len(values) for values in stops.values()]) <= _WHOLE_GRID:
        return [(list(stops), np.array(list(itertools.product(*stops.values()))))]
    return [([k], values[:, None]) for k, values in stops.items()]


def _descend_one(
    problem: Problem, settings: Array, moves: list[tuple[list[int], Array]], account: Account
) -> tuple[Array, float]:
    settings = settings.copy()
    loss = float(problem.loss(settings))
    unmoved = 0
    for position in itertools.cycle(range(problem.n)):
        before = loss
        for which, values in moves:
            trials = np.repeat(settings[None], len(values), axis=0)
            trials[:, position, which] = values
            losses = problem.loss(trials)
            account.see(trials, losses)
            best = int(losses.argmin())
            if losses[best] < loss - _GAIN:
                settings, loss = trials[best], float(losses[best])
        unmoved = 0 if loss < before else unmoved + 1
        if unmoved == problem.n:
            break
    return settings, loss
