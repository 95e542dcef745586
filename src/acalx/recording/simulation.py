"""What a run of acalx.simulate leaves in its directory."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from acalx.recording.run_directory import RunDirectory
from acalx.simulation import Simulated

__all__ = ["record", "record_result"]

_COLUMNS = (
    *("bias", "bias_low", "bias_high", "standard_deviation", "standard_deviation_low", "standard_deviation_high"),
    *("predicted", "as_predicted", "relative_error", "coverage"),
)


def record(simulated: Simulated, errors: Mapping[str, Any], directory: RunDirectory) -> None:
    """simulation.json with all outcomes, and simulation.csv with a row for each parameter of each program.

    Parameters
    ----------
    simulated : Simulated
    errors : mapping
        The sources of errors as the configuration has them.
    directory : RunDirectory
    """
    entries = [outcome.entries() for outcome in simulated.outcomes.values()]
    directory.write_json("simulation.json", {"errors": errors, "order": simulated.order, "programs": entries})
    rows = []
    for entry in entries:
        for name, p in entry["parameters"].items():
            numbers = [p["bias"], *p["bias_limits"], p["standard_deviation"], *p["standard_deviation_limits"]]
            numbers += [p["predicted"], int(p["as_predicted"]), p["relative_error"], p["coverage"]]
            rows.append([entry["program"], name, p["unit"], *map(repr, numbers)])
    directory.write_table("simulation.csv", ["program", "parameter", "unit", *_COLUMNS], rows)


def record_result(simulated: Simulated, directory: RunDirectory, seconds: float) -> None:
    """result.json: the figures of each program by groups of parameters, and whether all agree with theory."""
    directory.write_result(
        "ok",
        simulated.summary(),
        metrics={name: outcome.groups for name, outcome in simulated.outcomes.items()},
        agrees=simulated.agrees,
        visits=simulated.visits,
        evaluations=len(simulated.outcomes) * simulated.trials,
        seconds=seconds,
    )
