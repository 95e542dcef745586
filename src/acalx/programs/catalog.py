"""Programs by name: published and classical ones, or else files."""

from __future__ import annotations

import difflib
import os

import numpy as np

from acalx.errors import ProgramError
from acalx.files import did_you_mean
from acalx.programs.program import Program, lengths_of
from acalx.programs.publications import PUBLISHED
from acalx.programs.reading import read_program
from acalx.stands import Stand

__all__ = ["find_program", "published", "published_for"]


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


def find_program(name_or_path: str, stand: Stand | None = None) -> Program:
    """Give a published program by its name, or read the one in a file.

    Parameters
    ----------
    name_or_path : str
        A name of `published`, else the path of a file for `read_program`.
    stand : Stand, optional
        In the units of whose settings the file may be.

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
        return read_program(path, [] if stand is None else [setting.unit for setting in stand.settings])
    asked = name_or_path.strip().lower()
    close = [name for name in PUBLISHED if asked and asked in name] or difflib.get_close_matches(asked, PUBLISHED)
    raise ProgramError(
        f"no program {name_or_path!r}{did_you_mean(close)}; the programs are {', '.join(PUBLISHED)}, "
        "or give the path of a CSV file"
    )


def _publish(name: str) -> Program:
    entry = PUBLISHED[name]
    if entry.angles_deg is not None:
        settings = np.radians(np.array(list(entry.angles_deg.values())).T)
        return Program(name, entry.title, entry.source, settings=settings, settings_names=tuple(entry.angles_deg))
    assert entry.directions is not None  # a publication has either
    points = entry.directions()
    return Program(name, entry.title, entry.source, directions=points / lengths_of(points)[:, None])
