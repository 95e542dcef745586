"""What a run of acalx.calibrate leaves in its directory."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from acalx.errors import DataError
from acalx.estimation import Calibration, Correction, Readings
from acalx.estimation.readings import data_file, find_columns
from acalx.recording.run_directory import RunDirectory

__all__ = ["corrected_message", "record", "record_corrected", "record_intervals", "record_result"]

# Mean magnitudes outside these, in g, are questioned: a moving sensor too feels about 1 g on average.
_PLAUSIBLE = 0.5, 2.0


def record(calibration: Calibration, data: str, directory: RunDirectory) -> None:
    """calibration.json, and residuals.csv with a row for each position.

    Parameters
    ----------
    calibration : Calibration
    data : str
        The file that the readings come from, as it was given.
    directory : RunDirectory
    """
    readings, estimate = calibration.readings, calibration.estimate
    directory.write_json("calibration.json", {"data": data, **calibration.entries()})
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


def record_intervals(readings: Readings, directory: RunDirectory) -> None:
    """static.csv: the static positions that were found in a recording."""
    assert readings.deviations is not None  # a recording gives both
    assert readings.counts is not None
    rows = np.column_stack([readings.means, readings.deviations]).tolist()
    directory.write_table(
        "static.csv",
        ["position", "n", "ax", "ay", "az", "sx", "sy", "sz"],
        ([k, int(n), *map(repr, row)] for k, (n, row) in enumerate(zip(readings.counts, rows, strict=True), 1)),
    )


def record_result(calibration: Calibration, directory: RunDirectory, seconds: float) -> None:
    """result.json: how well the readings fit, which positions are outlying, and what else is remarkable."""
    remarks = calibration.remarks()
    directory.write_result(
        "ok",
        "; ".join(remarks) or calibration.summary(),
        residual_rms_g=calibration.entries()["residual_rms_g"],
        noise_g=calibration.noise,
        outlying=calibration.outlying,
        remarks=remarks,
        seconds=seconds,
    )


def record_corrected(
    correction: Correction, data: str, columns: Sequence[str], directory: RunDirectory
) -> tuple[int, float]:
    """corrected.csv: the lines of a file again, each with the specific force in g behind it.

    The file is read and written a block of lines at a time, so it may be larger than memory.

    Parameters
    ----------
    correction : Correction
    data : str
        Path of the file.
    columns : three names
        Of the readings.
    directory : RunDirectory

    Returns
    -------
    number of readings, and the mean magnitude of the corrected ones in g

    Raises
    ------
    DataError
        A file that can't be used, has no readings, or is corrected already; then nothing is left.
    """
    file = data_file(data)
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
    return count, magnitude / count


def corrected_message(count: int, magnitude: float) -> str:
    """How many readings were corrected, and a question where their mean magnitude in g is far from 1."""
    message = f"{count} readings corrected; their mean magnitude is {magnitude:.6g} g"
    if not _PLAUSIBLE[0] < magnitude < _PLAUSIBLE[1]:
        message += ", far from 1 g: are they in the unit that the calibration was made in?"
    return message
