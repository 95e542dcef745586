"""What a run of acalx.validate leaves in its directory."""

from __future__ import annotations

from dataclasses import asdict

from acalx.recording.run_directory import RunDirectory
from acalx.validation import Validated
from acalx.validation.comparison import COMPARED

__all__ = ["record", "record_result"]


def record(validated: Validated, data: str, test: str | None, directory: RunDirectory) -> None:
    """validation.json, validation.csv with a row for each sensor, programs.csv with each program on each sensor.

    Parameters
    ----------
    validated : Validated
    data : str
        The file that the readings come from, as it was given.
    test : str or None
        That of the test readings.
    directory : RunDirectory
    """
    sensors = validated.sensors
    keys = list(validated.medians)
    rms = f"rms_{validated.unit}"
    columns = [rms if key == "rms" else key for key in COMPARED]
    directory.write_json(
        "validation.json",
        {
            "data": data,
            "test": test,
            "sensors": [{"sensor": s.name, "positions": s.n, **s.figures} for s in sensors],
            "programs": [{rms if k == "rms" else k: v for k, v in asdict(row).items()} for row in validated.programs],
        },
    )
    directory.write_table(
        "validation.csv",
        ["sensor", "positions", *keys],
        ([s.name, s.n, *(repr(s.figures.get(key, float("nan"))) for key in keys)] for s in sensors),
    )
    directory.write_table(
        "programs.csv",
        ["sensor", "program", "positions", *columns],
        ([s.name, r.name, r.n, *(repr(getattr(r, key)) for key in COMPARED)] for s in sensors for r in s.compared),
    )


def record_result(validated: Validated, directory: RunDirectory, seconds: float) -> None:
    """result.json: the medians of all figures over the sensors."""
    directory.write_result("ok", validated.summary(), metrics=validated.medians, seconds=seconds)
