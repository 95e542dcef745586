"""Derivatives of the rows of a model that does not give them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from acalx.numerics.arrays import Array
from acalx.numerics.differences import differences_at, steps_at
from acalx.quantities.stimulus import Stimulus

__all__ = ["by_samples", "coupled_pull", "numerical_derivative"]

Regressors = Callable[[Stimulus], Array]


def numerical_derivative(regressors: Regressors, stimulus: Stimulus, needs: Iterable[str]) -> Stimulus:
    """Derivatives of rows by what is felt in their own position, (..., n, m, p, width), or (..., n, K, m, p, width).

    Parameters
    ----------
    regressors : callable
        From the stimulus to rows (..., n, m, p), each of which depends on its own position alone.
    stimulus : Stimulus
        Moved in all positions at once; of K samples in a position one after the other.
    needs : iterable of str
        The quantities that the rows depend on.
    """
    found = {}
    for name in needs:
        value = stimulus[name]
        if stimulus.weights is None:
            found[name] = differences_at(_moving(regressors, stimulus, name), value, steps_at(value), 2)
            continue
        samples, steps = [], steps_at(value, 2)
        for k in range(len(stimulus.weights)):
            moving = _moving(regressors, stimulus, name, (..., slice(None), k, slice(None)))
            samples.append(differences_at(moving, value[..., k, :], steps[..., k], 2))
        found[name] = np.stack(samples, axis=-4)
    return stimulus.made(found)


def by_samples(each: Stimulus, stimulus: Stimulus) -> Stimulus:
    """Derivatives of means over samples by each of them, from those in the samples as positions, (..., n K, ...)."""
    assert stimulus.weights is not None  # there are samples
    weights = stimulus.weights[:, None, None, None]
    found = {
        name: weights * value.reshape((*value.shape[:-4], -1, len(stimulus.weights), *value.shape[-3:]))
        for name, value in each.items()
    }
    return stimulus.made(found)


def coupled_pull(regressors: Regressors, stimulus: Stimulus, needs: Iterable[str], gradient: Array) -> Stimulus:
    """From a gradient with respect to rows that depend on all the positions to what is felt in each of them.

    Each component is moved in one position, or sample, at a time: a call of `regressors` for each.

    Parameters
    ----------
    regressors : callable
        From the stimulus to rows (..., n, m, p).
    stimulus : Stimulus
    needs : iterable of str
        The quantities that the rows depend on.
    gradient : array (..., n, m, p)
    """
    behind = 1 if stimulus.weights is None else 2  # axes of a quantity from the positions to before its components
    found = {}
    for name in needs:
        value = stimulus[name]
        total, steps = np.zeros(value.shape), steps_at(value, behind)
        for place in np.ndindex(value.shape[-1 - behind : -1]):
            own = (..., *place, slice(None))
            moving = _moving(regressors, stimulus, name, own)
            by_rows = differences_at(moving, value[own], steps[(..., *place)], 3)
            total[own] = np.einsum("...nmp,...nmpk->...k", gradient, by_rows)
        found[name] = total
    return stimulus.made(found)


def _moving(
    regressors: Regressors, stimulus: Stimulus, name: str, where: tuple[Any, ...] = (...,)
) -> Callable[[Array], Array]:
    """The rows from a shift of a quantity in a part of its array."""

    def rows(shift: Array) -> Array:
        moved = stimulus[name].copy()
        moved[where] += shift
        return regressors(stimulus.made({**stimulus, name: moved}))

    return rows
