"""The figure of a calibration's residuals."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from acalx.estimation import Calibration
from acalx.estimation.residuals import names_of_residuals
from acalx.numerics.arrays import Array
from acalx.reporting.figures import new_figure, save

__all__ = ["draw_residuals"]

_BLUE, _RED, _PALE = "#2a6f97", "#c8553d", "#b8c4d6"
# What of the distance between positions the residuals of one take.
_WIDTH = 0.6
# Of the residuals of a position, where they are those of channels.
_COLORS = (_BLUE, "#e09f3e", "#5b8e7d", "#7d5ba6", "#8c6d46", "#4a4e69")


def draw_residuals(calibration: Calibration, directory: Path) -> None:
    """Residuals by position, and whether they scatter as normal noise does.

    A band of two standard deviations of the noise is shaded where that is known; positions that
    the others contradict are ringed.
    """
    from scipy.special import ndtri

    studentized, (unit, residual, noise) = calibration.studentized, _in_unit(calibration)
    figure, (left, right) = new_figure(9.6, 4.0, columns=2)
    each, n = calibration.model.outputs, calibration.readings.n
    numbers = np.repeat(np.arange(1, n + 1), each)
    # those of a position side by side
    places = numbers + np.tile((np.arange(each) - 0.5 * (each - 1)) * _WIDTH / each, n)
    names = names_of_residuals(calibration.model) if 1 < each <= len(_COLORS) else [""]
    if np.isfinite(noise):
        left.axhspan(-2.0 * noise, 2.0 * noise, color=_PALE, alpha=0.35, linewidth=0)
    for name, color, which in _by_name(names, len(residual)):
        left.vlines(places[which], 0, residual[which], color=color, linewidth=1.0)
        left.plot(places[which], residual[which], "o", color=color, markersize=4, label=name)
    left.axhline(0.0, color="0.3", linewidth=0.8)
    far = np.array(calibration.outlying, dtype=int)
    ringed = np.isin(numbers, far)
    left.plot(places[ringed], residual[ringed], "o", markersize=11, fillstyle="none", color=_RED)
    left.locator_params(axis="x", integer=True)
    left.set_xlabel("position")
    left.set_ylabel(f"residual, {unit}")
    left.set_title("what the calibration leaves; shaded: two standard deviations", fontsize=10)
    order = np.argsort(studentized)
    judged = order[np.isfinite(studentized[order])]
    if len(judged):
        normal = ndtri((np.arange(len(judged)) + 0.5) / len(judged))
        ends = np.array([min(normal[0], studentized[judged[0]]), max(normal[-1], studentized[judged[-1]])]) * 1.08
        right.plot(ends, ends, color="0.3", linewidth=0.8)
        for _, color, which in _by_name(names, len(residual)):
            own = np.isin(judged, which)
            right.plot(normal[own], studentized[judged][own], "o", color=color, markersize=4)
        ringed = np.isin(numbers[judged], far)
        right.plot(normal[ringed], studentized[judged][ringed], "o", markersize=11, fillstyle="none", color=_RED)
    else:
        right.text(0.5, 0.5, "nothing is left to judge by", transform=right.transAxes, ha="center")
    right.set_xlabel("expected of normal noise")
    right.set_ylabel("studentized residual")
    right.set_title("scatter; on the line where the noise is normal", fontsize=10)
    for axes in (left, right):
        axes.grid(visible=True, color=_PALE, linewidth=0.4)
    if len(names) > 1:
        figure.legend(loc="outside lower center", ncols=len(names), frameon=False, fontsize=9)
    save(figure, directory, "residuals")


def _by_name(names: list[str], count: int) -> list[tuple[str, str, np.ndarray]]:
    """For each residual of a position its name, its color, and where it is among all of them."""
    return [(name, _COLORS[k], np.arange(k, count, len(names))) for k, name in enumerate(names)]


def _in_unit(calibration: Calibration) -> tuple[str, Array, float]:
    """Residuals as they are shown, with their unit and their standard deviation: of g in thousandths."""
    noises = calibration.noises
    if len(noises) > 1:  # each in units of its own
        return "over the noise", calibration.estimate.scaled, 1.0
    ((unit, noise),) = noises.items()
    residual = calibration.estimate.residual * calibration.size_of_residuals
    return ("mg", 1e3 * residual, 1e3 * noise) if unit == "g" else (unit, residual, noise)
