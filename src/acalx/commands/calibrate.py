"""Parameters of a sensor from measurements: ``python -m acalx.calibrate data=measurements.csv``; or ``apply=`` them."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from typing import Any

from omegaconf import DictConfig, OmegaConf

from acalx.commands.composition import RESOLVED, as_recorded, build, build_model, resolved
from acalx.commands.launch import Entry, launch
from acalx.commands.options import channels_of, where_of
from acalx.commands.singular import answers_singular
from acalx.errors import ArgumentError
from acalx.estimation import Estimator, Readings, StaticIntervals, Unit, calibrate, read_correction, read_readings
from acalx.estimation.columns import needs_of
from acalx.models import Model
from acalx.recording import RunDirectory
from acalx.recording.calibration import (
    record,
    record_corrected,
    record_intervals,
    record_result,
)
from acalx.recording.parts import described
from acalx.reporting.calibration import show
from acalx.reporting.residuals import draw_residuals
from acalx.stands import Stand

__all__ = ["ENTRY", "main"]


@dataclass
class CalibrateConfig:
    """Root of the configuration; the groups are built from what they name."""

    data: Any = "???"
    columns: Any = None
    where: Any = None
    model: Any = None
    stand: Any = None
    estimator: Any = None
    unit: Any = None
    static: Any = None
    noise: Any = None
    confidence: Any = 0.95
    apply: Any = None
    figures: bool = True
    traceback: bool = False


@answers_singular
def run(config: DictConfig, directory: RunDirectory) -> int:
    """Read, estimate, record, show; or correct other readings."""
    started = time.perf_counter()
    if OmegaConf.is_missing(config, "data"):
        raise ArgumentError("which measurements? Give data=FILE.csv with columns ax, ay, az, a static position a row")
    directory.remember(data=str(config.data), inestimable=[])
    if config.apply is not None:
        return _apply(as_recorded(config, str(config.apply), directory.overrides), directory, started)
    model, estimator = build_model(config), build(config, "estimator", Estimator)
    unit = build(config, "unit", Unit).named_for(model.channels)
    directory.remember(model=described(model), estimator=described(estimator), unit=described(unit))
    directory.remember(noise=config.noise, confidence=config.confidence)
    readings = _read(config, estimator.model_for(model), directory)
    directory.remember(n=readings.n)
    calibration = calibrate(readings, model, estimator, unit, config.noise, config.confidence)
    record(calibration, str(config.data), directory)
    directory.write_text(RESOLVED, resolved(config, ENTRY.name))
    if config.static is not None:
        record_intervals(readings, [channel.name for channel in calibration.model.channels], directory)
    if config.figures:
        draw_residuals(calibration, directory.path)
    record_result(calibration, directory, time.perf_counter() - started)
    show(calibration)
    print(f"written to {directory.path}")
    return 0


def _read(config: DictConfig, model: Model, directory: RunDirectory) -> Readings:
    """The readings that the configuration names: static positions, or a recording of them."""
    columns = channels_of(config, model)
    if config.static is not None:
        if config.where:
            raise ArgumentError.of("where", config.where, "goes with static positions, not with a raw recording")
        intervals: StaticIntervals = build(config, "static", StaticIntervals)
        directory.remember(static=described(intervals))
        return intervals.readings(str(config.data), columns)
    return read_readings(str(config.data), columns, where_of(config), build(config, "stand", Stand), needs_of(model))


def _apply(config: DictConfig, directory: RunDirectory, started: float) -> int:
    """Write the data again with more columns: the readings made right."""
    if config.where:
        raise ArgumentError.of("where", config.where, "all rows of a file are corrected: leave it out, or split it")
    model = build_model(config)
    directory.remember(apply=str(config.apply), model=described(model))
    correction = read_correction(str(config.apply), model)
    columns, stand = channels_of(config, model), build(config, "stand", Stand)
    corrected = record_corrected(correction, str(config.data), columns, directory, stand)
    directory.write_result("ok", corrected.message, **corrected.entries, seconds=time.perf_counter() - started)
    print(f"{corrected.message}\nwritten to {directory.path / 'corrected.csv'}")
    return 0


ENTRY = Entry("calibrate", "calibrate", CalibrateConfig, run)


def main() -> int:
    """Calibrate, or correct readings, as the command line says; returns the exit status."""
    return launch(ENTRY)


if __name__ == "__main__":
    sys.exit(main())
