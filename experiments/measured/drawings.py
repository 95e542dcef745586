"""The figures of the study of measured sensors."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from acalx.numerics.arrays import Array
from acalx.reporting.figures import new_figure, save

__all__ = ["draw_efficiency", "draw_sessions"]


def draw_efficiency(share: Array, error: Array, best: Array, directory: Path) -> None:
    """Error on the other positions against efficiency, with running quantiles."""
    figure, (axes,) = new_figure(7.2, 4.4)
    shown = np.random.default_rng(0).permutation(len(share))[:1200]
    axes.plot(share[shown], error[shown], ".", color="#b8c4d6", markersize=2.5, label="10 random positions of a triad")
    order = np.argsort(share)
    groups = np.array_split(order, 30)
    middle = [float(np.median(share[group])) for group in groups]
    for level, style, label in ((0.5, "-", "median"), (0.9, "--", "nine of ten are below")):
        line = [float(np.quantile(error[group], level)) for group in groups]
        axes.plot(middle, line, style, color="#2a6f97", label=label)
    axes.plot(best[:, 0], best[:, 1], "o", color="#c8553d", markersize=3.5, label="10 D-optimal positions of a triad")
    axes.set_yscale("log")
    axes.set_yticks([0.1, 0.3, 1, 3, 10], ["0.1", "0.3", "1", "3", "10"])
    axes.set_ylim(0.05, 20)
    axes.set_xlabel("D-efficiency of the positions that were used")
    axes.set_ylabel("root mean square on the others, mg")
    axes.grid(visible=True, color="0.85", linewidth=0.4)
    axes.legend(frameon=False, fontsize=9)
    save(figure, directory, "efficiency")


def draw_sessions(biases: Array, directory: Path) -> None:
    """Biases (sessions, triads, 3) in mg, less their means over the sessions."""
    figure, panels = new_figure(9.6, 3.6, columns=3)
    change = biases - biases.mean(axis=0)
    for k, (axes, axis) in enumerate(zip(panels, "xyz", strict=True)):
        axes.plot(np.arange(1, len(biases) + 1), change[..., k], "-o", markersize=3, linewidth=0.8)
        axes.set_title(f"bias {axis}", fontsize=10)
        axes.set_xlabel("session")
        axes.grid(visible=True, color="0.85", linewidth=0.4)
    panels[0].set_ylabel("less the mean of the triad, mg")
    save(figure, directory, "sessions")
