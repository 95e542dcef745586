"""What acalx.validate shows of a validation: tables and the figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from acalx.numerics.arrays import Array
from acalx.quantities.magnitude import with_decimals
from acalx.reporting.figures import new_figure, save
from acalx.reporting.tables import align
from acalx.validation import Compared, Validated

__all__ = ["draw", "draw_validation", "show"]

_MOST_SHOWN = 20

_PALE, _COLORS = "#b8c4d6", ("#8d6b94", "#c8553d", "#2a6f97")


def draw_validation(
    before: Array, after: Array, programs: Sequence[Compared], directory: Path, unit: str = "g"
) -> None:
    """Residuals of positions that a calibration has not seen, and programs by their efficiency.

    Parameters
    ----------
    before, after : array (t,)
        Residuals without the calibration and with it.
    programs : sequence of Compared
    directory : Path
    unit : str
        Of the residuals, as of `Validated`.
    """
    name, factor = _shown_in(unit)
    figure, (left, right) = new_figure(11.0, max(4.2, 0.24 * len(programs) + 1.0), columns=2)
    for residual, label, color in ((before, "not calibrated", _COLORS[0]), (after, "calibrated", _COLORS[2])):
        size = np.sort(factor * np.abs(residual[np.isfinite(residual)]))
        left.semilogx(
            np.maximum(size, 1e-3), (np.arange(len(size)) + 0.5) / max(1, len(size)), color=color, label=label
        )
    left.set_xlabel(f"residual of a position that was left out, {name}")
    left.set_ylabel("share of the positions")
    left.legend(frameon=False)
    shown = [row for row in programs if np.isfinite(row.rms)]
    for k, row in enumerate(shown):
        kind = ("random", "best", "program").index(row.kind)
        right.plot(factor * row.rms, k, "so^"[kind], color=_COLORS[kind], markersize=6)
    if shown:
        right.set_yticks(range(len(shown)), [_labeled(row) for row in shown], fontsize=8)
        right.invert_yaxis()
        right.set_xlim(left=0.0)
        right.set_title("programs on the measured positions (D-efficiency)", fontsize=10)
    else:
        right.text(0.5, 0.5, "no program leaves positions to test on", transform=right.transAxes, ha="center")
    right.set_xlabel(f"root mean square on the other positions, {name}")
    for axes in (left, right):
        axes.grid(visible=True, color=_PALE, linewidth=0.4)
    save(figure, directory, "validation")


def draw(validated: Validated, directory: Path) -> None:
    """The figure of all sensors together."""
    before = np.concatenate([sensor.left_out.before for sensor in validated.sensors])
    after = np.concatenate([sensor.left_out.after for sensor in validated.sensors])
    draw_validation(before, after, validated.programs, directory, validated.unit)


def show(validated: Validated) -> None:
    """How right the calibration of each sensor is, their medians, and the programs that were compared."""
    count = len(validated.sensors)
    print(f"{_sensors(validated)}\n")
    if count > _MOST_SHOWN:
        print(f"... {count - _MOST_SHOWN} more in validation.csv\n")
    if programs := validated.programs:
        print(f"{_programs(programs, validated.unit)}\n")


def _sensors(validated: Validated) -> str:
    """A row for each sensor, and one for the medians of several."""
    medians, count = validated.medians, len(validated.sensors)
    ways = [key.removesuffix("_r_squared") for key in medians if key.endswith("_r_squared")]
    rows = [["sensor", "positions"]]
    for way in ways:
        rows[0] += [f"{way.replace('_', ' ')} R^2", f"rms {_shown_in(validated.unit)[0]}"]
    listed: list[tuple[str, str, Mapping[str, float]]]
    listed = [(s.name, str(s.n), s.figures) for s in validated.sensors[:_MOST_SHOWN]]
    if count > 1:
        listed.append((f"median of {count}", "", medians))
    for name, n, figures in listed:
        row = [name, n]
        for way in ways:
            rms = figures.get(f"{way}_rms_{validated.unit}")
            row += _right(figures.get(f"{way}_r_squared"), rms, validated.unit)
        rows.append(row)
    return align(rows)


def _programs(programs: Sequence[Compared], unit: str) -> str:
    """A row for each choice of positions."""
    rows = [
        ["calibrated on the nearest to", "positions", "angle deg", "efficiency", "R^2", f"rms {_shown_in(unit)[0]}"]
    ]
    for row in programs:
        angle = "-" if np.isnan(row.angle_deg) else f"{row.angle_deg:.1f}"
        share = "-" if np.isnan(row.efficiency) else f"{row.efficiency:.3f}"
        rows.append([row.name, str(row.n), angle, share, *_right(row.r_squared, row.rms, unit)])
    return align(rows)


def _right(r_squared: float | None, rms: float | None, unit: str) -> list[str]:
    """R^2 and rms; "can't" where the positions left for the calibration can't show all the parameters."""
    if r_squared is None or rms is None:
        return ["-", "-"]
    # to four decimals, or to four digits where those would be fewer
    return [f"{r_squared:.5f}", with_decimals(_shown_in(unit)[1] * rms)] if np.isfinite(rms) else ["can't", "-"]


def _labeled(row: Compared) -> str:
    return row.name if np.isnan(row.efficiency) else f"{row.name}  ({row.efficiency:.2f})"


def _shown_in(unit: str) -> tuple[str, float]:
    """What residuals are shown in, and the factor: thousandths of g; anything else as it is."""
    return ("mg", 1e3) if unit == "g" else ("of the noise" if unit == "relative" else unit, 1.0)
