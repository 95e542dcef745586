"""CSV files of numbers, read row by row, so that they may be larger than memory."""

from __future__ import annotations

import csv
import difflib
import itertools
import math
import stat
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from acalx.errors import AcalxError
from acalx.numerics.arrays import Array

__all__ = ["CsvFile", "closest", "did_you_mean", "is_number"]

_LONGEST_LINE = 2**20


@final
@dataclass(frozen=True)
class CsvFile:
    """A table with a header; whatever is wrong with it comes as one message with file, row and column.

    Fields are separated by commas, semicolons or tabs, numbers have a decimal point. Lines
    that start with ``#`` and empty ones are skipped. The text is UTF-8.

    Parameters
    ----------
    path : Path
    error : type of AcalxError
        What is raised.
    layout : str
        What the header should be, for messages.
    example : str
        A file and a number, for messages.
    """

    path: Path
    error: type[AcalxError]
    layout: str
    example: tuple[str, str]

    def size(self) -> int:
        """Bytes of the file; refuses what is no ordinary file."""
        try:
            status = self.path.stat()
        except FileNotFoundError:
            folder = "" if self.path.is_absolute() else f" in {Path.cwd()}"
            raise self.error(f"no file {self.path}{folder}") from None
        except (OSError, ValueError) as error:
            raise self._unreadable(error) from error
        if stat.S_ISDIR(status.st_mode):
            raise self.error(f"{self.path}: is a directory; give a file, such as {self.path / self.example[0]}")
        if not stat.S_ISREG(status.st_mode):
            raise self.error(f"{self.path}: is not an ordinary file; give a CSV file")
        return int(status.st_size)

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Rows that hold something, header first, each with its number in the file."""
        lines, delimiter = self._split_at()
        yield from self._fields(lines, delimiter)

    def header(self) -> list[str]:
        """Names of the columns, each there once."""
        row, header = next(self.rows())
        if all(is_number(field.replace(",", ".")) for field in header):
            raise self.error(f"{self.path}, row {row}: numbers without a header above them; {self.layout}")
        for k, name in enumerate(header):
            if name and name in header[:k]:
                raise self.error(f"{self.path}, row {row}: column {name!r} is there twice; once is right")
        return header

    def delimiter(self) -> str:
        """The character between the fields of a row, as it was found in the header."""
        return self._split_at()[1]

    def numbers(self, row: int, fields: list[str], header: list[str], indices: Iterable[int]) -> list[float]:
        """The fields of a row in some columns as numbers; the error names row and column where one is none."""
        self.check_width(row, fields, header)
        for k in indices:
            if not is_number(fields[k]):
                raise self.error(f"{self.path}, row {row}, column {header[k]}: {self._fault(fields[k])}")
        return [float(fields[k]) for k in indices]

    def check_width(self, row: int, fields: list[str], header: list[str]) -> None:
        """Refuse a row that has not as many fields as the header."""
        if len(fields) != len(header):
            hint = "; write decimal points, not commas" if len(fields) > len(header) else ""
            raise self.error(
                f"{self.path}, row {row}: number of fields {len(fields)}, "
                f"expected {len(header)} as in the header, {', '.join(header)}{hint}"
            )

    def blocks(self, columns: Sequence[str], size: int = 2**15) -> Iterator[tuple[list[str], Array]]:
        """Some columns of a long file, a block of rows at a time.

        Gives the lines of each block as they are in the file, and their numbers
        (size, len(columns)). The memory that it takes does not depend on the length of the file.
        """
        header = self.header()
        indices = [header.index(name) for name in columns]
        lines, delimiter = self._split_at()
        numbered = ((row, line) for row, line in enumerate(lines, 1) if line.strip())
        next(numbered)  # the header
        while block := list(itertools.islice(numbered, size)):
            yield [line for _, line in block], self._parse(block, header, indices, delimiter)

    def _parse(self, block: list[tuple[int, str]], header: list[str], indices: list[int], delimiter: str) -> Array:
        """Numbers of a block: numpy's reader where nothing is wrong, else row by row to say what is."""
        lines = [line for _, line in block]
        if all(line.count(delimiter) == len(header) - 1 for line in lines):
            try:
                values = np.loadtxt(lines, delimiter=delimiter, usecols=indices, ndmin=2, comments=None)
            except ValueError:
                values = np.empty(0)
            if values.shape == (len(lines), len(indices)) and np.isfinite(values).all():
                return values
        out = []
        for row, line in block:
            for _, fields in self._fields(iter([line]), delimiter, row - 1):
                out.append(self.numbers(row, fields, header, indices))
        return np.array(out).reshape(-1, len(indices))

    def _split_at(self) -> tuple[Iterator[str], str]:
        """The lines, and the mark between fields as the first of them has it."""
        lines = self._lines()
        blank = []
        for line in lines:
            blank.append(line)
            if line.strip():
                return itertools.chain(blank, lines), next((mark for mark in ";\t" if mark in line), ",")
        raise self.error(f"{self.path}: is empty; {self.layout}")

    def _fields(self, lines: Iterator[str], delimiter: str, before: int = 0) -> Iterator[tuple[int, list[str]]]:
        reader = csv.reader(lines, delimiter=delimiter, skipinitialspace=True, strict=True)
        try:
            for raw in reader:
                fields = [field.strip() for field in raw]
                if any(fields):
                    yield reader.line_num + before, fields
        except csv.Error as error:
            row = reader.line_num + before
            raise self.error(f"{self.path}, row {row}: {error}; write plain numbers without quotes") from error

    def _lines(self) -> Iterator[str]:
        """Lines of text; comments come as empty lines."""
        self.size()
        done = 0
        try:
            with self.path.open("rb") as file:
                while raw := file.readline(_LONGEST_LINE):
                    if len(raw) == _LONGEST_LINE and not raw.endswith(b"\n"):
                        raise self.error(f"{self.path}: a line of more than a million characters; is it a CSV file?")
                    text = raw.decode("utf-8-sig" if done == 0 else "utf-8")
                    done += len(raw)
                    for line in text.replace("\r\n", "\n").replace("\r", "\n").removesuffix("\n").split("\n"):
                        yield "\n" if line.lstrip().startswith("#") else f"{line}\n"
        except UnicodeDecodeError as error:
            byte = done + error.start + 1
            raise self.error(f"{self.path}: byte {byte} is not UTF-8 text; save it as CSV in UTF-8") from error
        except OSError as error:
            raise self._unreadable(error) from error

    def _unreadable(self, error: Exception) -> AcalxError:
        reason = error.strerror if isinstance(error, OSError) else error
        return self.error(f"{self.path}: can't be read: {reason}")

    def _fault(self, text: str) -> str:
        if not text:
            return "empty, expected a number"
        if is_number(text.replace(",", ".", 1)):
            return f"{text!r} has a decimal comma; write {text.replace(',', '.', 1)}"
        return f"{text[:40]!r} is not a finite number; write one such as {self.example[1]}"


def is_number(text: str) -> bool:
    """Whether a text is a finite number as everybody writes it."""
    try:
        return math.isfinite(float(text)) and "_" not in text
    except ValueError:
        return False


def did_you_mean(close: Collection[str]) -> str:
    """A hint at names that are close to the one that was given."""
    return f" (did you mean {' or '.join(close)}?)" if close else ""


def closest(name: str, known: Iterable[str]) -> list[str]:
    """The name closest to a given one, whatever the case, if there is any."""
    folded = {other.lower(): other for other in known}
    return [folded[match] for match in difflib.get_close_matches(name.lower(), folded, n=1)]
