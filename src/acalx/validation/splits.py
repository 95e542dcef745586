"""How right a calibration is on positions that it has not seen."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.errors import ArgumentError, DataError
from acalx.estimation.base import Estimator
from acalx.estimation.readings import Readings
from acalx.estimation.sphere import starting_point
from acalx.estimation.units import Unit
from acalx.models import ScalarAccel
from acalx.numerics.arrays import Array
from acalx.options import is_number, is_whole
from acalx.quantities.stimulus import Stimulus

__all__ = ["Validation", "held_out", "random_splits", "take_folds", "validate_folds", "validate_splits"]


@final
@dataclass(frozen=True, eq=False)
class Validation:
    """Residuals of test positions, for a stack of splits into training and test.

    Parameters
    ----------
    before : array (..., t), in g
        Without the calibration: |W| / |g| - 1.
    after : array (..., t), in g
        With it; nan where the training positions can't show all the parameters.
    """

    before: Array
    after: Array

    @property
    def failed(self) -> int:
        """How many splits had training positions that can't show all the parameters."""
        return int((~np.isfinite(self.after).all(axis=-1)).sum())

    @property
    def r_squared(self) -> Array:
        """R^2 = 1 - var(after) / var(before), (...); -inf for splits that failed.

        Source: Egorov, Kiryachenko, Popov (2021).
        """
        with np.errstate(invalid="ignore", divide="ignore"):
            ratio = self.after.var(axis=-1) / self.before.var(axis=-1)
        return np.where(np.isfinite(ratio), 1.0 - ratio, -np.inf)

    @property
    def rms(self) -> Array:
        """Root mean square of the residuals that are left, (...), in g; inf for splits that failed."""
        root = np.sqrt((self.after**2).mean(axis=-1))
        return np.where(np.isfinite(root), root, np.inf)


def held_out(train: Readings, test: Readings, model: ScalarAccel, estimator: Estimator, unit: Unit) -> Validation:
    """Calibrate on some readings and test on others.

    Parameters
    ----------
    train, test : Readings
    model : ScalarAccel
    estimator : Estimator
    unit : Unit
    """
    return _tested(
        train.means[None], test.means[None], _vertical(train, None), _vertical(test, None), model, estimator, unit
    )


def validate_splits(
    readings: Readings, train: np.ndarray, test: np.ndarray, model: ScalarAccel, estimator: Estimator, unit: Unit
) -> Validation:
    """Calibrate on some positions and test on others, for a stack of splits.

    Parameters
    ----------
    readings : Readings
    train, test : arrays of int, (s, k) and (s, t)
        Positions of each split, by index.
    """
    means = readings.means
    return _tested(
        means[train], means[test], _vertical(readings, train), _vertical(readings, test), model, estimator, unit
    )


def validate_folds(
    readings: Readings, folds: Iterable[np.ndarray], model: ScalarAccel, estimator: Estimator, unit: Unit
) -> Validation:
    """Each fold tested by the calibration from all the others; residuals in the order of the positions."""
    before, after = np.empty(readings.n), np.empty(readings.n)
    for test in folds:
        train = np.setdiff1d(np.arange(readings.n), test)
        part = validate_splits(readings, train[None], test[None], model, estimator, unit)
        before[test], after[test] = part.before[0], part.after[0]
    return Validation(before, after)


def random_splits(n: int, share: float, count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Indices (count, k) and (count, n - k) of random training and test positions, k about n times the share."""
    if not is_number(share) or not 0.0 < share < 1.0:
        raise ArgumentError.of("share", share, "give the share of positions to calibrate on, between 0 and 1, as 0.667")
    if not is_whole(count) or count < 1:
        raise ArgumentError.of("splits", count, "give a whole number, 1 or more")
    k = round(n * share)
    if n - k < 2:
        raise DataError(f"a share of {share:g} of {n} positions leaves fewer than two to test on; measure more")
    order = rng.permuted(np.tile(np.arange(n), (count, 1)), axis=1)
    return order[:, :k], order[:, k:]


def take_folds(n: int, k: int, rng: np.random.Generator) -> list[np.ndarray]:
    """Indices of the test positions of each of k folds of nearly the same size; k = n leaves one out."""
    if not is_whole(k) or not 2 <= k <= n:
        raise ArgumentError.of("folds", k, f"give a whole number from 2 to the {n} positions")
    return [np.sort(part) for part in np.array_split(rng.permutation(n), k)]


def _tested(
    train: Array,
    test: Array,
    train_vertical: Stimulus | None,
    test_vertical: Stimulus | None,
    model: ScalarAccel,
    estimator: Estimator,
    unit: Unit,
) -> Validation:
    """Readings (s, k, 3) and (s, t, 3) to residuals (s, t)."""
    start, per_g = starting_point(train - unit.offset, model, unit.per_g)
    per_g = per_g[..., None, None]
    estimate = estimator.estimate(model, (train - unit.offset) / per_g, train_vertical, start=start)
    measured = (test - unit.offset) / per_g
    before = model.residual_magnitude(measured)
    with np.errstate(all="ignore"):  # where the training positions could not show the parameters
        after, _ = estimator.linearization(model, measured, test_vertical)(estimate.parameters)
    return Validation(before, np.where(estimate.converged[..., None], after, np.nan))


def _vertical(readings: Readings, positions: np.ndarray | None) -> Stimulus | None:
    if readings.directions is None:
        return None
    chosen = readings.directions[None] if positions is None else readings.directions[positions]
    return Stimulus(specific_force=chosen)
