"""What acalx.simulate shows of simulated calibrations: tables, verdicts, the figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from acalx.quantities.magnitude import significant
from acalx.reporting.figures import PALE, SERIES, new_figure, save
from acalx.reporting.tables import align, noises_in_words, units_line
from acalx.sensors import Channel
from acalx.simulation import Outcome, Simulated

__all__ = ["draw_simulation", "show"]

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


def show(simulated: Simulated) -> None:
    """For each program what came out by group and by parameter, and whether theory predicts it."""
    channels = simulated.model.channels
    for outcome in simulated.outcomes.values():
        print(f"{outcome.name}: {outcome.n} positions, {outcome.trials} trials\n")
        print(f"{_groups(outcome)}\n\n{_parameters(outcome)}\n\n{outcome.summary()}\n{_relative(outcome, channels)}\n")
    print(f"s, theta and bias of groups are divided by the noise, {simulated.errors.noise:g}")
    print(units_line(simulated.model.parameters))


def _groups(outcome: Outcome) -> str:
    """The table of the groups of parameters."""
    rows = [["group", "s", "limits", "theta", "agree", "inequality", "predicted", "largest bias"]]
    for group, entry in outcome.groups.items():
        low, high = entry["s_limits"]
        rows.append(
            [
                group,
                f"{entry['s']:.4g}",
                f"{low:.4g} to {high:.4g}",
                f"{entry['theta']:.4g}",
                "yes" if entry["as_predicted"] else "no",
                _percent(entry.get("inequality")),
                _percent(entry.get("inequality_predicted")),
                significant(entry["bias"] / outcome.noise),
            ]
        )
    return align(rows)


def _parameters(outcome: Outcome) -> str:
    """The table of the parameters."""
    percent = f"{100 * outcome.confidence:g} %"
    rows = [["parameter", "bias", f"{percent} limits", "deviation", f"{percent} limits", "predicted", "", "covered"]]
    for k, parameter in enumerate(outcome.information.parameters):
        low, high = outcome.bias_limits[k]
        least, most = outcome.deviation_limits[k]
        rows.append(
            [
                parameter.name,
                f"{outcome.bias[k]:+.3e}",
                f"{low:+.3e} to {high:+.3e}",
                f"{outcome.deviations[k]:.4g}",
                f"{least:.4g} to {most:.4g}",
                f"{outcome.predicted[k]:.4g}",
                "" if outcome.as_predicted[k] else "outside",
                f"{100 * outcome.coverage[k]:.1f} %",
            ]
        )
    return align(rows)


def _relative(outcome: Outcome, channels: Sequence[Channel]) -> str:
    """Error of the worst parameter relative to its own size, and a question where that is too large to be meant."""
    errors = np.nan_to_num(outcome.relative_errors, posinf=0.0)  # of a parameter that is zero there is none
    worst = int(errors.argmax())
    name = outcome.information.parameters[worst].name
    text = f"largest error relative to the parameter: {100 * errors[worst]:.3g} %, {name}"
    if errors[worst] > 1.0:
        text += (
            f"; more than the parameter itself: does the program show it, and is the noise that of the sensor? It is "
            f"errors.noise, {outcome.noise:g}, times what the model says, {noises_in_words(channels)}"
        )
    return text


def _percent(share: float | None) -> str:
    return "-" if share is None else f"{100 * share:.2f} %"
