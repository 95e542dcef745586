"""A grid of positions that is too large to be kept, computed where it is looked at."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.numerics.arrays import Array
from acalx.stands.setting import Setting

__all__ = ["Grid", "grid_over"]


@final
@dataclass(frozen=True)
class Grid:
    """All combinations of the values of several settings, as an array (N, d) is read by its first index.

    Parameters
    ----------
    axes : tuple of arrays
        Values of each setting, in rad; the last one varies fastest.
    """

    axes: tuple[Array, ...]

    def __len__(self) -> int:
        return math.prod(len(axis) for axis in self.axes)

    def __getitem__(self, index: slice | np.ndarray) -> Array:
        """Some of the positions, (k, d) in rad."""
        numbers = np.arange(*index.indices(len(self))) if isinstance(index, slice) else index
        places = np.unravel_index(numbers, tuple(len(axis) for axis in self.axes))
        settings = np.empty((len(numbers), len(self.axes)), order="F")
        for k, axis in enumerate(self.axes):
            settings[:, k] = axis[places[k]]
        return settings


def grid_over(settings: Sequence[Setting], size: int) -> Grid:
    """About `size` positions, each setting with points in proportion to its span.

    A setting with steps has all its stops, or evenly chosen ones where they are too many;
    limits are points of the grid.
    """
    counts: dict[int, int] = {}
    order = sorted(range(len(settings)), key=lambda k: _stops(settings[k]))
    axes: list[Array] = [np.empty(0)] * len(settings)
    for done, k in enumerate(order):  # the fewest stops first: what they leave goes to the others
        rest = order[done:]
        left = size / math.prod(counts.values())
        span = math.prod(settings[j].upper - settings[j].lower for j in rest) ** (1 / len(rest))
        wanted = (settings[k].upper - settings[k].lower) / span * left ** (1 / len(rest))
        axes[k] = _axis(settings[k], max(1, round(wanted)))
        counts[k] = len(axes[k])
    return Grid(tuple(axes))


def _stops(setting: Setting) -> float:
    return math.inf if setting.step is None else len(setting.stops())


def _axis(setting: Setting, count: int) -> Array:
    if setting.step is None:
        return np.linspace(setting.lower, setting.upper, max(2, count), endpoint=not setting.full_turn)
    stops = setting.stops()
    if count >= len(stops):
        return stops
    return np.asarray(stops[np.unique(np.linspace(0, len(stops) - 1, count).round().astype(int))])
