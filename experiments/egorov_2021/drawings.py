"""Figures 2 and 3, with the marks and the panels of the paper."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from printed import GROUPS

from acalx.numerics.arrays import Array
from acalx.reporting.figures import INK, SERIES, new_figure, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# The marks of the paper's Figure 2 by class: asterisks, squares, stars and triangles.
MARKS: Mapping[str, dict[str, Any]] = {
    "rotations about horizontal axes": {"marker": (6, 2, 0), "markersize": 11, "color": INK},
    "symmetric, non-repeating": {"marker": "s", "markersize": 8, "color": SERIES[1], "fillstyle": "none"},
    "icosahedron, dodecahedron": {"marker": "*", "markersize": 13, "color": SERIES[2]},
    "optimized in the paper, Tables 1 and 2": {"marker": "^", "markersize": 8, "color": SERIES[0]},
}
AXES = ("x", "y", "z"), ("x^2", "y^2", "z^2"), ("x y", "x z", "z y")
REACH = (-1.12, 1.12), (-0.06, 1.12), (-0.62, 0.62)
# Curves that coincide are seen one through the other.
RINGS = (
    {"marker": "o", "markersize": 10, "fillstyle": "none", "color": SERIES[1], "linewidth": 0.8},
    {"marker": "s", "markersize": 6, "fillstyle": "none", "color": SERIES[2], "linewidth": 0.8},
    {"marker": ".", "markersize": 4, "color": SERIES[0], "linewidth": 0.8},
)


def draw_figure_2(
    points: Mapping[str, Sequence[tuple[int, float]]],
    optimized: Mapping[int, float],
    bound: Callable[[int], float],
    directory: Path,
) -> None:
    """D against n, as it is and as a multiple of the lower bound.

    Parameters
    ----------
    points : mapping
        From a class of `MARKS` to numbers of positions and D of its programs.
    optimized : mapping
        From a number of positions to the D of acalx's program.
    bound : function
        From a number of positions to the least D.
    """
    figure, panels = new_figure(10.4, 5.0, columns=2)
    numbers = list(optimized)
    scales: tuple[Callable[[float, int], float], ...] = (lambda d, n: d, lambda d, n: d / bound(n))
    for axes, scale in zip(panels, scales, strict=True):
        axes.plot(numbers, [scale(bound(n), n) for n in numbers], color="0.45", linewidth=1.0, label="lower bound")
        own = [scale(d, n) for n, d in optimized.items()]
        axes.plot(numbers, own, "o", color="0.45", markersize=3, label="optimized by acalx")
        for label, programs in points.items():
            places = [scale(d, n) for n, d in programs]
            axes.plot([n for n, _ in programs], places, linestyle="none", label=label, **MARKS[label])
        axes.set_yscale("log")
        axes.set_xlabel("positions n")
        axes.set_xticks(range(9, 37, 3))
        axes.grid(visible=True, color="0.85", linewidth=0.4)
    left, right = panels
    left.set_ylabel("D")
    right.set_ylabel("D / lower bound")
    right.set_yticks([1, 2, 5, 10, 20], ["1", "2", "5", "10", "20"])
    right.minorticks_off()
    figure.legend(*left.get_legend_handles_labels(), frameon=False, ncols=3, fontsize=9, loc="outside lower center")
    save(figure, directory, "figure_2")


def sorted_columns(regressors: Array) -> dict[str, Array]:
    """The entries of each column of H (n, 9), sorted, by group: (n, 3) each."""
    return {group: np.sort(regressors[:, 3 * k : 3 * k + 3], axis=0) for k, group in enumerate(GROUPS)}


def draw_figure_3(programs: Mapping[str, Array], directory: Path) -> None:
    """The sorted entries of H (n, 9), a curve a column, a panel a group, a row a program."""
    figure, panels = new_figure(10.4, 6.4, columns=3, rows=len(programs))
    for row, (title, regressors) in enumerate(programs.items()):
        for k, (group, columns) in enumerate(sorted_columns(regressors).items()):
            axes = panels[3 * row + k]
            _draw_columns(axes, columns, AXES[k])
            axes.set_title(f"{title}: {group}", fontsize=10)
            axes.set_ylim(*REACH[k])
            if row == len(programs) - 1:
                axes.set_xlabel("position, in the order of the entries")
        panels[3 * row].set_ylabel("entry of H")
    save(figure, directory, "figure_3")


def _draw_columns(axes: Axes, columns: Array, names: Sequence[str]) -> None:
    for column, name, style in zip(columns.T, names, RINGS, strict=True):
        axes.plot(np.arange(1, len(column) + 1), column, label=f"${name}$", **style)
    axes.set_xticks(range(3, len(columns) + 1, 3))
    axes.grid(visible=True, color="0.85", linewidth=0.4)
    axes.legend(frameon=False, fontsize=9)
