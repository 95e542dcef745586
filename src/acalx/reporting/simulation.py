"""The figure of simulated calibrations."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from acalx.reporting.figures import PALE, SERIES, new_figure, save
from acalx.simulation import Outcome

__all__ = ["draw_simulation"]

_MARKERS = "osD^vPX*"


def draw_simulation(outcomes: Sequence[Outcome], directory: Path) -> None:
    """Relative error of each parameter, and standard deviations achieved over predicted, with limits.

    Parameters
    ----------
    outcomes : sequence of Outcome
        One for each program, of the same model.
    directory : Path
    """
    names = [parameter.name for parameter in outcomes[0].information.parameters]
    width = max(9.6, 2.6 + 0.36 * len(names))
    figure, (left, right) = new_figure(width, 5.6 if len(names) > 12 else 4.6, columns=2)
    numbers = np.arange(len(names))
    right.axhline(1.0, color="0.3", linewidth=0.8)
    for k, outcome in enumerate(outcomes):
        at = numbers + 0.6 * ((k + 0.5) / len(outcomes) - 0.5)
        color, form = SERIES[k % len(SERIES)], _MARKERS[k % len(_MARKERS)]
        label = f"{outcome.name}, {outcome.n} positions"
        left.plot(at, 100.0 * outcome.relative_errors, form, color=color, markersize=4.5, label=label)
        ratio = outcome.deviations / outcome.predicted
        limits = outcome.deviation_limits / outcome.predicted[:, None]
        right.vlines(at, limits[:, 0], limits[:, 1], color=color, linewidth=1.0)
        right.plot(at, ratio, form, color=color, markersize=4)
    left.set_yscale("log")
    left.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    left.yaxis.set_minor_formatter(lambda value, _: f"{value:g}" if f"{value:.0e}"[0] in "25" else "")
    left.set_ylabel("relative error, %")
    left.set_title("error of an estimate over the size of the parameter", fontsize=10)
    right.set_ylabel("achieved / predicted")
    right.set_title(f"standard deviations with {100 * outcomes[0].confidence:g} % limits", fontsize=10)
    for axes in (left, right):
        axes.set_xticks(numbers, names, rotation=90, fontsize=8)
        axes.grid(visible=True, axis="y", color=PALE, linewidth=0.4)
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=2, frameon=False, fontsize=9)
    save(figure, directory, "simulation")
