"""Compass search for minima where some points are not allowed and no limits say which.

It needs values only. Descent along gradients jams at the edge of a zone that is known as a
function; this creeps along it. Source: Kolda, Lewis, Torczon, SIAM Rev. 45 (2003) 385.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from acalx.numerics.arrays import Array

__all__ = ["creep"]

_ROUNDS = 400
_GAIN = 1e-13


def creep(
    function: Callable[[Array, np.ndarray], Array],
    x: Array,
    value: Array,
    lower: Array,
    upper: Array,
    *,
    radius: float,
    smallest: float = 1e-8,
) -> tuple[Array, Array]:
    """Minimize s functions of d variables from x, where each has its value.

    Parameters
    ----------
    function : callable
        Takes points (a, t, d) and the indices (a,) of the functions that they belong to; returns
        values (a, t), inf where a point is not allowed.
    x : array (s, d)
    value : array (s,)
    lower, upper : array (s, d)
    radius, smallest : float
        First length of a step, and the one at which a search ends.

    Returns
    -------
    x : array (s, d)
    value : array (s,)
    """
    rng = np.random.default_rng(0)
    x, value = x.copy(), value.copy()
    lengths = np.full(len(x), radius)
    for _ in range(_ROUNDS):
        going = np.flatnonzero(lengths > smallest)
        if not len(going):
            break
        # along the axes, which edges often follow, and along axes turned at random
        turned, _r = np.linalg.qr(rng.standard_normal((x.shape[1], x.shape[1])))
        axes = np.concatenate([np.eye(x.shape[1]), turned])
        steps = np.concatenate([axes, -axes])
        trials = x[going, None, :] + lengths[going, None, None] * steps
        trials = np.clip(trials, lower[going, None, :], upper[going, None, :])
        values = function(trials, going)
        best = values.argmin(axis=1)
        lowest = values[range(len(going)), best]
        better = lowest < value[going] - _GAIN * (1.0 + np.abs(value[going]))
        moved = going[better]
        x[moved], value[moved] = trials[better, best[better]], lowest[better]
        lengths[going[~better]] *= 0.5
    return x, value
