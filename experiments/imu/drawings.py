"""The figures of the study."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from programs import GROUPS, KNOWN, Accuracy
from recipes import RECIPES

from acalx.numerics.arrays import Array
from acalx.quantities.parameter import parameter_groups
from acalx.reporting.figures import INK, PALE, SERIES, new_figure, save

__all__ = ["draw_drift", "draw_standard_errors"]

_MARKS = ("o", "s", "^")
_APART = 0.27


def draw_standard_errors(pairs: Sequence[tuple[Accuracy, Accuracy]], directory: Path) -> None:
    """Standard errors of each group, each recipe beside the joint program of as many positions."""
    figure, (axes,) = new_figure(11.0, 5.4)
    before = [float(one.scatter or 0.0) for one in KNOWN.parameters]
    groups = parameter_groups(KNOWN.parameters)
    for k, (recipe, joint) in enumerate(pairs):
        color, mark = SERIES[k], _MARKS[k]
        for place, (group, told) in enumerate(GROUPS.items()):
            x = place + _APART * (k - 1)
            other = joint.of(group)[0]
            value, shown, count = recipe.of(group)
            known = told.factor * before[groups[group][0]]
            top = known if shown < count else value
            axes.plot([x, x], [other, top], color=color, linewidth=1.2, alpha=0.45, zorder=1)
            if shown:
                axes.plot(x, value, mark, color=color, markersize=8, zorder=3)
            if shown < count:
                axes.plot(x, known, mark, color=color, markersize=8, markerfacecolor="white", zorder=3)
                label = f"{count - shown} of {count}"
                height = 20 if k == 1 and group == "accel_arm" else 8  # the middle one of three above its neighbors
                axes.annotate(label, (x, known), (0, height), textcoords="offset points", ha="center", fontsize=8)
            axes.plot(x, other, "D", color=INK, markersize=5, zorder=4)
    _legend(axes)
    axes.set_yscale("log")
    axes.set_xlim(-0.6, len(GROUPS) - 0.4)
    axes.set_ylim(4.0, 40000.0)
    axes.set_yticks([10, 100, 1000, 10000], ["10", "100", "1,000", "10,000"])
    labels = [f"{told.title.replace(' ', chr(10), 1)}\n{told.unit}" for told in GROUPS.values()]
    axes.set_xticks(range(len(GROUPS)), labels)
    axes.tick_params(axis="x", length=0)
    axes.set_ylabel("largest standard error of the group, in its unit")
    axes.grid(visible=True, axis="y", color=PALE, linewidth=0.5)
    for edge in np.arange(0.5, len(GROUPS) - 1):
        axes.axvline(edge, color=PALE, linewidth=0.5)
    save(figure, directory, "standard_errors")


def _legend(axes: object) -> None:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

    assert isinstance(axes, Axes)  # as `new_figure` makes them
    handles = [
        Line2D([], [], linestyle="", marker=mark, color=color, markersize=8, label=f"{recipe.title}, n = {recipe.n}")
        for recipe, mark, color in zip(RECIPES.values(), _MARKS, SERIES, strict=False)
    ]
    joint = "joint D-optimal program of as many positions"
    handles.append(Line2D([], [], linestyle="", marker="D", color=INK, markersize=5, label=joint))
    hollow = {"marker": "o", "color": "0.4", "markerfacecolor": "white", "markersize": 8}
    not_shown = "so many of the group are not shown: what was known before"
    handles.append(Line2D([], [], linestyle="", label=not_shown, **hollow))
    axes.legend(handles=handles, frameon=False, fontsize=9, loc="upper left", bbox_to_anchor=(0.0, 0.97))


def draw_drift(times: Sequence[Array], readings: Sequence[Array], vertical: Array, directory: Path) -> None:
    """A gyro at rest through several sessions, and the vertical along one axis meanwhile.

    Parameters
    ----------
    times : sequence of array (n,), s
    readings : sequence of array (n,), deg/s
        Of one gyro in each session.
    vertical : array (n,)
        Component of the vertical in the first session.
    """
    figure, (left, right) = new_figure(9.6, 3.6, columns=2)
    for time, reading in zip(times, readings, strict=True):
        minutes = (time - time[0]) / 60.0
        left.plot(minutes, 1e3 * (reading - reading.mean()), "-o", color=SERIES[1], markersize=2.5, linewidth=0.8)
    left.set_ylabel("less its mean, mdeg/s")
    right.plot((times[0] - times[0][0]) / 60.0, vertical, "-o", color=INK, markersize=3, linewidth=0.8)
    right.set_ylabel("vertical along y, g")
    for axes in (left, right):
        axes.set_xlabel("minutes since the first position")
        axes.grid(visible=True, color="0.85", linewidth=0.4)
    left.set_title("x gyro of unit 1, nine sessions", fontsize=10)
    right.set_title("the positions, in their order", fontsize=10)
    save(figure, directory, "drift")
