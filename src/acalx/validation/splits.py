"""How right a calibration is on positions that it has not seen."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.errors import ArgumentError, DataError
from acalx.estimation.base import Estimator
from acalx.estimation.procedure import starting_point
from acalx.estimation.readings import Readings
from acalx.estimation.units import Unit
from acalx.models import Model
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
    before : array (..., t m), in units of the model's noise, of `ScalarAccel` in g
        Residuals without the calibration: |W| / |g| - 1.
    after : array (..., t m)
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
        """Root mean square of the residuals that are left, (...), in their unit; inf for splits that failed."""
        root = np.sqrt((self.after**2).mean(axis=-1))
        return np.where(np.isfinite(root), root, np.inf)


def held_out(train: Readings, test: Readings, model: Model, estimator: Estimator, unit: Unit) -> Validation:
    """Calibrate on some readings and test on others.

    Parameters
    ----------
    train, test : Readings
    model : Model
    estimator : Estimator
    unit : Unit
    """
    everything = (np.arange(train.n)[None], np.arange(test.n)[None])
    return _tested((train, everything[0]), (test, everything[1]), model, estimator, unit)


def validate_splits(
    readings: Readings, train: np.ndarray, test: np.ndarray, model: Model, estimator: Estimator, unit: Unit
) -> Validation:
    """Calibrate on some positions and test on others, for a stack of splits.

    Parameters
    ----------
    readings : Readings
    train, test : arrays of int, (s, k) and (s, t)
        Positions of each split, by index.
    """
    return _tested((readings, train), (readings, test), model, estimator, unit)


def validate_folds(
    readings: Readings, folds: Iterable[np.ndarray], model: Model, estimator: Estimator, unit: Unit
) -> Validation:
    """Each fold tested by the calibration from all the others; residuals in the order of the positions."""
    m = model.outputs
    before, after = np.empty((readings.n, m)), np.empty((readings.n, m))
    for test in folds:
        train = np.setdiff1d(np.arange(readings.n), test)
        part = validate_splits(readings, train[None], test[None], model, estimator, unit)
        before[test], after[test] = part.before[0].reshape(-1, m), part.after[0].reshape(-1, m)
    return Validation(before.ravel(), after.ravel())


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


Chosen = tuple[Readings, np.ndarray]


def _tested(train: Chosen, test: Chosen, model: Model, estimator: Estimator, unit: Unit) -> Validation:
    """Readings in positions (s, k) and (s, t) to residuals (s, t m)."""
    (taken, known), (held, held_known) = (_chosen(*each) for each in (train, test))
    start, per = starting_point(taken - unit.offset, known, model, unit)
    per = np.broadcast_to(per, (len(taken), per.shape[-1]))[:, None, :]
    estimate = estimator.estimate(model, (taken - unit.offset) / per, known, start=start)
    measured = (held - unit.offset) / per
    with np.errstate(all="ignore"):  # where the training positions could not show the parameters
        linearize = estimator.linearization(model, measured, held_known)
        nominal = np.broadcast_to(model.nominal, estimate.parameters.shape)
        (before, _), (after, _) = linearize(nominal), linearize(estimate.parameters)
    return Validation(before, np.where(estimate.converged[..., None], after, np.nan))


def _chosen(readings: Readings, positions: np.ndarray) -> tuple[Array, Stimulus | None]:
    """Means (s, k, channels) and what is known of the positions."""
    felt = readings.stimulus
    known = None if felt is None else felt.made({name: value[positions] for name, value in felt.items()})
    return readings.means[positions], known
