"""Calibration programs by name and from files."""

from __future__ import annotations

import difflib
import itertools
import os
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from acalx.errors import CompatibilityError, ProgramError
from acalx.files import CsvFile, did_you_mean, is_number
from acalx.numerics.arrays import Array
from acalx.programs.publications import PUBLISHED
from acalx.quantities.units import DEGREE, Unit, unit_of_column
from acalx.stands import Stand

__all__ = ["Program", "find_program", "published", "published_for", "read_program"]

# Cosines printed with three decimals are this far from a unit vector at most.
_UNIT_TOLERANCE = 1e-3
_MOST_POSITIONS = 1_000_000
_MOST_BYTES = 2**28
_COSINES = (("eta_x", "eta_y", "eta_z"), ("x", "y", "z"))
_IGNORED = ("position", "label", "comment", "fixed")
_COLUMNS = (
    "a header names angles in degrees, as in 'alpha1_deg,alpha2_deg', rates in degrees per second, as in 'rate_deg_s', "
    "or the vertical in sensor axes, "
    f"'eta_x,eta_y,eta_z' or 'x,y,z'; {', '.join(_IGNORED)} are allowed and not read"
)


@final
@dataclass(frozen=True, eq=False)
class Program:
    """n positions of a sensor, as angles of a stand or as directions of the vertical.

    Parameters
    ----------
    name : str
        What `find_program` takes to give it again.
    title : str
        One line for a table.
    source : str
        Who printed it, or the file that it was read from.
    settings : array (n, d), rad or the SI unit, optional
        Settings of a stand. Either these or the directions are given.
    settings_names : tuple of str, length d
        Names of the stand's settings, without a unit.
    directions : array (n, 3), optional
        Unit vectors of the vertical in sensor axes. Lengths within 0.1 % of 1, as of
        rounded cosines, are made 1.
    settings_units : tuple of Unit, length d, optional
        Units of the settings where people read them; degrees where none are given.

    Raises
    ------
    ProgramError
        Both or neither of them, a wrong shape, numbers that are not finite, vectors whose
        length is not 1.
    """

    name: str
    title: str
    source: str
    settings: Array | None = None
    settings_names: tuple[str, ...] = ()
    directions: Array | None = None
    settings_units: tuple[Unit, ...] = ()

    def __post_init__(self) -> None:
        if (self.settings is None) == (self.directions is None):
            raise ProgramError(f"program {self.name}: give either settings or directions")
        if self.settings is not None:
            object.__setattr__(
                self, "settings", _finite(self.name, "settings", self.settings, len(self.settings_names))
            )
        if self.directions is not None:
            directions = _finite(self.name, "directions", self.directions, 3)
            lengths = _lengths(directions)
            if (k := _first_not_unit(lengths)) is not None:
                raise ProgramError(
                    f"program {self.name}, position {k + 1}: a direction of length {lengths[k]:.6g}, expected 1"
                )
            object.__setattr__(self, "directions", directions / lengths[:, None])

    @property
    def n(self) -> int:
        """Number of positions."""
        positions = self.directions if self.settings is None else self.settings
        assert positions is not None  # refused at construction
        return len(positions)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the settings with their units, as in files."""
        units = self.settings_units or (DEGREE,) * len(self.settings_names)
        return tuple(unit.column(name) for name, unit in zip(self.settings_names, units, strict=True))

    def suits(self, stand: Stand) -> bool:
        """Whether it gives angles of this stand, or directions that the stand can be aimed at."""
        try:
            self.settings_for(stand)
        except CompatibilityError:
            return False
        return True

    def settings_for(self, stand: Stand) -> Array:
        """Settings that put the sensor into the positions on this stand.

        They come in the order of the stand's settings; directions are aimed at. Limits and
        steps are not looked at: `Stand.allows` says which positions a stand can take.

        Parameters
        ----------
        stand : Stand with d settings

        Returns
        -------
        array (n, d), rad or the SI unit

        Raises
        ------
        CompatibilityError
            Settings of a stand with other settings, or directions for a stand that can't be
            aimed; the message names the angles that the stand needs.
        """
        needed = ", ".join(stand.axes.columns)
        if self.settings is None:
            assert self.directions is not None  # refused at construction
            try:
                return stand.aim(self.directions)
            except CompatibilityError as error:
                raise CompatibilityError(
                    f"program {self.name} gives directions of the vertical, "
                    f"but stand {type(stand).__name__} needs its settings, {needed} ({error})"
                ) from error
        if set(self.columns) != set(stand.axes.columns):
            raise CompatibilityError(
                f"program {self.name} gives {', '.join(self.columns)}, but stand {type(stand).__name__} needs {needed}"
            )
        return self.settings[:, [self.columns.index(column) for column in stand.axes.columns]]


def published() -> dict[str, Program]:
    """All published and classical programs by name.

    Examples
    --------
    >>> published()["icosahedron_12"].n
    12
    """
    return {name: _publish(name) for name in PUBLISHED}


def published_for(stand: Stand) -> dict[str, Program]:
    """Those that a stand can understand: its angles, or directions where it can be aimed."""
    return {name: program for name, program in published().items() if program.suits(stand)}


def find_program(name_or_path: str) -> Program:
    """Give a published program by its name, or read the one in a file.

    Parameters
    ----------
    name_or_path : str
        A name of `published`, else the path of a file for `read_program`.

    Raises
    ------
    ProgramError
        Neither of them, with suggestions; a file that can't be used.

    Examples
    --------
    >>> find_program("axes_and_edges_9").title
    '6 faces and 3 edge midpoints of a cube'
    """
    if name_or_path in PUBLISHED:
        return _publish(name_or_path)
    path = os.path.expanduser(name_or_path)
    if os.path.basename(path) != path or path.lower().endswith(".csv") or os.path.exists(path):
        return read_program(path)
    asked = name_or_path.strip().lower()
    close = [name for name in PUBLISHED if asked and asked in name] or difflib.get_close_matches(asked, PUBLISHED)
    raise ProgramError(
        f"no program {name_or_path!r}{did_you_mean(close)}; the programs are {', '.join(PUBLISHED)}, "
        "or give the path of a CSV file"
    )


def read_program(path: str | os.PathLike[str]) -> Program:
    """Read a program from a CSV file, one position a row.

    The header names either the settings of a stand with their units, ``<setting>_deg`` for
    each angle and ``<setting>_deg_s`` for each rate, or the direction cosines of the vertical
    in sensor axes, ``eta_x, eta_y, eta_z`` or ``x, y, z``, in any order. Where both are there,
    as in the ``program.csv`` that acalx writes, settings count and cosines are not read.
    Columns ``position``, ``label`` and ``comment`` may be there and are not read; any other
    name is refused, so that a misspelt one does not go unnoticed.

    Fields are separated by commas, semicolons or tabs, numbers have a decimal point. Lines
    that start with ``#`` and empty ones are skipped. The text is UTF-8.

    Parameters
    ----------
    path : str or path

    Raises
    ------
    ProgramError
        Anything else, with the file, the row as an editor counts it, the column, and what
        would be right.
    """
    path = Path(path)
    file = CsvFile(path, ProgramError, _COLUMNS, ("program.csv", "22.2"))
    if file.size() > _MOST_BYTES:
        raise ProgramError(
            f"{path}: {file.size() / 2**20:.0f} MB is too large; a program has {_MOST_POSITIONS:,} positions or fewer"
        )
    (header_row, header), *body = itertools.islice(file.rows(), _MOST_POSITIONS + 2)
    columns = _columns(f"{path}, row {header_row}", header)
    if not body:
        raise ProgramError(f"{path}: a header but no positions; write one a row below it")
    if len(body) > _MOST_POSITIONS:
        raise ProgramError(f"{path}: more than {_MOST_POSITIONS:,} positions; a program has fewer")
    indices = [header.index(name) for name in columns]
    values = np.array([file.numbers(row, fields, header, indices) for row, fields in body])
    name = os.fspath(path)
    title = f"{len(values)} positions from {path.name}"
    if columns not in _COSINES:
        names, units = zip(*(setting for column in columns if (setting := unit_of_column(column))), strict=True)
        settings = np.stack([unit.read(values[:, k]) for k, unit in enumerate(units)], axis=-1)
        return Program(name, title, name, settings=settings, settings_names=names, settings_units=units)
    lengths = _lengths(values)
    if (k := _first_not_unit(lengths)) is not None:
        raise ProgramError(
            f"{path}, row {body[k][0]}, columns {', '.join(columns)}: the length of the vector is "
            f"{lengths[k]:.6g}; direction cosines must have length 1"
        )
    return Program(name, title, name, directions=values)


def _publish(name: str) -> Program:
    entry = PUBLISHED[name]
    if entry.angles_deg is not None:
        settings = np.radians(np.array(list(entry.angles_deg.values())).T)
        return Program(name, entry.title, entry.source, settings=settings, settings_names=tuple(entry.angles_deg))
    assert entry.directions is not None  # a publication has either
    points = entry.directions()
    return Program(name, entry.title, entry.source, directions=points / _lengths(points)[:, None])


def _finite(name: str, what: str, values: Array, width: int) -> Array:
    array = np.array(values, dtype=float)
    if array.ndim != 2 or 0 in array.shape or array.shape[1] != width:
        raise ProgramError(f"program {name}: {what} of shape {array.shape}, expected (n, {width})")
    if not np.isfinite(array).all():
        raise ProgramError(f"program {name}: {what} must be finite numbers")
    return array


def _lengths(vectors: Array) -> Array:
    with np.errstate(over="ignore"):
        return np.asarray(np.hypot(np.hypot(vectors[:, 0], vectors[:, 1]), vectors[:, 2]))


def _first_not_unit(lengths: Array) -> int | None:
    wrong = np.abs(lengths - 1.0) > _UNIT_TOLERANCE
    return int(wrong.argmax()) if wrong.any() else None


def _columns(where: str, header: list[str]) -> tuple[str, ...]:
    """Names of the columns to read: all the angles, or else the three cosines."""
    if all(is_number(field.replace(",", ".")) for field in header):
        raise ProgramError(f"{where}: numbers without a header above them; {_COLUMNS}")
    known = (*_IGNORED, *_COSINES[0], *_COSINES[1])
    for k, name in enumerate(header):
        if not name:
            raise ProgramError(f"{where}: column {k + 1} has no name; {_COLUMNS}")
        if name in header[:k]:
            raise ProgramError(f"{where}: column {name!r} is there twice; once is right")
        if name not in known and not unit_of_column(name):
            close = difflib.get_close_matches(name.lower(), (*known, "alpha1_deg", "alpha2_deg"), n=1)
            raise ProgramError(f"{where}: unknown column {name[:40]!r}{did_you_mean(close)}; {_COLUMNS}")
    settings = tuple(name for name in header if unit_of_column(name))
    if settings:
        return settings
    triads = [triad for triad in _COSINES if set(triad) & set(header)]
    if not triads:
        raise ProgramError(f"{where}: neither angles nor direction cosines; {_COLUMNS}")
    if len(triads) > 1:
        raise ProgramError(f"{where}: both eta_x, eta_y, eta_z and x, y, z; give one of them")
    missing = [name for name in triads[0] if name not in header]
    if missing:
        raise ProgramError(f"{where}: no column {missing[0]}; direction cosines are {', '.join(triads[0])}")
    return triads[0]
