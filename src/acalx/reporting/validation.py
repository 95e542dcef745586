"""The figure of a validation."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from acalx.numerics.arrays import Array
from acalx.reporting.figures import new_figure, save

__all__ = ["draw_validation"]

_PALE, _COLORS = "#b8c4d6", ("#8d6b94", "#c8553d", "#2a6f97")


def draw_validation(before: Array, after: Array, programs: Sequence[tuple[str, float, float]], directory: Path) -> None:
    """Residuals of positions that a calibration has not seen, and programs by their efficiency.

    Parameters
    ----------
    before, after : array (t,), in g
        Residuals without the calibration and with it.
    programs : sequence of (name, efficiency, rms in g)
    directory : Path
    """
    figure, (left, right) = new_figure(11.0, max(4.2, 0.24 * len(programs) + 1.0), columns=2)
    for residual, label, color in ((before, "not calibrated", _COLORS[0]), (after, "calibrated", _COLORS[2])):
        size = np.sort(1e3 * np.abs(residual[np.isfinite(residual)]))
        left.semilogx(
            np.maximum(size, 1e-3), (np.arange(len(size)) + 0.5) / max(1, len(size)), color=color, label=label
        )
    left.set_xlabel("residual of a position that was left out, mg")
    left.set_ylabel("share of the positions")
    left.legend(frameon=False)
    shown = [row for row in programs if np.isfinite(row[2]) and row[1] > 0]
    for k, (name, _, rms) in enumerate(shown):
        kind = 0 if name.startswith("random") else 1 if name.startswith("best") else 2
        right.plot(1e3 * rms, k, "so^"[kind], color=_COLORS[kind], markersize=6)
    if shown:
        right.set_yticks(range(len(shown)), [f"{name}  ({share:.2f})" for name, share, _ in shown], fontsize=8)
        right.invert_yaxis()
        right.set_xlim(left=0.0)
        right.set_title("programs on the measured positions (D-efficiency)", fontsize=10)
    else:
        right.text(0.5, 0.5, "no program leaves positions to test on", transform=right.transAxes, ha="center")
    right.set_xlabel("root mean square on the other positions, mg")
    for axes in (left, right):
        axes.grid(visible=True, color=_PALE, linewidth=0.4)
    save(figure, directory, "validation")
