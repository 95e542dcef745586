"""The figure of a front."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from acalx.numerics.arrays import Array
from acalx.reporting.figures import INK, PALE, SERIES, new_figure, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_front"]

# How far beyond the front a published program is still shown, in parts of its range.
_BEYOND = 1.5
# Values that range over more than this factor are shown on a logarithmic scale.
_WIDE = 4.0


def draw_front(
    names: Sequence[str], values: Array, knee: int, directory: Path, title: str, others: Mapping[str, Array]
) -> None:
    """A front: each pair of objectives against each other, or more than three side by side.

    Parameters
    ----------
    names : sequence of k str
    values : array (m, k)
        Of the objectives, not their logarithms.
    knee : int
        Which of the m points is the knee.
    directory : Path
    title : str
    others : mapping of str to array (k,)
        Values of published programs; those far from the front are left out.
    """
    if len(names) > 3:
        _draw_parallel(names, values, knee, directory, title)
        return
    pairs = list(combinations(range(len(names)), 2))
    figure, panels = new_figure(6.4 if len(pairs) == 1 else 4.4 * len(pairs), 4.8, len(pairs))
    for axes, pair in zip(panels, pairs, strict=True):
        _draw_pair(axes, [names[k] for k in pair], values[:, pair], knee, len(names) == 2, others, pair)
    figure.legend(
        *panels[0].get_legend_handles_labels(), frameon=False, loc="outside lower center", ncols=3, fontsize=9
    )
    figure.suptitle(title)
    save(figure, directory, "front")


def _draw_pair(
    axes: Axes,
    names: Sequence[str],
    values: Array,
    knee: int,
    alone: bool,
    others: Mapping[str, Array],
    pair: tuple[int, int],
) -> None:
    from matplotlib.ticker import LogLocator, NullFormatter

    x, y = values.T
    for axis, set_scale, each in ((axes.xaxis, axes.set_xscale, x), (axes.yaxis, axes.set_yscale, y)):
        if each.max() > _WIDE * each.min() > 0:
            set_scale("log")
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter(NullFormatter())
    if alone:  # a line would lie about three objectives, of which this is a projection
        axes.plot(x, y, color=PALE, linewidth=1.0, zorder=1)
    label = f"{len(values)} programs, none better in all" if len(values) > 1 else "best in all"
    axes.plot(x, y, "o", color=SERIES[1], markersize=4, label=label, zorder=2)
    _draw_published(axes, values, others, pair)
    axes.plot(
        x[knee],
        y[knee],
        "D",
        color=SERIES[0],
        markersize=8,
        markeredgecolor="white",
        label="knee: program.csv",
        zorder=4,
    )
    for k, name in enumerate(names):
        end = int(values[:, k].argmin())
        axes.annotate(
            f"best {name}",
            (x[end], y[end]),
            xytext=(8, 6) if k else (8, 2),
            textcoords="offset points",
            fontsize=9,
            color=INK,
        )
    axes.set_xlabel(names[0])
    axes.set_ylabel(names[1])
    axes.grid(visible=True, color=PALE, linewidth=0.4)
    axes.margins(0.08)


def _draw_published(axes: Axes, values: Array, others: Mapping[str, Array], pair: tuple[int, int]) -> None:
    """Published programs that are near enough not to squeeze the front into a corner."""
    least, largest = values.min(axis=0), values.max(axis=0)
    room = _BEYOND * np.maximum(largest - least, 0.02 * largest)
    shown = [(name, place[list(pair)]) for name, place in others.items() if (place[list(pair)] <= largest + room).all()]
    for number, (name, (x, y)) in enumerate(shown):
        axes.plot(x, y, "s", color=SERIES[2 + number % 2], markersize=6, label=name, zorder=3)


def _draw_parallel(names: Sequence[str], values: Array, knee: int, directory: Path, title: str) -> None:
    """A line a program over the objectives side by side, each from its least value to its largest."""
    figure, (axes,) = new_figure(2.0 + 1.4 * len(names), 4.2)
    logs = np.log(values)
    span = logs.max(axis=0) - logs.min(axis=0)
    heights = (logs - logs.min(axis=0)) / np.where(span > 0, span, 1.0)
    places = np.arange(len(names))
    axes.plot(places, heights.T, color=SERIES[1], linewidth=0.8, alpha=0.4)
    axes.plot(places, heights[knee], color=SERIES[0], linewidth=2.2, label="knee: program.csv")
    ticks = [
        f"{name}\n{low:.4g} to {high:.4g}" for name, low, high in zip(names, values.min(0), values.max(0), strict=True)
    ]
    axes.set_xticks(places, ticks)
    axes.set_yticks([0.0, 1.0], ["least", "largest"])
    axes.legend(frameon=False, loc="upper right", fontsize=9)
    figure.suptitle(title)
    save(figure, directory, "front")
