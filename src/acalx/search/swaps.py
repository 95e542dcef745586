"""Exchange of positions of programs with candidates, one at a time, many programs at once."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from acalx.criteria.answers import loss_of
from acalx.errors import CompatibilityError
from acalx.numerics.arrays import Array
from acalx.problem import Problem, Response, comparable
from acalx.quantities.exchanged import Exchanged
from acalx.quantities.information import Information
from acalx.search.account import Account
from acalx.search.descent import Descent
from acalx.stands import Grid, grid_over
from acalx.stands.axes import Axes

__all__ = ["Candidates", "candidates_of", "descend_swaps", "nearest"]

# Up to so many stops each position is tried at every one. With more, one angle at a time is tried
# at so many stops all around, and then both angles at stops so many steps away.
_WHOLE_GRID = 1_500
_ONE_ANGLE = 400
_AROUND = (-9, -3, -1, 0, 1, 3, 9)
# Programs times candidates times parameters that are worked on at a time.
_CHUNK = 2**18
# A stop in a forbidden zone is exchanged for one at most so many steps away.
_OUT = 5
# A gain that is less is rounding.
_GAIN = 1e-12
_DIGITS = 9


@dataclass(frozen=True, eq=False)
class Candidates:
    """Positions that may be put in.

    Parameters
    ----------
    settings : array (k, d), in rad
    regressors : array (k, m, p)
    """

    settings: Array
    regressors: Array

    @classmethod
    def of(cls, response: Response, settings: Array) -> Candidates:
        """Those settings (k, d), each information once: a table reaches most directions by two pairs of angles."""
        regressors = response.regressors(settings)
        rows = np.round(comparable(regressors), _DIGITS) + 0.0
        _, first = np.unique(rows, axis=0, return_index=True)
        first.sort()
        return cls(settings[first], regressors[first])

    def choices(self, settings: Array) -> tuple[Array, Array]:
        """The same for all positions."""
        return self.settings, self.regressors


@dataclass(frozen=True, eq=False)
class _OneAngle:
    """One angle of a position set to others of its stops."""

    response: Response
    axis: int
    stops: Array

    def choices(self, settings: Array) -> tuple[Array, Array]:
        """For positions (s, d): settings (s, k, d) and regressors (s, k, m, p)."""
        choices = np.repeat(settings[:, None, :], len(self.stops), axis=1)
        choices[..., self.axis] = self.stops
        return choices, self.response.regressors(choices)


@dataclass(frozen=True, eq=False)
class _Around:
    """All angles of a position moved some steps, if any."""

    response: Response
    axes: Axes
    shifts: Array

    def choices(self, settings: Array) -> tuple[Array, Array]:
        """For positions (s, d): settings (s, k, d) and regressors (s, k, m, p)."""
        choices = self.axes.wrap(settings[:, None, :] + self.shifts)
        choices = np.where(self.axes.allows(choices)[..., None], choices, settings[:, None, :])
        return choices, self.response.regressors(choices)


def candidates_of(problem: Problem, size: int) -> Candidates | None:
    """All the stops of a stand that are allowed; None where there are too many.

    Settings without steps are divided so that there are about `size` points in all.
    """
    settings = problem.stand.settings
    stops = [s.stops() for s in settings if s.step is not None]
    count = math.prod(len(each) for each in stops)
    if count > _WHOLE_GRID:
        return None
    free = [s for s in settings if s.step is None]
    grid = iter(grid_over(free, max(size // count, 4 ** len(free))).axes if free else ())
    axes = tuple(next(grid) if s.step is None else s.stops() for s in settings)
    positions = Grid(axes)[:]
    positions = positions[~problem.stand.axes.forbids(positions, clearance=True)]
    if not len(positions):
        raise CompatibilityError(
            f"stand {type(problem.stand).__name__} is allowed no stop at all: make its forbidden zones smaller, "
            "its limits wider or its steps finer"
        )
    return Candidates.of(problem.response, positions)


def descend_swaps(problem: Problem, starts: Array, candidates: Candidates | None, *, account: Account) -> Descent:
    """Programs (s, n, d) in which no exchange of one position for a candidate is better.

    All starts go through their positions in turn and exchange each for the best candidate, until
    none is exchanged. Without candidates, each angle of a position goes to its best stop, and both
    together to the best of the stops around.

    Source: Cook and Nachtsheim, Technometrics 22 (1980) 315, after Fedorov (1972); with one angle
    at a time Meyer and Nachtsheim, Technometrics 37 (1995) 60.
    """
    programs = _Programs(problem, starts, account)
    moves = _moves(problem) if candidates is None else [candidates]
    going = np.flatnonzero(np.isfinite(programs.loss))
    while len(going):
        before = programs.loss[going].copy()
        for position in range(problem.held, problem.n):
            for move in moves:
                programs.exchange(going, position, move)
        going = going[programs.loss[going] < before]
    return Descent(programs.settings, programs.loss, np.isfinite(programs.loss))


def _moves(problem: Problem) -> list[_Move]:
    stepped = [(k, s, s.step) for k, s in enumerate(problem.stand.settings) if s.step is not None]
    one_angle: list[_Move] = []
    shifts = np.zeros((1, problem.d))
    for k, setting, step in stepped:
        stops = setting.stops()
        one_angle.append(_OneAngle(problem.response, k, stops[:: -(-len(stops) // _ONE_ANGLE)]))
        moved = np.repeat(shifts[:, None, :], len(_AROUND), axis=1)
        moved[..., k] = np.array(_AROUND) * step
        shifts = moved.reshape(-1, problem.d)
    return [*one_angle, _Around(problem.response, problem.stand.axes, shifts)]


class _Move(Protocol):
    """Positions that one position can be exchanged for."""

    def choices(self, settings: Array) -> tuple[Array, Array]:
        """For positions (s, d): settings (k, d) or (s, k, d), and their regressors (..., k, m, p)."""


class _Programs:
    """Programs that positions are exchanged in, with what is known of them."""

    def __init__(self, problem: Problem, settings: Array, account: Account) -> None:
        self.problem, self.account = problem, account
        self.criterion = problem.objective.criterion
        self.settings = settings.copy()
        self.regressors = problem.response.regressors(settings)
        self.matrix = problem.model.information_of(self.regressors).matrix
        self.loss = problem.loss(settings)
        account.see(settings, self.loss)

    def exchange(self, going: np.ndarray, position: int, move: _Move) -> None:
        """Exchange one position of some programs for the best choice of a move."""
        many = len(move.choices(self.settings[going[:1], position])[0].reshape(-1, self.problem.d))
        p = len(self.problem.parameters)
        each = p if self.problem.model.outputs == 1 else p * p  # with several outputs by whole matrices
        size = max(1, _CHUNK // (many * each))
        for k in range(0, len(going), size):
            self._exchange(going[k : k + size], position, move)
        self.account.keep(self.settings[going], self.loss[going])

    def _exchange(self, going: np.ndarray, position: int, move: _Move) -> None:
        settings, regressors = move.choices(self.settings[going, position])
        before = Information(self.matrix[going], self.problem.parameters)
        exchanged = Exchanged(before, self.regressors[going, position], regressors)
        losses = np.where(exchanged.lost, np.inf, loss_of(self.criterion, exchanged))
        self.account.evaluations += losses.size
        if self.problem.restrictions.active:
            losses[~self._permitted(going, position, settings)] = np.inf
        best = losses.argmin(axis=1)
        members = np.arange(len(going))
        better = losses[members, best] < self.loss[going] - _GAIN
        if not better.any():
            return
        chosen, best = going[better], best[better]
        if settings.ndim == 3:
            settings, regressors = settings[better, best], regressors[better, best]
        else:
            settings, regressors = settings[best], regressors[best]
        self._put(chosen, position, settings, regressors)

    def _put(self, members: np.ndarray, position: int, settings: Array, regressors: Array) -> None:
        """Put positions in where the loss, computed anew, is less."""
        rows = self.regressors[members].copy()
        rows[:, position] = regressors
        information = self.problem.model.information_of(rows)
        loss = loss_of(self.criterion, information)
        better = loss < self.loss[members]  # else the gain was rounding
        members = members[better]
        self.settings[members, position] = settings[better]
        self.regressors[members] = rows[better]
        self.matrix[members], self.loss[members] = information.matrix[better], loss[better]

    def _permitted(self, going: np.ndarray, position: int, settings: Array) -> np.ndarray:
        """Which choices (k, d) or (s, k, d) leave zones alone and repeat no other position, (s, k)."""
        stack = np.broadcast_to(settings, (len(going), *settings.shape[-2:]))
        permitted = ~self.problem.stand.axes.forbids(stack)
        if not self.problem.replicates:
            others = np.delete(self.settings[going], position, axis=1)
            permitted &= ~self.problem.restrictions.alike(stack, others).any(axis=-1)
        return np.asarray(permitted)


def _out_of_zones(problem: Problem, stops: Array) -> Array:
    """The nearest stops (k, d) that are allowed, where some are near."""
    shifts = np.zeros((1, problem.d))
    for k, setting in enumerate(problem.stand.settings):
        if setting.step is not None:
            moved = np.repeat(shifts[:, None, :], 2 * _OUT + 1, axis=1)
            moved[..., k] = np.arange(-_OUT, _OUT + 1) * setting.step
            shifts = moved.reshape(-1, problem.d)
    shifts = shifts[np.argsort((shifts**2).sum(axis=-1), kind="stable")]
    choices = problem.stand.axes.wrap(stops[:, None, :] + shifts)
    first = problem.stand.axes.allows(choices).argmax(axis=1)
    return np.asarray(choices[range(len(stops)), first])


def nearest(problem: Problem, settings: Array, candidates: Candidates | None) -> Array:
    """Programs (s, n, d) with each position that is not fixed moved to the candidate, or the stop, nearest to it."""
    rounded = settings.copy()
    if candidates is None:
        for k, setting in enumerate(problem.stand.settings):
            if setting.step is not None:
                rounded[:, problem.held :, k] = setting.nearest(settings[:, problem.held :, k])
        free = rounded[:, problem.held :]
        forbidden = problem.stand.axes.forbids(free)
        if forbidden.any():
            free[forbidden] = _out_of_zones(problem, free[forbidden])
        return rounded
    rows = candidates.regressors.reshape(len(candidates.settings), -1)
    for k, program in enumerate(settings):
        feels = problem.response.regressors(program[problem.held :])
        feels = feels.reshape(len(feels), -1)
        # the squared distances but for what is the same for all candidates
        closest = (0.5 * (rows**2).sum(axis=1) - feels @ rows.T).argmin(axis=1)
        rounded[k, problem.held :] = candidates.settings[closest]
    return rounded
