"""Rotations of a program that cost its criterion nothing, chosen by a second criterion.

Where every direction can be set and a criterion does not change when all positions are rotated
together, its best programs come in families of three parameters. Any of a family may be taken:
so the one that is best by another criterion.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from acalx.criteria import Criterion, Objectives
from acalx.criteria.answers import loss_of
from acalx.errors import CompatibilityError
from acalx.numerics.arrays import Array
from acalx.numerics.compass import creep
from acalx.problem import Objective, Problem, Response
from acalx.quantities.magnitude import written_from_log
from acalx.quantities.stimulus import Stimulus
from acalx.search.account import Account
from acalx.search.descent import descend
from acalx.search.result import Solution
from acalx.search.starts import regular_starts

__all__ = ["Orientation", "Rotations", "check_orientation", "orient"]

_TOLERANCE, _ITERATIONS = 1e-6, 200  # of a descent
_RADIUS = 0.1  # first step where limits leave only some rotations, in rad
_TRIALS = 8  # random rotations for which the first criterion must stay the same
_INVARIANT = 1e-9
_DRAWN = 500  # random rotations of each program, of which so many of the best are descended from
_STARTS = 6
_MOST_PROGRAMS = 8  # of those that are equally good


@dataclass(frozen=True, eq=False)
class Orientation:
    """A program and its rotation.

    Parameters
    ----------
    solution : Solution
        The rotated program, with its loss by the first criterion.
    before, after : float
        Loss by the second criterion.
    """

    solution: Solution
    before: float
    after: float

    def __str__(self) -> str:
        fell = f"from {written_from_log(self.before)} to {written_from_log(self.after)}"
        return f"turned at no cost, by which the second criterion fell {fell}"


def orient(
    problem: Problem, solutions: tuple[Solution, ...], second: Criterion, rng: np.random.Generator
) -> Orientation:
    """The rotation of one of several equally good programs that is best by a second criterion.

    Parameters
    ----------
    problem : Problem
    solutions : tuple of Solution
    second : Criterion
    rng : numpy Generator

    Raises
    ------
    CompatibilityError
        Where positions can't be rotated freely, or the problem's criterion changes when they are.
    """
    check_orientation(problem, second, rng)
    before = float(problem.with_criterion(second).loss(solutions[0].settings))
    best = solutions[0].settings
    least = before
    for solution in solutions[:_MOST_PROGRAMS]:
        rotations = Rotations(problem, _directions(problem, solution.settings), second)
        drawn = np.concatenate([np.zeros((1, 1, 3)), rng.normal(0.0, 1.5, (_DRAWN, 1, 3))])
        drawn = drawn[rotations.possible(drawn)]
        starts = drawn[np.argsort(rotations.loss(drawn), kind="stable")[:_STARTS]]
        vectors, losses = rotations.best_near(starts)
        settings = rotations.settings(vectors)
        losses = np.where(problem.restrictions.permits(settings), losses, np.inf)
        k = int(losses.argmin())
        if losses[k] < least:
            best, least = problem.restrictions.canonical(settings[k]), float(losses[k])
    return Orientation(Solution(best, float(problem.loss(best))), before, least)


def check_orientation(problem: Problem, second: Criterion, rng: np.random.Generator) -> None:
    """Raise CompatibilityError where positions can't be rotated freely, or the problem's criterion feels it."""
    stand, needs = type(problem.stand).__name__, problem.model.needs
    second.check(problem.parameters)
    if len(problem.singles) > 1 or isinstance(second, Objectives):
        raise CompatibilityError("orient: one criterion is designed for and one more chooses the rotation, not several")
    if problem.held:
        raise CompatibilityError("orient: fixed positions can't be rotated; leave out orient= or fixed=")
    if problem.stand.axes.stepped:
        raise CompatibilityError(f"orient: stand {stand} stops at steps only, so programs can't be rotated freely")
    if tuple(needs) != ("specific_force",):
        raise CompatibilityError(
            f"orient: model {problem.model.called} needs {', '.join(needs)}; "
            "only what the specific force alone decides can be rotated"
        )
    program = regular_starts(problem, rng, 1)[0]
    rotations = Rotations(problem, _directions(problem, program), problem.objective.criterion)
    losses = rotations.loss(np.concatenate([np.zeros((1, 1, 3)), rng.normal(0.0, 1.5, (_TRIALS, 1, 3))]))
    change = float(np.ptp(losses)) if np.isfinite(losses).all() else 0.0  # a singular one is singular when rotated
    if not change < _INVARIANT * (1.0 + abs(float(losses[0]))):
        raise CompatibilityError(
            f"orient: criterion {problem.criterion.label} changes by {change:.2g} in loss when the program is rotated, "
            "so that no rotation is free; design for a product of both criteria instead"
        )


def _directions(problem: Problem, settings: Array) -> Array:
    force = problem.stand.stimulus(settings)["specific_force"]
    assert force is not None  # the model needs it
    return force


@dataclass(frozen=True, eq=False)
class Rotations:
    """The rotations of one program as a landscape: settings (s, 1, 3) are rotation vectors in rad.

    Parameters
    ----------
    problem : Problem
    directions : array (n, 3)
        Of the vertical in sensor axes, in each position as it is.
    criterion : Criterion
        By which rotations are judged.
    """

    problem: Problem
    directions: Array
    criterion: Criterion

    @cached_property
    def objective(self) -> Objective:
        """The criterion of programs, with rotation vectors for settings."""
        return Objective(Response(_Turned(self.directions), self.problem.model), self.criterion)

    @property
    def restrictions(self) -> _AnyRotation:
        """None: what the stand can't take, `best_near` leaves out."""
        return _AnyRotation()

    @property
    def restricted(self) -> bool:
        """Whether there are rotations that the stand can't take."""
        return not all(s.full_turn for s in self.problem.stand.settings) or self.problem.restrictions.active

    def settings(self, vectors: Array) -> Array:
        """Settings of the stand (s, n, d) for rotation vectors (s, 1, 3)."""
        return self.problem.stand.aim(_Turned(self.directions).vertical(vectors))

    def possible(self, vectors: Array) -> np.ndarray:
        """Which rotations (s, 1, 3) the stand can take."""
        settings = self.settings(vectors)
        return np.asarray(self.problem.stand.axes.allows(settings).all(axis=-1))

    def best_near(self, starts: Array) -> tuple[Array, Array]:
        """Local minima (s, 1, 3) from starts, and their losses (s,)."""
        if not self.restricted:
            descent = descend(self, starts, account=Account(), tolerance=_TOLERANCE, iterations=_ITERATIONS)
            return descent.settings, descent.loss

        def function(points: Array, index: np.ndarray) -> Array:
            flat = points.reshape(-1, 1, 3)
            return np.where(self.possible(flat), self.loss(flat), np.inf).reshape(points.shape[:2])

        infinite = np.full((len(starts), 3), np.inf)
        x, losses = creep(function, starts[:, 0, :], self.loss(starts), -infinite, infinite, radius=_RADIUS)
        return x[:, None, :], losses

    def loss(self, settings: Array) -> Array:
        """Of the rotated program, (s,), for rotation vectors (s, 1, 3)."""
        return loss_of(self.criterion, self.objective.response.at(settings).information)

    def loss_and_gradient(self, settings: Array) -> tuple[Array, Array]:
        """The same, and its gradient (s, 1, 3) in rad."""
        return self.objective.loss_and_gradient(settings)


@dataclass(frozen=True, eq=False)
class _Turned:
    """What a sensor feels in positions that are rotated together: a placement whose variables are rotation vectors."""

    directions: Array  # (n, 3)

    def vertical(self, vectors: Array) -> Array:
        """Directions (s, n, 3) after rotations (s, 1, 3)."""
        return np.asarray(self.directions @ _matrices(vectors[:, 0, :]).swapaxes(-1, -2))

    def stimulus(self, settings: Array) -> Stimulus:
        return Stimulus(specific_force=self.vertical(settings))

    def pull(self, settings: Array, gradient: Stimulus) -> Array:
        """A turn by a small vector t adds t x force; what the rotation vector must change for it."""
        assert "specific_force" in gradient  # the model needs it
        torque = np.cross(self.vertical(settings), gradient["specific_force"]).sum(axis=-2)
        jacobian = _left_jacobian(settings[:, 0, :]).swapaxes(-1, -2)
        return np.asarray((jacobian @ torque[..., None])[:, None, :, 0])


class _AnyRotation:
    """Every rotation vector is one."""

    active = False
    sizes = np.ones(3)

    def limits_around(self, settings: Array) -> tuple[Array, Array]:
        infinite = np.full((len(settings), 3), np.inf)
        return -infinite, infinite

    def permits(self, settings: Array) -> np.ndarray:
        return np.ones(len(settings), dtype=bool)

    def project(self, settings: Array, allowed: Array) -> Array:
        return settings


def _crosses(vectors: Array) -> Array:
    """Matrices (s, 3, 3) of the cross product with vectors (s, 3)."""
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(-1, 3, 3)


def _matrices(vectors: Array) -> Array:
    """Rotation matrices (s, 3, 3) of rotation vectors (s, 3), by Rodrigues' formula."""
    angle = np.linalg.norm(vectors, axis=-1)[:, None, None]
    cross = _crosses(vectors)
    return np.asarray(
        np.eye(3) + np.sinc(angle / np.pi) * cross + 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * (cross @ cross)
    )


def _left_jacobian(vectors: Array) -> Array:
    """Small turns after a rotation by small changes of its rotation vector, (s, 3, 3)."""
    angle = np.linalg.norm(vectors, axis=-1)[:, None, None]
    cross = _crosses(vectors)
    small = angle < 1e-4
    safe = np.where(small, 1.0, angle)
    third = np.where(small, 1.0 / 6.0 - angle**2 / 120.0, (safe - np.sin(safe)) / safe**3)
    return np.asarray(np.eye(3) + 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * cross + third * (cross @ cross))
