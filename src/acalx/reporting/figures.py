"""Figures of a run, as SVG and PNG.

Matplotlib is imported only when a figure is drawn.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "INK",
    "LARGEST_DRAWN",
    "PALE",
    "SERIES",
    "draw_convergence",
    "draw_entries",
    "draw_landscape",
    "draw_positions",
    "draw_verticals",
    "new_figure",
    "save",
]

# Differences of losses below it are rounding.
_ROUNDING = 1e-9
# Logarithms up to which values are drawn, not their logarithms.
LARGEST_DRAWN = 600.0
INK, PALE, SERIES = "#1b2a41", "#b8c4d6", ("#c8553d", "#2a6f97", "#588157", "#8d6b94")
_STYLE: dict[Any, Any] = {
    "font.size": 10.0,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "axes.prop_cycle": f"cycler(color={list(SERIES)})",
    "svg.fonttype": "none",
    "svg.hashsalt": "acalx",  # the same figure gives the same file
}


def new_figure(width: float, height: float, columns: int = 1, rows: int = 1) -> tuple[Figure, list[Axes]]:
    """A figure with axes side by side, row after row, in inches; no window is ever opened."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        axes = figure.subplots(rows, columns, squeeze=False)
    return figure, list(axes.flat)


def save(figure: Figure, directory: Path, name: str) -> None:
    """Write a figure as SVG and PNG."""
    import matplotlib as mpl

    with mpl.rc_context(_STYLE):
        figure.savefig(directory / f"{name}.png", dpi=150)
        figure.set_layout_engine("none")  # as it is laid out by now
        figure.savefig(directory / f"{name}.svg", metadata={"Date": None})


def draw_verticals(stimulus: Stimulus, directory: Path, title: str) -> None:
    """Where the vertical is in sensor axes, and while the sensor is turned; nothing where it is not felt."""
    if "specific_force" not in stimulus:
        return
    force = stimulus["specific_force"]
    if stimulus.weights is None:
        draw_positions(force, directory, title)
        return
    least, most = (force.shape[1] - 1) // 2, force.shape[1] // 2  # of the samples those about the middle
    middle = force[:, least] + force[:, most]
    middle = middle / np.linalg.norm(middle, axis=1, keepdims=True)
    draw_positions(middle, directory, f"{title}; small: while it is turned", force)


def draw_positions(directions: Array, directory: Path, title: str, along: Array | None = None) -> None:
    """Directions of the vertical in sensor axes, (n, 3), on the two halves of the sphere.

    Lambert's azimuthal equal-area projection: equal densities look equal everywhere. Where the vertical is at other
    times, (n, K, 3), is smaller.
    """
    others = np.zeros((0, 3)) if along is None else along.reshape(-1, 3)
    figure, halves = new_figure(8.2, 4.6, columns=2)
    upper = directions[:, 2] >= -1e-12
    for axes, side, label in (
        (halves[0], 1.0, "vertical on the +z side"),
        (halves[1], -1.0, "vertical on the -z side"),
    ):
        _draw_half(axes, side, label)
        passed = _project(others[(others[:, 2] >= 0.0) == (side > 0)], side)
        axes.plot(passed[:, 0], passed[:, 1], "o", color=SERIES[1], markersize=2)
        shown = upper if side > 0 else ~upper
        points = _project(directions[shown], side)
        axes.plot(points[:, 0], points[:, 1], "o", color=SERIES[0], markersize=7 if len(directions) < 60 else 4)
        if len(directions) <= 60:
            numbers = np.flatnonzero(shown) + 1
            for number, (x, y) in zip(numbers, points, strict=True):
                axes.annotate(str(number), (x, y), xytext=(5, 4), textcoords="offset points", fontsize=9)
    figure.suptitle(title)
    save(figure, directory, "positions")


def _draw_half(axes: Axes, side: float, label: str) -> None:
    turn = np.linspace(0, 2 * np.pi, 361)
    for tilt in (30, 60, 90):
        circle = np.radians(tilt)
        ring = np.stack(
            [np.sin(circle) * np.cos(turn), np.sin(circle) * np.sin(turn), side * np.full_like(turn, np.cos(circle))],
            -1,
        )
        x, y = _project(ring, side).T
        axes.plot(x, y, color=INK if tilt == 90 else PALE, linewidth=1.2 if tilt == 90 else 0.6)
    edge = np.sqrt(2.0)
    axes.plot([-edge, edge], [0, 0], color=PALE, linewidth=0.6)
    axes.plot([0, 0], [-edge, edge], color=PALE, linewidth=0.6)
    axes.text(edge * 1.03, -0.13, "+x", va="center")
    axes.text(-0.16, edge * 1.04, "+y", ha="center")
    axes.set_title(label, fontsize=10)
    axes.set_aspect("equal")
    axes.set_xlim(-1.62, 1.62)
    axes.set_ylim(-1.55, 1.62)
    axes.axis("off")


def _project(directions: Array, side: float) -> Array:
    """Equal-area projection of the half with z of the sign of `side`, seen with x to the right."""
    height = np.clip(side * directions[:, 2], 0.0, 1.0)
    return np.asarray(directions[:, :2] * np.sqrt(2.0 / (1.0 + height))[:, None])


def draw_convergence(history: Sequence[tuple[int, float, float]], directory: Path) -> None:
    """Best loss above the final one against evaluations, on logarithmic scales."""
    figure, (axes,) = new_figure(6.0, 3.8)
    evaluations = np.array([row[0] for row in history], dtype=float)
    losses = np.array([row[2] for row in history])
    above = losses - losses[-1]
    shown = above > _ROUNDING
    if shown.any():
        ends = np.maximum(above, _ROUNDING)  # the last one is none above itself: down to what is rounding
        axes.loglog(evaluations, ends, drawstyle="steps-post", color=SERIES[1])
    else:
        axes.text(0.5, 0.5, "the first program was the best", transform=axes.transAxes, ha="center")
    axes.set_xlabel("programs evaluated")
    axes.set_ylabel("best loss so far, above the final one")
    axes.set_title(f"final loss {losses[-1]:.6g}")
    axes.grid(visible=True, color=PALE, linewidth=0.4)
    save(figure, directory, "convergence")


def draw_landscape(numbers: Array, losses: Array, directory: Path, name: str = "landscape") -> None:
    """Value of the information per measurement against the number of positions, of all sequences.

    After Figures 2 and 3 of Wang, Wang, Shen, Qin (2016): for D it is the determinant of H'H / N.

    Parameters
    ----------
    numbers : array (k,)
    losses : array (s, k)
        Per measurement; inf where singular.
    """
    from matplotlib.ticker import MaxNLocator

    figure, (axes,) = new_figure(6.0, 3.8)
    finite = np.isfinite(losses)
    row, column = np.nonzero(finite)
    label = f"{len(losses)} sequences"
    # decimal logarithms where no doubles hold the values
    drawn = np.abs(losses[finite]).max() < LARGEST_DRAWN
    plot, value = (axes.semilogy, np.exp) if drawn else (axes.plot, lambda log: log / np.log(10.0))
    plot(numbers[column], value(-losses[row, column]), ".", color=PALE, markersize=4, label=label)
    some = finite.any(axis=0)
    best = value(-losses[:, some].min(axis=0))
    plot(numbers[some], best, "o-", color=SERIES[1], markersize=4, label="the best of them")
    k = int(best.argmax())
    plot(numbers[some][k], best[k], "o", color=SERIES[0], markersize=8, label="chosen")
    axes.set_xlabel("positions N")
    axes.set_ylabel("1 / criterion, per measurement" if drawn else "-log10 criterion, per measurement")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.grid(visible=True, color=PALE, linewidth=0.4)
    axes.legend(frameon=False)
    save(figure, directory, name)


def draw_entries(programs: Mapping[str, Array], directory: Path, name: str = "entries") -> None:
    """Sorted entries of the regressor matrix H of one or several programs.

    A program that uses all that a stand offers fills the range evenly; one of high symmetry
    repeats values and has many zeros. Zeros that only say that an output has nothing to do with
    a parameter are left out. After Figure 3 of Egorov, Kiryachenko, Popov (2021).

    Parameters
    ----------
    programs : mapping
        From a label to regressors, arrays of any shape.
    """
    figure, (axes,) = new_figure(6.0, 3.8)
    for (label, regressors), color in zip(programs.items(), SERIES, strict=False):
        entries = np.sort(_dependent(regressors).ravel())
        axes.plot((np.arange(len(entries)) + 0.5) / len(entries), entries, ".", color=color, markersize=4, label=label)
    axes.set_xlabel("share of the entries of H")
    axes.set_ylabel("entry")
    axes.grid(visible=True, color=PALE, linewidth=0.4)
    axes.legend(frameon=False)
    save(figure, directory, name)


def _dependent(regressors: Array) -> Array:
    """Without the zeros of parameters that an output of several, (n, m, p), does not depend on."""
    if regressors.ndim != 3 or regressors.shape[1] == 1:
        return regressors
    return np.asarray(regressors[:, (regressors != 0.0).any(axis=0)])
