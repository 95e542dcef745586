"""Programs from files."""

from __future__ import annotations

import difflib
import itertools
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from acalx.errors import ProgramError
from acalx.files import CsvFile, did_you_mean, is_number
from acalx.programs.program import Program, first_not_unit, lengths_of
from acalx.quantities.units import Unit, unit_of_column

__all__ = ["read_program"]

_MOST_POSITIONS = 1_000_000
_MOST_BYTES = 2**28
_COSINES = (("eta_x", "eta_y", "eta_z"), ("x", "y", "z"))
_IGNORED = ("position", "label", "comment", "fixed")
_COLUMNS = (
    "a header names angles in degrees, as in 'alpha1_deg,alpha2_deg', rates in degrees per second, as in 'rate_deg_s', "
    "or the vertical in sensor axes, "
    f"'eta_x,eta_y,eta_z' or 'x,y,z'; {', '.join(_IGNORED)} are allowed and not read"
)


def read_program(path: str | os.PathLike[str], units: Sequence[Unit] = ()) -> Program:
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
    units : sequence of Unit
        That settings may have beside those of acalx: a stand's own.

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
    columns = _columns(f"{path}, row {header_row}", header, units)
    if not body:
        raise ProgramError(f"{path}: a header but no positions; write one a row below it")
    if len(body) > _MOST_POSITIONS:
        raise ProgramError(f"{path}: more than {_MOST_POSITIONS:,} positions; a program has fewer")
    indices = [header.index(name) for name in columns]
    values = np.array([file.numbers(row, fields, header, indices) for row, fields in body])
    name = os.fspath(path)
    title = f"{len(values)} positions from {path.name}"
    if columns not in _COSINES:
        names, own = zip(*(setting for column in columns if (setting := unit_of_column(column, units))), strict=True)
        settings = np.stack([unit.read(values[:, k]) for k, unit in enumerate(own)], axis=-1)
        return Program(name, title, name, settings=settings, settings_names=names, settings_units=own)
    lengths = lengths_of(values)
    if (k := first_not_unit(lengths)) is not None:
        raise ProgramError(
            f"{path}, row {body[k][0]}, columns {', '.join(columns)}: the length of the vector is "
            f"{lengths[k]:.6g}; direction cosines must have length 1"
        )
    return Program(name, title, name, directions=values)


def _columns(where: str, header: list[str], units: Sequence[Unit]) -> tuple[str, ...]:
    """Names of the columns to read: all the angles, or else the three cosines."""
    if all(is_number(field.replace(",", ".")) for field in header):
        raise ProgramError(f"{where}: numbers without a header above them; {_COLUMNS}")
    known = (*_IGNORED, *_COSINES[0], *_COSINES[1])
    for k, name in enumerate(header):
        if not name:
            raise ProgramError(f"{where}: column {k + 1} has no name; {_COLUMNS}")
        if name in header[:k]:
            raise ProgramError(f"{where}: column {name!r} is there twice; once is right")
        if name not in known and not unit_of_column(name, units):
            close = difflib.get_close_matches(name.lower(), (*known, "alpha1_deg", "alpha2_deg"), n=1)
            raise ProgramError(f"{where}: unknown column {name[:40]!r}{did_you_mean(close)}; {_COLUMNS}")
    settings = tuple(name for name in header if unit_of_column(name, units))
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
