"""Static positions as a sensor read them."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from acalx.errors import DataError, Option
from acalx.files import CsvFile, closest, did_you_mean, is_number
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus
from acalx.stands import Stand

__all__ = ["Readings", "data_file", "find_columns", "read_groups", "read_readings"]

AXES = ("ax", "ay", "az")
_DEVIATIONS = (("sx", "sy", "sz"), ("sax", "say", "saz"))
_COSINES = ("eta_x", "eta_y", "eta_z")
_MOST_POSITIONS = 20_000
_LAYOUT = "a header names the columns, as in 'ax,ay,az'; others may be there"


@final
@dataclass(frozen=True, eq=False)
class Readings:
    """Means of the readings of an accelerometer triad in n static positions.

    Parameters
    ----------
    name : str
        Where they come from, for messages.
    means : array (n, 3), in the sensor's unit
    deviations : array (n, 3), optional
        Standard deviations of the samples of each mean.
    counts : array (n,), optional
        Numbers of the samples.
    directions : array (n, 3), optional
        Unit vectors of the vertical in sensor axes, where the orientation is known.
    labels : tuple of str, length n, optional
        What the file calls the positions; without it they are called 1, 2, ...

    Raises
    ------
    DataError
        No positions, other shapes, numbers that are not finite.
    """

    name: str
    means: Array
    deviations: Array | None = None
    counts: Array | None = None
    directions: Array | None = None
    labels: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for what in ("means", "deviations", "counts", "directions"):
            if (given := getattr(self, what)) is not None:
                object.__setattr__(self, what, _own(self.name, what, given))
        if self.means.ndim != 2 or self.means.shape[1] != 3 or len(self.means) == 0:
            raise DataError(f"{self.name}: means of shape {self.means.shape}, expected (n, 3)")
        n = len(self.means)
        for what, shape in (("means", (n, 3)), ("deviations", (n, 3)), ("counts", (n,)), ("directions", (n, 3))):
            array = getattr(self, what)
            if array is not None and (array.shape != shape or not np.isfinite(array).all()):
                raise DataError(f"{self.name}: {what} must be finite numbers of shape {shape}, got {array.shape}")
        if not self.labels:
            object.__setattr__(self, "labels", tuple(str(k + 1) for k in range(n)))

    @classmethod
    def of(cls, given: Readings | Array, name: str = "readings") -> Readings:
        """Readings as they are, or from an array (n, 3) of means that gets a name for messages."""
        return given if isinstance(given, Readings) else cls(name, given)

    @property
    def n(self) -> int:
        """Number of positions that the sensor was read in."""
        return len(self.means)

    @property
    def stimulus(self) -> Stimulus | None:
        """The vertical in sensor axes, where it is known."""
        return None if self.directions is None else Stimulus(specific_force=self.directions)

    def select(self, positions: Sequence[int] | np.ndarray) -> Readings:
        """The positions of these indices, with all that is known of them."""
        chosen = np.asarray(positions)
        deviations, counts, directions = (
            None if array is None else array[chosen] for array in (self.deviations, self.counts, self.directions)
        )
        labels = tuple(self.labels[k] for k in chosen)
        return Readings(self.name, self.means[chosen], deviations, counts, directions, labels)


def read_readings(
    path: str | os.PathLike[str],
    columns: Sequence[str] = AXES,
    where: Mapping[str, object] | None = None,
    stand: Stand | None = None,
) -> Readings:
    """Read static positions from a CSV file, one a row.

    Columns ``sx, sy, sz`` or ``sax, say, saz`` are standard deviations of the samples, ``n``
    their number, ``position`` a name, ``eta_x, eta_y, eta_z`` the vertical in sensor axes, or
    ``alpha1_deg, alpha2_deg`` the angles of the stand. Other columns are not read.

    Parameters
    ----------
    path : str or path
    columns : three names
        Of the means.
    where : mapping, optional
        Only rows with these values in these columns.
    stand : Stand, optional
        To make directions from its angles.

    Raises
    ------
    DataError
        What can't be used, with the file, the row as an editor counts it, and the column.
    """
    groups = read_groups(path, (), columns, where, stand)
    return next(iter(groups.values()))


def read_groups(
    path: str | os.PathLike[str],
    by: Sequence[str],
    columns: Sequence[str] = AXES,
    where: Mapping[str, object] | None = None,
    stand: Stand | None = None,
) -> dict[tuple[str, ...], Readings]:
    """Read several sensors from one file: the rows that have the same values in the columns `by`."""
    file = data_file(path)
    header = file.header()
    where = where or {}
    find_columns(file, header, (*columns, *by, *where))
    reader = _Reader(file, header, columns, stand)
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


def find_columns(file: CsvFile, header: list[str], names: Sequence[str]) -> list[int]:
    """Places of columns; raises DataError for one that is not there."""
    for name in names:
        if name not in header:
            raise DataError(
                "{path}: no column {name!r}{hint}; there are {names}; {columns} says which are read "
                "instead of ax, ay, az",
                path=file.path,
                name=name,
                hint=did_you_mean(closest(name, header)),
                names=", ".join(header)[:300],
                columns=Option("columns", ["NAME"] * 3, "(NAME, NAME, NAME)"),
            )
    return [header.index(name) for name in names]


class _Reader:
    """Makes readings from the rows of a file, whatever columns it has."""

    def __init__(self, file: CsvFile, header: list[str], columns: Sequence[str], stand: Stand | None) -> None:
        self.file, self.header, self.stand = file, header, stand
        angles = () if stand is None else stand.axes.columns
        deviations = next((names for names in _DEVIATIONS if set(names) <= set(header)), ())
        verticals = next((names for names in (_COSINES, angles) if names and set(names) <= set(header)), ())
        counts = ("n",) if "n" in header else ()
        self.parts = {"means": tuple(columns), "deviations": deviations, "counts": counts, "verticals": verticals}
        self.names = [name for part in self.parts.values() for name in part]
        self.indices = [header.index(name) for name in self.names]

    def row(self, row: int, fields: list[str]) -> tuple[str, list[float]]:
        values = self.file.numbers(row, fields, self.header, self.indices)
        for name, value in zip(self.names, values, strict=True):
            if (name in self.parts["counts"] and value < 1) or (name in self.parts["deviations"] and value < 0):
                least = "1 sample or more" if name in self.parts["counts"] else "a standard deviation, 0 or more"
                raise DataError(f"{self.file.path}, row {row}, column {name}: {value:g}; must be {least}")
        if self.parts["verticals"] == _COSINES and abs(np.linalg.norm(values[-3:]) - 1.0) > 1e-3:
            length = np.linalg.norm(values[-3:])
            raise DataError(
                f"{self.file.path}, row {row}, columns {', '.join(_COSINES)}: the length of the vector is "
                f"{length:.6g}; direction cosines must have length 1"
            )
        label = fields[self.header.index("position")] if "position" in self.header else ""
        return label, values

    def readings(self, rows: list[tuple[str, list[float]]], key: tuple[str, ...]) -> Readings:
        table = np.array([values for _, values in rows])
        parts: dict[str, Array | None] = {}
        start = 0
        for part, names in self.parts.items():
            parts[part] = table[:, start : start + len(names)] if names else None
            start += len(names)
        means, counts, verticals = parts["means"], parts["counts"], parts["verticals"]
        assert means is not None  # three columns, always
        return Readings(
            " ".join([str(self.file.path), *key]),
            means,
            parts["deviations"],
            None if counts is None else counts[:, 0],
            None if verticals is None else self._directions(verticals),
            tuple(label for label, _ in rows) if all(label for label, _ in rows) else (),
        )

    def _directions(self, verticals: Array) -> Array:
        if self.parts["verticals"] == _COSINES:
            return np.asarray(verticals / np.linalg.norm(verticals, axis=1, keepdims=True))
        assert self.stand is not None  # its angles are there
        force = self.stand.stimulus(self.stand.axes.read(verticals)).specific_force
        if force is None:
            raise DataError(f"{self.file.path}: stand {type(self.stand).__name__} does not provide the vertical")
        return force


def _own(name: str, what: str, given: object) -> Array:
    """A copy of what was given, as numbers."""
    try:
        return np.array(given, dtype=float)
    except (TypeError, ValueError) as error:
        raise DataError(f"{name}: {what} must be numbers; {error}") from error


def _same(text: str, value: object) -> bool:
    given = str(value)
    return text == given or (is_number(text) and is_number(given) and float(text) == float(given))
