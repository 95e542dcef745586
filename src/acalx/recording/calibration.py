"""What a run of acalx.calibrate leaves in its directory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.errors import DataError
from acalx.estimation import Calibration, Readings
from acalx.estimation.columns import Known, columns_for, needs_of
from acalx.estimation.correction import Correctly, ModelCorrection
from acalx.estimation.files import data_file, deviations_of, find_columns
from acalx.estimation.residuals import names_of_residuals, suffix
from acalx.numerics.arrays import Array
from acalx.recording.run_directory import RunDirectory
from acalx.stands import Stand

__all__ = ["Corrected", "record", "record_corrected", "record_intervals", "record_result"]

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
    readings, model = calibration.readings, calibration.model
    directory.write_json("calibration.json", {"data": data, **calibration.entries()})
    channels, m = model.channels, model.outputs
    table, header = [readings.means], [channel.name for channel in channels]
    if calibration.corrected is not None:
        table.append(calibration.corrected)
        header += [f"{channel.name}_{suffix(channel.unit)}" for channel in channels]
    for what, values in _told(calibration).items():
        table.append(values.reshape(readings.n, m))
        header += [what] if m == 1 else [f"{what}_{name}" for name in names_of_residuals(model)]
    numbers = np.column_stack(table).tolist()
    directory.write_table(
        "residuals.csv",
        ["position", "label", *header, "outlying"],
        (
            [k, label, *map(repr, row), int(k in calibration.outlying)]
            for k, (label, row) in enumerate(zip(readings.labels, numbers, strict=True), 1)
        ),
    )


def _told(calibration: Calibration) -> dict[str, Array]:
    """What is said of each residual, (n m,), by the head of its column."""
    estimate, several = calibration.estimate, len(calibration.noises) > 1
    unit = "" if several else f"_{suffix(next(iter(calibration.noises)))}"
    residual = estimate.scaled if several else calibration.size_of_residuals * estimate.residual
    return {f"residual{unit}": residual, "leverage": calibration.leverage, "studentized": calibration.studentized}


def record_intervals(readings: Readings, columns: Sequence[str], directory: RunDirectory) -> None:
    """static.csv: the static positions that were found in a recording, by the names of the channels."""
    assert readings.deviations is not None  # a recording gives both
    assert readings.counts is not None
    rows = np.column_stack([readings.means, readings.deviations]).tolist()
    directory.write_table(
        "static.csv",
        ["position", "n", *columns, *deviations_of(columns)[0]],
        ([k, int(n), *map(repr, row)] for k, (n, row) in enumerate(zip(readings.counts, rows, strict=True), 1)),
    )


def record_result(calibration: Calibration, directory: RunDirectory, seconds: float) -> None:
    """result.json: noise, outlying positions, and what somebody who relies on the calibration should know."""
    remarks = calibration.remarks()
    directory.write_result(
        "ok",
        "; ".join(remarks) or calibration.summary(),
        **calibration.figures,
        outlying=calibration.outlying,
        remarks=remarks,
        seconds=seconds,
    )


@final
@dataclass(frozen=True)
class Corrected:
    """Readings that were made right.

    Parameters
    ----------
    count : int
    magnitude : float or None
        Mean of the corrected ones of a triad that feels a vector of length 1; None of others.
    unit : str
        Of the first channel.
    """

    count: int
    magnitude: float | None
    unit: str

    @property
    def message(self) -> str:
        """How many there are, and a question where their mean magnitude is far from 1."""
        if self.magnitude is None:
            return f"{self.count} readings corrected"
        message = f"{self.count} readings corrected; their mean magnitude is {self.magnitude:.6g} {self.unit}"
        if not _PLAUSIBLE[0] < self.magnitude < _PLAUSIBLE[1]:
            message += f", far from 1 {self.unit}: are they in the unit that the calibration was made in?"
        return message

    @property
    def entries(self) -> dict[str, float | None]:
        """The same for a file."""
        unit = "g" if self.magnitude is None else suffix(self.unit)
        return {"n": self.count, f"mean_magnitude_{unit}": self.magnitude}


def record_corrected(
    correction: Correctly, data: str, columns: Sequence[str], directory: RunDirectory, stand: Stand | None = None
) -> Corrected:
    """corrected.csv: the lines of a file again, each with the corrected readings behind it.

    The file is read and written a block of lines at a time, so it may be larger than memory.

    Parameters
    ----------
    correction : Correction or ModelCorrection
    data : str
        Path of the file.
    columns : sequence of names
        Of the readings.
    directory : RunDirectory
    stand : Stand, optional
        From whose settings in the file it is known what else the correction takes.

    Raises
    ------
    DataError
        A file that can't be used, has no readings, or is corrected already; then nothing is left.
    """
    file = data_file(data)
    header = file.header()
    units = correction.units or ("g",) * len(columns)
    if len(units) != len(columns):
        raise DataError(f"{file.path}: {len(columns)} columns of readings, but the correction takes {len(units)}")
    find_columns(file, header, columns)
    added = [f"{name}_{suffix(unit)}" for name, unit in zip(columns, units, strict=True)]
    if set(added) & set(header):
        raise DataError(f"{file.path}: has a column {(set(added) & set(header)).pop()} already; is it corrected?")
    model = correction.model if isinstance(correction, ModelCorrection) else None
    needed, widths = ({}, {}) if model is None else (needs_of(model), dict(model.widths))
    known = Known(file, header, {name: needed.get(name, "") for name in correction.needs}, stand, columns)
    mark, count, magnitude = file.delimiter(), 0, 0.0
    with directory.whole("corrected.csv") as part, part.open("w", encoding="utf-8", newline="") as out:
        out.write(mark.join([*header, *added]) + "\n")
        for lines, values in file.blocks((*columns, *known.columns)):
            felt = known.stimulus(values[:, len(columns) :])
            missing = [name for name in correction.needs if felt is None or name not in felt]
            if missing:
                told = " and ".join(columns_for(name, needed.get(name, ""), widths.get(name, 1)) for name in missing)
                raise DataError(
                    f"{file.path}: these readings are corrected by what is known of each position: give the settings "
                    f"of the stand, or {told}"
                )
            corrected = correction.apply(values[:, : len(columns)], felt)
            out.writelines(
                line.rstrip() + mark + mark.join(f"{value:.9g}" for value in row) + "\n"
                for line, row in zip(lines, corrected.tolist(), strict=True)
            )
            count += len(corrected)
            magnitude += float(np.linalg.norm(corrected, axis=1).sum())
        if count == 0:
            raise DataError(f"{file.path}: a header but no readings below it")
    whole = len(units) == 3 and units[0] in ("g", "field") and len(set(units)) == 1
    return Corrected(count, magnitude / count if whole else None, units[0])
