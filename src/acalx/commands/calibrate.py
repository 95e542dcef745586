"""Parameters of a sensor from measurements: ``python -m acalx.calibrate data=measurements.csv``.

``apply=RUN/calibration.json data=new.csv`` makes readings right instead.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from omegaconf import DictConfig, OmegaConf

from acalx.commands.composition import build
from acalx.commands.launch import FAILED, Entry, launch
from acalx.commands.options import names_of, where_of
from acalx.errors import ArgumentError, DataError
from acalx.estimation import (
    Calibration,
    Estimator,
    Readings,
    SingularError,
    StaticIntervals,
    Unit,
    calibrate,
    read_correction,
    read_readings,
)
from acalx.estimation.readings import data_file, find_columns
from acalx.models import ScalarAccel
from acalx.recording import RunDirectory
from acalx.reporting.tables import align
from acalx.stands import Stand

__all__ = ["ENTRY", "main"]

# Mean magnitudes outside these, in g, are questioned: a moving sensor too feels about 1 g on average.
_PLAUSIBLE = 0.5, 2.0


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


def run(config: DictConfig, directory: RunDirectory) -> int:
    """Read, estimate, record, show; or correct other readings."""
    started = time.perf_counter()
    if OmegaConf.is_missing(config, "data"):
        raise ArgumentError("which measurements? Give data=FILE.csv with columns ax, ay, az, a static position a row")
    directory.remember(data=str(config.data), inestimable=[])
    if config.apply is not None:
        return _apply(config, directory, started)
    model, estimator = build(config, "model", ScalarAccel), build(config, "estimator", Estimator)
    unit = build(config, "unit", Unit)
    readings = read(config)
    directory.remember(n=readings.n)
    try:
        calibration = calibrate(readings, model, estimator, unit, config.noise, config.confidence)
    except SingularError as error:
        seconds = time.perf_counter() - started
        directory.write_result("singular", str(error), inestimable=error.inestimable, seconds=seconds)
        print(f"acalx: {error}", file=sys.stderr)
        return FAILED
    _record(calibration, config, directory)
    remarks = calibration.remarks()
    directory.write_result(
        "ok",
        "; ".join(remarks) or _fit(calibration),
        residual_rms_g=calibration.entries()["residual_rms_g"],
        noise_g=calibration.noise,
        outlying=calibration.outlying,
        remarks=remarks,
        seconds=time.perf_counter() - started,
    )
    _show(calibration, directory)
    return 0


def read(config: DictConfig) -> Readings:
    """The readings that the configuration names: static positions, or a recording of them."""
    columns = names_of(config, "columns", 3)
    if config.static is not None:
        if config.where:
            raise ArgumentError(f"where={config.where}: goes with static positions, not with a raw recording")
        found: StaticIntervals = build(config, "static", StaticIntervals)
        return found.readings(str(config.data), columns)
    return read_readings(str(config.data), columns, where_of(config), build(config, "stand", Stand))


def _record(calibration: Calibration, config: DictConfig, directory: RunDirectory) -> None:
    readings, estimate = calibration.readings, calibration.estimate
    directory.write_json("calibration.json", {"data": str(config.data), **calibration.entries()})
    corrected = calibration.correction.apply(readings.means)
    numbers = np.column_stack(
        [readings.means, corrected, estimate.residual, calibration.leverage, calibration.studentized]
    )
    header = ["position", "label", "ax", "ay", "az", "ax_g", "ay_g", "az_g"]
    directory.write_table(
        "residuals.csv",
        [*header, "residual_g", "leverage", "studentized", "outlying"],
        (
            [k, label, *map(repr, row), int(k in calibration.outlying)]
            for k, (label, row) in enumerate(zip(readings.labels, numbers.tolist(), strict=True), 1)
        ),
    )
    if config.static is not None:
        assert readings.deviations is not None  # a recording gives both
        assert readings.counts is not None
        rows = np.column_stack([readings.means, readings.deviations]).tolist()
        directory.write_table(
            "static.csv",
            ["position", "n", "ax", "ay", "az", "sx", "sy", "sz"],
            ([k, int(n), *map(repr, row)] for k, (n, row) in enumerate(zip(readings.counts, rows, strict=True), 1)),
        )
    if config.figures:
        from acalx.reporting.residuals import draw_residuals

        draw_residuals(
            estimate.residual, calibration.studentized, calibration.noise, calibration.outlying, directory.path
        )


def _show(calibration: Calibration, directory: RunDirectory) -> None:
    estimate, correction = calibration.estimate, calibration.correction
    head = ["parameter", "unit", "estimate", "standard error", f"{100 * calibration.confidence:g} % interval"]
    rows = [head]
    for parameter, value, error, half in zip(
        estimate.model.parameters,
        estimate.parameters,
        estimate.standard_errors,
        calibration.half_widths,
        strict=True,
    ):
        interval = f"{value - half:+.6f} to {value + half:+.6f}" if np.isfinite(half) else "-"
        shown = f"{error:.6f}" if np.isfinite(error) else "-"
        rows.append([parameter.name, parameter.unit, f"{value:+.6f}", shown, interval])
    print(f"{align(rows)}\n")
    print(f"specific force in g = matrix (reading - offset), readings in {correction.unit}")
    cells = [[f"{value:+.9g}" for value in row] for row in correction.matrix]
    matrix = [["matrix", "", "", "offset"], *([*c, f"{o:+.7g}"] for c, o in zip(cells, correction.offset, strict=True))]
    print(f"{align(matrix)}\n")
    print(_fit(calibration))
    for remark in calibration.remarks():
        print(remark)
    print(f"written to {directory.path}")


def _fit(calibration: Calibration) -> str:
    """One line on the noise and the test of fit."""
    freedom, test = calibration.estimate.freedom, calibration.chi_square
    text = f"{calibration.readings.n} positions, noise {1e3 * calibration.noise:.4g} mg"
    if test is not None:
        return f"{text} (known); chi-square {test['value']:.4g} for {freedom}, probability {test['probability']:.3g}"
    if calibration.estimate.noise is not None:
        return f"{text} (known)"
    return f"{text} (estimated, {freedom} degrees of freedom)" if freedom else f"{calibration.readings.n} positions"


def _apply(config: DictConfig, directory: RunDirectory, started: float) -> int:
    """Write the data again with three columns more: the specific force in g."""
    correction = read_correction(str(config.apply))
    columns = names_of(config, "columns", 3)
    file = data_file(str(config.data))
    header = file.header()
    find_columns(file, header, columns)
    added = [f"{name}_g" for name in columns]
    if set(added) & set(header):
        raise DataError(f"{file.path}: has a column {(set(added) & set(header)).pop()} already; is it corrected?")
    mark, count, magnitude = file.delimiter(), 0, 0.0
    with directory.whole("corrected.csv") as part, part.open("w", encoding="utf-8", newline="") as out:
        out.write(mark.join([*header, *added]) + "\n")
        for lines, values in file.blocks(columns):
            forces = correction.apply(values)
            out.writelines(
                f"{line.rstrip()}{mark}{x:.9g}{mark}{y:.9g}{mark}{z:.9g}\n"
                for line, (x, y, z) in zip(lines, forces.tolist(), strict=True)
            )
            count += len(forces)
            magnitude += float(np.linalg.norm(forces, axis=1).sum())
        if count == 0:
            raise DataError(f"{file.path}: a header but no readings below it")
    message = f"{count} readings corrected; their mean magnitude is {magnitude / count:.6g} g"
    if not _PLAUSIBLE[0] < magnitude / count < _PLAUSIBLE[1]:
        message += ", far from 1 g: are they in the unit that the calibration was made in?"
    seconds = time.perf_counter() - started
    directory.write_result("ok", message, n=count, mean_magnitude_g=magnitude / count, seconds=seconds)
    print(f"{message}\nwritten to {directory.path / 'corrected.csv'}")
    return 0


ENTRY = Entry("calibrate", "calibrate", CalibrateConfig, run)


def main() -> int:
    """Calibrate, or correct readings, as the command line says; returns the exit status."""
    return launch(ENTRY)


if __name__ == "__main__":
    sys.exit(main())
