"""Programs on a real sensor: the measured positions that are nearest to a program's, or best by a criterion."""

from __future__ import annotations

import numpy as np

from acalx.criteria import Criterion
from acalx.criteria.answers import loss_of
from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.programs import find_program
from acalx.quantities.information import Information
from acalx.quantities.stimulus import Stimulus

__all__ = ["best_positions", "efficiency", "nearest_positions", "random_positions", "random_turns"]


def nearest_positions(directions: Array, program: Array, turns: Array | None = None) -> tuple[np.ndarray, Array]:
    """A measured position for each of a program, no two the same, by the least sum of squared distances.

    A program that is turned as a whole has the same D: the best of some turns may be taken.

    Parameters
    ----------
    directions : array (N, 3)
        Unit vectors of the vertical in the measured positions.
    program : array (n, 3), n <= N
    turns : array (r, 3, 3), optional
        Rotations to try.

    Returns
    -------
    indices (n,) and the angles (n,) between wanted and measured, in rad
    """
    from scipy.optimize import linear_sum_assignment

    best, found = -np.inf, (np.arange(0), np.zeros(0))
    for turn in np.eye(3)[None] if turns is None else turns:
        cosines = np.clip(program @ turn @ directions.T, -1.0, 1.0)
        rows, columns = linear_sum_assignment(-cosines)
        taken = cosines[rows, columns]
        if taken.sum() > best:
            best, found = taken.sum(), (columns, np.arccos(taken))
    return found


def random_turns(count: int, rng: np.random.Generator) -> Array:
    """Rotations (count, 3, 3), the first none at all, the others uniform, from random unit quaternions."""
    quaternions = rng.standard_normal((count, 4))
    quaternions[0] = (1.0, 0.0, 0.0, 0.0)
    w, x, y, z = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    entries = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(entries), -1, 0)


def best_positions(
    felt: Stimulus, n: int, model: Model, criterion: Criterion, rng: np.random.Generator, starts: int = 10
) -> np.ndarray:
    """The n of N measured positions that a criterion likes best, by exchanges from random starts.

    Each step takes the best of all exchanges of one position, until none is better. Source: Cook and
    Nachtsheim, Technometrics 22 (1980), 315-324.

    Returns
    -------
    indices (n,), ascending
    """
    rows = model.regressors(felt)
    outer = rows.swapaxes(-1, -2) @ rows
    best, chosen = np.inf, np.arange(n)
    for _ in range(starts):
        inside = rng.permutation(len(rows))[:n]
        loss = np.inf
        while True:
            outside = np.setdiff1d(np.arange(len(rows)), inside)
            matrices = outer[inside].sum(axis=0) - outer[inside][:, None] + outer[outside][None, :]
            losses = _losses(matrices.reshape(-1, *matrices.shape[2:]), model, criterion)
            k = int(np.argmin(losses))
            if not losses[k] < loss - 1e-12:
                break
            loss = losses[k]
            inside[k // len(outside)] = outside[k % len(outside)]
        if loss < best:
            best, chosen = loss, np.sort(inside)
    return chosen


def random_positions(total: int, n: int, count: int, rng: np.random.Generator) -> np.ndarray:
    """Indices (count, n) of random choices of n among so many positions."""
    return rng.permuted(np.tile(np.arange(total), (count, 1)), axis=1)[:, :n]


def efficiency(directions: Array, model: Model) -> Array:
    """D-efficiency of directions (..., n, 3) of the one vector that a model reads, relative to even ones, (...).

    (det M / det M_even)^(1/p): so many times as many readings in even positions are as good. For
    the nine parameters none are better than even.
    """
    even = find_program("icosahedron_12").directions  # its moments to the fourth are those of the sphere
    assert even is not None
    p, n = len(model.parameters), directions.shape[-2]
    (name,) = model.needs
    reference = model.information(Stimulus({name: even})).log_det + p * np.log(n / len(even))
    return np.asarray(np.exp((model.information(Stimulus({name: directions})).log_det - reference) / p))


def _losses(matrices: Array, model: Model, criterion: Criterion) -> Array:
    """Loss of each matrix, +inf where singular."""
    return loss_of(criterion, Information(matrices, model.parameters))
