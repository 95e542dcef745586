"""Tables of text for the terminal and for pages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from acalx.numerics.arrays import Array
from acalx.quantities.magnitude import with_decimals, written_from_log
from acalx.quantities.parameter import Parameter
from acalx.sensors import Channel
from acalx.stands import Stand

__all__ = ["align", "figures_table", "markdown", "noises_in_words", "program_table", "units_line", "weights_table"]


def align(rows: Sequence[Sequence[str]]) -> str:
    """Rows of cells as text, the first column to the left and the others to the right."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [
            cell.ljust(w) if k == 0 else cell.rjust(w) for k, (cell, w) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def markdown(rows: Sequence[Sequence[str]]) -> str:
    """Rows of cells as a Markdown table, the first row its head."""
    head, *body = rows
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *body]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def program_table(stand: Stand, settings: Array, held: int = 0, most: int = 60) -> str:
    """Positions of a program with its settings, angles in degrees, and the vertical in sensor axes.

    The first `held` ones are marked as fixed.
    """
    force = stand.stimulus(settings).vertical()
    rows = [["position", *(f"{setting.name} {setting.unit.symbol}" for setting in stand.settings)]]
    if force is not None:
        rows[0] += ["eta x", "eta y", "eta z"]
    for k, angles in enumerate(stand.axes.written(settings[:most])):
        row = [f"{k + 1} fixed" if k < held else str(k + 1), *(f"{angle:.2f}" for angle in np.round(angles, 2) + 0.0)]
        if force is not None:
            row += [f"{value:+.4f}" for value in np.round(force[k], 4) + 0.0]
        rows.append(row)
    text = align(rows)
    if len(settings) > most:
        text += f"\n... {len(settings) - most} more in program.csv"
    return text


def weights_table(stand: Stand, settings: Array, weights: Array, most: int = 20) -> str:
    """Support points of an approximate design, the heaviest first, with their shares of the time in percent."""
    order = np.argsort(-weights, kind="stable")
    force = stand.stimulus(settings).vertical()
    rows = [["support point", *(f"{setting.name} {setting.unit.symbol}" for setting in stand.settings)]]
    rows[0] += [] if force is None else ["eta x", "eta y", "eta z"]
    rows[0].append("dwell share")
    for number, k in enumerate(order[:most], 1):
        row = [str(number), *(f"{angle:.2f}" for angle in np.round(stand.axes.written(settings[k]), 2) + 0.0)]
        row += [] if force is None else [f"{value:+.4f}" for value in np.round(force[k], 4) + 0.0]
        rows.append([*row, f"{100 * weights[k]:.3f} %"])
    text = align(rows)
    if len(order) > most:
        rest = 100 * weights[order[most:]].sum()
        text += f"\n... {len(order) - most} more with {rest:.3f} % in weights.csv"
    return text


def figures_table(columns: Mapping[str, Mapping[str, Any]]) -> list[list[str]]:
    """Figures of merit (see `acalx.planning.metrics`) of one or several programs side by side.

    Parameters
    ----------
    columns : mapping
        From the name of a program to its figures.

    Returns
    -------
    list of rows of cells, the first row the head
    """
    first = next(iter(columns.values()))
    rows = [["", *columns]]
    for key in ("D", "A", "E"):
        rows.append([key, *(written_from_log(metrics[f"log_{key}"]) for metrics in columns.values())])
    for group in first["theta"]:
        rows.append([f"theta {group}", *(with_decimals(metrics["theta"][group]) for metrics in columns.values())])
    for group in first["inequality"]:
        cells = [f"{100 * metrics['inequality'][group] + 0.0:.3f} %" for metrics in columns.values()]
        rows.append([f"inequality {group}", *cells])
    rows.append(["condition number", *(f"{metrics['condition_number']:.4g}" for metrics in columns.values())])
    return rows


def units_line(parameters: Iterable[Parameter], channels: Iterable[Channel] = ()) -> str:
    """In which units the standard deviations of each group are, and for what noise of the readings."""
    units: dict[str, list[str]] = {}
    for parameter in parameters:
        of_group = units.setdefault(parameter.group, [])
        if parameter.unit not in of_group:
            of_group.append(parameter.unit)
    text = "units: " + ", ".join(f"{group} {' and '.join(names)}" for group, names in units.items())
    noise = noises_in_words(channels)
    return f"{text}; for a noise of {noise}" if noise else text


def noises_in_words(channels: Iterable[Channel]) -> str:
    """How large the noise of the readings is that a model tells: a number for each unit and size."""
    return " and ".join(dict.fromkeys(f"{channel.noise:.4g} {channel.unit}" for channel in channels))
