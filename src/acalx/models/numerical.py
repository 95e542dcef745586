"""Derivatives of the rows of a model that does not give them."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from acalx.numerics.arrays import Array
from acalx.numerics.differences import differences, steps_of
from acalx.quantities.stimulus import Stimulus

__all__ = ["coupled_pull", "numerical_derivative"]

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
            moved = np.ones_like(value)
            found[name] = differences(_moving(regressors, stimulus, name, moved), steps_of(value))
            continue
        samples = []
        for k in range(len(stimulus.weights)):
            moved = np.zeros_like(value)
            moved[..., k, :] = 1.0
            samples.append(differences(_moving(regressors, stimulus, name, moved), steps_of(value)))
        found[name] = np.stack(samples, axis=-4)
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
        total = np.zeros(value.shape)
        for place in np.ndindex(value.shape[-1 - behind : -1]):
            moved = np.zeros_like(value)
            moved[(..., *place, slice(None))] = 1.0
            by_rows = differences(_moving(regressors, stimulus, name, moved), steps_of(value))
            total[(..., *place, slice(None))] = np.einsum("...nmp,...nmpk->...k", gradient, by_rows)
        found[name] = total
    return stimulus.made(found)


def _moving(regressors: Regressors, stimulus: Stimulus, name: str, moved: Array) -> Callable[[Array], Array]:
    """The rows from a shift (width,) of a quantity where it is moved."""
    return lambda shift: regressors(stimulus.made({**stimulus, name: stimulus[name] + moved * shift}))
