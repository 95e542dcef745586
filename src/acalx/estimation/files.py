"""Readings from files, a position a row."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from acalx.errors import DataError, Option
from acalx.estimation.columns import Known
from acalx.estimation.readings import Readings
from acalx.files import CsvFile, closest, did_you_mean, is_number
from acalx.numerics.arrays import Array
from acalx.stands import Stand

__all__ = ["data_file", "deviations_of", "find_columns", "read_groups", "read_readings"]

AXES = ("ax", "ay", "az")
_MOST_POSITIONS = 20_000
_LAYOUT = "a header names the columns, as in 'ax,ay,az'; others may be there"


def read_readings(
    path: str | os.PathLike[str],
    columns: Sequence[str] = AXES,
    where: Mapping[str, object] | None = None,
    stand: Stand | None = None,
    quantities: Mapping[str, str] | Sequence[str] = ("specific_force",),
) -> Readings:
    """Read static positions from a CSV file, one a row.

    Columns that are called as those of the means with an ``s`` before, ``sax, say, saz``, or ``sx, sy, sz`` of a
    triad, are standard deviations of the samples, ``n`` their number, ``position`` a name. What the sensor felt is
    known from the settings of the stand, ``alpha1_deg, alpha2_deg`` of a two-axis table, or for each quantity by
    itself from ``eta_x, eta_y, eta_z``, the vertical in sensor axes, ``field_eta_x`` and so on, that of the magnetic
    field, or columns that end in their unit: ``angular_rate_x_deg_s``, ``magnetic_field_x_uT``, ``temperature_degC``,
    ``dwell_s``; only a specific force may leave it out, which is g. These go before the settings, which must not
    contradict direction cosines. Other columns are not read.

    Parameters
    ----------
    path : str or path
    columns : sequence of str
        Names of the means: those of a model's channels, ``ax, ay, az`` by default.
    where : mapping, optional
        Only rows with these values in these columns.
    quantities : mapping, or sequence of str
        Of the stimulus, those that columns of their own may tell: what a model reads, `Model.needs`; a mapping gives
        the units too.
    stand : Stand, optional
        To tell from its settings what the sensor felt.

    Raises
    ------
    DataError
        What can't be used, with the file, the row as an editor counts it, and the column.
    """
    groups = read_groups(path, (), columns, where, stand, quantities)
    return next(iter(groups.values()))


def read_groups(
    path: str | os.PathLike[str],
    by: Sequence[str],
    columns: Sequence[str] = AXES,
    where: Mapping[str, object] | None = None,
    stand: Stand | None = None,
    quantities: Mapping[str, str] | Sequence[str] = ("specific_force",),
) -> dict[tuple[str, ...], Readings]:
    """Read several sensors from one file: the rows that have the same values in the columns `by`."""
    file = data_file(path)
    header = file.header()
    where = where or {}
    find_columns(file, header, columns, (*by, *where))
    reader = _Reader(file, header, columns, stand, quantities)
    groups: dict[tuple[str, ...], list[tuple[str, list[float]]]] = {}
    for count, (row, fields) in enumerate(file.rows()):
        if count == 0:
            continue
        if count > _MOST_POSITIONS:
            raise DataError(
                "{path}: more than {most:,} rows; for a raw recording with samples one a row "
                "give {static}, which finds the static positions",
                path=path,
                most=_MOST_POSITIONS,
                static=Option("static", "variance", "StaticIntervals()"),
            )
        file.check_width(row, fields, header)
        if all(_same(fields[header.index(name)], value) for name, value in where.items()):
            key = tuple(fields[header.index(name)] for name in by)
            groups.setdefault(key, []).append(reader.row(row, fields))
    if not groups:
        chosen = " and ".join(f"{name}={value}" for name, value in where.items())
        raise DataError(f"{path}: {f'no row with {chosen}' if where else 'a header but no positions below it'}")
    return {key: reader.readings(rows, key) for key, rows in groups.items()}


def data_file(path: str | os.PathLike[str]) -> CsvFile:
    """A file of measurements, whose faults come as a DataError."""
    return CsvFile(Path(path).expanduser(), DataError, _LAYOUT, ("measurements.csv", "0.0312"))


def find_columns(file: CsvFile, header: list[str], columns: Sequence[str], others: Sequence[str] = ()) -> list[int]:
    """Places of the columns of readings, and of others; raises DataError for one that is not there."""
    for name in (*columns, *others):
        if name not in header:
            raise DataError(
                "{path}: no column {name!r}{hint}; there are {names}"
                + ("; {columns} says which are those of the readings" if name in columns else ""),
                path=file.path,
                name=name,
                hint=did_you_mean(closest(name, header)),
                names=", ".join(header)[:300],
                columns=Option("columns", ["NAME"] * len(columns), f"({', '.join(['NAME'] * len(columns))})"),
            )
    return [header.index(name) for name in (*columns, *others)]


class _Reader:
    """Makes readings from the rows of a file, whatever columns it has."""

    def __init__(
        self,
        file: CsvFile,
        header: list[str],
        columns: Sequence[str],
        stand: Stand | None,
        quantities: Mapping[str, str] | Sequence[str],
    ) -> None:
        self.file, self.header = file, header
        deviations = next((names for names in deviations_of(columns) if set(names) <= set(header)), ())
        counts = ("n",) if "n" in header else ()
        self.known = Known(file, header, quantities, stand, (*columns, *deviations))
        self.parts = {"means": tuple(columns), "deviations": deviations, "counts": counts, "known": self.known.columns}
        self.names = [name for part in self.parts.values() for name in part]
        self.indices = [header.index(name) for name in self.names]

    def row(self, row: int, fields: list[str]) -> tuple[str, list[float]]:
        values = self.file.numbers(row, fields, self.header, self.indices)
        given = dict(zip(self.names, values, strict=True))
        for name, value in given.items():
            if (name in self.parts["counts"] and value < 1) or (name in self.parts["deviations"] and value < 0):
                least = "1 sample or more" if name in self.parts["counts"] else "a standard deviation, 0 or more"
                raise DataError(f"{self.file.path}, row {row}, column {name}: {value:g}; must be {least}")
        for cosines in self.known.cosines:
            length = float(np.linalg.norm([given[name] for name in cosines]))
            if abs(length - 1.0) > 1e-3:
                raise DataError(
                    f"{self.file.path}, row {row}, columns {', '.join(cosines)}: the length of the vector is "
                    f"{length:.6g}; direction cosines must have length 1"
                )
        label = fields[self.header.index("position")] if "position" in self.header else ""
        return label, values

    def readings(self, rows: list[tuple[str, list[float]]], key: tuple[str, ...]) -> Readings:
        table = np.array([values for _, values in rows])
        columns = {name: table[:, k] for k, name in enumerate(self.names)}

        def part(name: str) -> Array | None:
            return np.stack([columns[one] for one in self.parts[name]], axis=-1) if self.parts[name] else None

        means, counts, known = part("means"), part("counts"), part("known")
        assert means is not None  # a column or more, always
        return Readings(
            " ".join([str(self.file.path), *key]),
            means,
            part("deviations"),
            None if counts is None else counts[:, 0],
            None if known is None else self.known.stimulus(known),
            tuple(label for label, _ in rows) if all(label for label, _ in rows) else (),
        )


def deviations_of(columns: Sequence[str]) -> list[tuple[str, ...]]:
    """What the columns of standard deviations may be called."""
    named = tuple(f"s{name}" for name in columns)
    return [("sx", "sy", "sz"), ("sax", "say", "saz"), named] if len(columns) == 3 else [named]


def _same(text: str, value: object) -> bool:
    given = str(value)
    return text == given or (is_number(text) and is_number(given) and float(text) == float(given))
