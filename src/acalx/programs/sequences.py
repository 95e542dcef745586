"""Regular sequences of positions: a start, a step for each angle, and a rule by which they change."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from acalx.numerics.arrays import Array

__all__ = ["RULES", "regular_sequences"]

_TURN = 360.0


def _both(k: np.ndarray, stops: np.ndarray) -> np.ndarray:
    return np.broadcast_to(k, (*stops.shape[:-1], len(k), stops.shape[-1]))


def _turn(k: np.ndarray, stops: np.ndarray) -> np.ndarray:
    d = stops.shape[-1]
    return np.broadcast_to((k + np.arange(d)[::-1]) // d, (*stops.shape[:-1], len(k), d))


def _raster(k: np.ndarray, stops: np.ndarray) -> np.ndarray:
    after = np.cumprod(stops[..., ::-1], axis=-1)[..., ::-1]  # stops of this angle and all that run faster
    faster = np.concatenate([after[..., 1:], np.ones_like(after[..., :1])], axis=-1)
    return np.asarray(k % after[..., None, :] // faster[..., None, :])


# How often each angle has stepped before position k: both angles at every position; one after the
# other, the outer one first; or the inner one through a whole turn before the outer one steps.
RULES: Mapping[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] = {
    "both": _both,
    "turn": _turn,
    "raster": _raster,
}


def regular_sequences(rule: str, starts: Array, steps: Array, n: int) -> Array:
    """The first n positions of regular sequences, in degrees.

    Parameters
    ----------
    rule : str
        ``both``: all angles step at every position. ``turn``: they step in turn, the first one
        first. ``raster``: the last one goes through a whole turn, then the one before it steps.
    starts, steps : array (..., d), degrees
    n : int

    Returns
    -------
    array (..., n, d)

    Source: Wang, Wang, Shen, Qin, J. Chin. Inert. Technol. 24(5), 2016, 583-588, for the starts and
    steps; the rule there is not known.

    Examples
    --------
    >>> regular_sequences("turn", np.array([0.0, 0.0]), np.array([90.0, 45.0]), 4).tolist()
    [[0.0, 0.0], [90.0, 0.0], [90.0, 45.0], [180.0, 45.0]]
    """
    stops = np.maximum(np.rint(_TURN / np.abs(steps)), 1.0).astype(int)
    counts = RULES[rule](np.arange(n)[:, None], stops)
    return np.asarray(starts[..., None, :] + counts * steps[..., None, :], dtype=float)
