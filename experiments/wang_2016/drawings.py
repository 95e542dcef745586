"""The figures of the study of Wang et al. (2016), numbered as in the paper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from acalx.numerics.arrays import Array
from acalx.quantities.parameter import Parameter
from acalx.reporting.figures import PALE, SERIES, new_figure, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Curve(NamedTuple):
    """Determinants of all sequences against the number of positions.

    Parameters
    ----------
    title : str
    numbers : array (k,)
        Numbers of positions N.
    values : array (s, k)
        log det of the information per measurement; -inf where a coefficient is not seen.
    """

    title: str
    numbers: Array
    values: Array

    @property
    def best(self) -> Array:
        """The largest of each N, (k,)."""
        return np.asarray(self.values.max(axis=0))


def draw_determinants(curves: Sequence[Curve], directory: Path, name: str, before: int = 0) -> None:
    """Determinants against N, or against the positions beyond a number of them, with a panel a curve.

    Parameters
    ----------
    before : int
        What is taken off N along the axis, 7 in the paper's Figure 3.
    """
    figure, panels = new_figure(9.6, 4.2, columns=len(curves))
    for axes, curve in zip(panels, curves, strict=True):
        _draw_curve(axes, curve, before)
    panels[0].set_ylabel("log det of the information per measurement")
    figure.legend(*panels[0].get_legend_handles_labels(), frameon=False, ncols=3, loc="outside lower center")
    save(figure, directory, name)


def _draw_curve(axes: Axes, curve: Curve, before: int) -> None:
    from matplotlib.ticker import MaxNLocator

    row, column = np.nonzero(np.isfinite(curve.values))
    places = curve.numbers - before
    axes.plot(places[column], curve.values[row, column], ".", color=PALE, markersize=5, label="144 sequences")
    axes.plot(places, curve.best, "o-", color=SERIES[1], markersize=4, label="the best of them")
    k = int(np.argmax(curve.best > curve.best.max() - 1e-9))  # of equal ones the shortest
    axes.plot(places[k], curve.best[k], "o", color=SERIES[0], markersize=9, label="the largest")
    axes.annotate(
        f"N = {curve.numbers[k]}", (places[k], curve.best[k]), xytext=(0, 8), textcoords="offset points", ha="center"
    )
    # the worst sequences would press all others together
    reach = curve.best.max() - curve.best[np.isfinite(curve.best)].min()
    axes.set_ylim(curve.best.max() - 1.6 * reach, curve.best.max() + 0.25 * reach)
    axes.set_title(curve.title, fontsize=10)
    axes.set_xlabel(f"N - {before}" if before else "positions N")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.grid(visible=True, color=PALE, linewidth=0.4)


def draw_relative_errors(errors: Mapping[str, Array], parameters: Sequence[Parameter], directory: Path) -> None:
    """Relative error of each coefficient, as in the paper's Figure 4.

    Parameters
    ----------
    errors : mapping
        From the name of a program to errors over the size of the true coefficients, (36,).
    """
    figure, (axes,) = new_figure(9.6, 4.4)
    numbers = np.arange(1, len(parameters) + 1)
    for (name, each), marker, color in zip(errors.items(), "s^oD", SERIES, strict=True):
        axes.semilogy(numbers, 100.0 * each, marker, color=color, markersize=5, label=name)
    first = [k for k in range(len(parameters)) if k == 0 or parameters[k].name[:7] != parameters[k - 1].name[:7]]
    for k in first[1:]:
        axes.axvline(k + 0.5, color=PALE, linewidth=0.6)
    for k in first:
        axes.annotate(
            parameters[k].name[:7].replace("_", " ").strip(), (k + 0.7, 1.015), xycoords=("data", "axes fraction")
        )
    misaligned = [k + 1 for k, parameter in enumerate(parameters) if parameter.group == "gyro_misalignment"]
    for k in misaligned:
        axes.axvspan(k - 0.5, k + 0.5, color=PALE, alpha=0.35, linewidth=0)
    axes.set_xlim(0.0, 37.0)
    axes.set_xlabel("coefficient, in the order of the model; shaded: misalignments of the gyros")
    axes.set_ylabel("relative error, %")
    axes.grid(visible=True, axis="y", color=PALE, linewidth=0.4)
    figure.legend(frameon=False, ncols=4, loc="outside lower center")
    save(figure, directory, "figure_4")
