"""Fronts: which programs no other is better than in every objective, and where the knee is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acalx.numerics.arrays import Array

__all__ = ["SAME", "FrontPoint", "front_points", "knee", "nondominated", "normalized", "spread"]

# Losses that differ by less are the same.
SAME = 1e-6


@dataclass(frozen=True, eq=False)
class FrontPoint:
    """A program on a front.

    Parameters
    ----------
    settings : array (n, d), in rad
    losses : array (k,)
        One an objective, in their order.
    """

    settings: Array
    losses: Array


def nondominated(losses: Array, tolerance: float = SAME) -> np.ndarray:
    """Which of m points no other dominates, each set of losses once: indices by ascending first loss.

    A point dominates another that it is below in some loss and not above in any, where losses
    that differ by less than the tolerance are the same.

    Parameters
    ----------
    losses : array (m, k)
    tolerance : float
    """
    order = np.lexsort(losses.T[::-1])
    order = order[np.isfinite(losses[order]).all(axis=-1)]
    kept: list[int] = []
    for k in order:
        if not kept or not (losses[kept] <= losses[k] + tolerance).all(axis=-1).any():
            # one that comes later may be below by all but a tolerance in the first loss
            kept = [j for j in kept if not (losses[k] <= losses[j] + tolerance).all()]
            kept.append(int(k))
    return np.array(kept, dtype=int)


def normalized(losses: Array) -> Array:
    """Losses (m, k) of a front, from 0 at the least of each to 1 at the largest."""
    least = losses.min(axis=0)
    span = losses.max(axis=0) - least
    return np.asarray((losses - least) / np.where(span > 0, span, 1.0))


def knee(losses: Array) -> int:
    """The point of a front (m, k) farthest below the plane through the ends of its ranges.

    In losses normalized to 0 to 1 over the front the plane is where they add up to 1. Of two
    objectives it is the line through the two ends; at the knee a further gain in one begins to
    cost more than its share in the other. Source: Das, Struct. Optim. 18 (1999) 107.
    """
    return int(normalized(losses).sum(axis=-1).argmin())


def spread(losses: Array, count: int, wanted: Sequence[int] = ()) -> np.ndarray:
    """At most so many points of a front (m, k): those wanted, or the ends, then the farthest from all before."""
    if len(losses) <= count:
        return np.arange(len(losses))
    places = normalized(losses)
    kept = list(wanted or dict.fromkeys(int(k) for k in losses.argmin(axis=0)))[:count]
    distance = np.min([((places - places[k]) ** 2).sum(axis=-1) for k in kept], axis=0)
    while len(kept) < count:
        kept.append(int(distance.argmax()))
        distance = np.minimum(distance, ((places - places[kept[-1]]) ** 2).sum(axis=-1))
    return np.sort(kept)


def front_points(settings: Array, losses: Array) -> tuple[FrontPoint, ...]:
    """Programs (m, n, d) and losses (m, k) as points."""
    return tuple(FrontPoint(program, row) for program, row in zip(settings, losses, strict=True))
