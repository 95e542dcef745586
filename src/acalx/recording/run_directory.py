"""The directory of one run, with its result written whole or not at all."""

from __future__ import annotations

import contextlib
import csv
import json
import os
import platform
import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from acalx.errors import ArgumentError
from acalx.numerics.arrays import Array
from acalx.quantities.magnitude import from_log, written_from_log
from acalx.search.pareto import FrontPoint
from acalx.search.result import ApproximateDesign, Solution, Survey
from acalx.stands import Stand

__all__ = ["RunDirectory", "versions"]

_RESULT = "result.json"
# What every result has, also that of a run that failed before it began.
_ALWAYS = {"n": None, "seed": None, "metrics": None, "loss": None, "value": None, "evaluations": 0}


@dataclass(frozen=True)
class RunDirectory:
    """A directory that belongs to one run.

    Parameters
    ----------
    path : Path
        Made where it does not exist.
    overrides : sequence of str
        The command line of the run.

    Raises
    ------
    ArgumentError
        Where the directory can't be written or holds a run already.
    """

    path: Path
    overrides: Sequence[str]
    common: dict[str, Any] = field(default_factory=dict)
    started: float = field(default_factory=time.perf_counter)

    def __post_init__(self) -> None:
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            taken = self.recorded
            if not taken:
                probe = self.path / f".{_RESULT}.{os.getpid()}"
                probe.touch()
                probe.unlink()
        except OSError as error:
            raise ArgumentError(
                f"can't write to the output directory {self.path}: {error.strerror}; "
                "choose another by hydra.run.dir=DIRECTORY"
            ) from error
        if taken:
            raise ArgumentError(
                f"the output directory {self.path} holds a run already, which is left as it is; "
                "choose another by hydra.run.dir=DIRECTORY"
            )

    @property
    def recorded(self) -> bool:
        """Whether a run has written its result.json here already."""
        return (self.path / _RESULT).exists()

    def remember(self, **entries: Any) -> None:
        """Entries that every result of this run has, also a failure."""
        self.common.update(entries)

    def write_result(self, status: str, message: str, **entries: Any) -> None:
        """Write result.json by atomic rename."""
        result = {
            "status": status,
            "message": message,
            **_ALWAYS,
            "seconds": time.perf_counter() - self.started,
            **self.common,
            **entries,
            "time": datetime.now(UTC).isoformat(timespec="seconds"),
            "versions": versions(),
            "overrides": list(self.overrides),
        }
        self.write_json(_RESULT, result)

    def write_failure(self, status: str, message: str) -> None:
        """Say in result.json that the run failed after all; the figures that are recorded already stay."""
        if not self.recorded:
            self.write_result(status, message)
            return
        result = json.loads((self.path / _RESULT).read_text(encoding="utf-8"))
        self.write_json(_RESULT, {**result, "status": status, "message": message})

    def write_json(self, name: str, entries: Mapping[str, Any]) -> None:
        """Write a JSON file by atomic rename; what is not finite is null."""
        text = json.dumps(_plain(entries), indent=2, allow_nan=False)
        with self.whole(name) as part:
            part.write_text(text + "\n", encoding="utf-8")

    @contextlib.contextmanager
    def whole(self, name: str) -> Iterator[Path]:
        """A path to write a file to, which gets its name once it is whole and is removed if it never is."""
        part = self.path / f".{name}.{os.getpid()}"
        try:
            yield part
            part.replace(self.path / name)
        finally:
            part.unlink(missing_ok=True)

    def write_text(self, name: str, text: str) -> None:
        """Write a file of text."""
        (self.path / name).write_text(text, encoding="utf-8")

    def write_program(self, stand: Stand, settings: Array, held: int = 0, name: str = "program.csv") -> None:
        """program.csv: settings, angles in degrees, and the unit vector of the vertical in sensor axes.

        Where the first positions are held, a last column says which are fixed and which were chosen.
        """
        header, rows = ["position", *_columns(stand)], _rows(stand, settings)
        if held:
            header.append("fixed")
            rows = [[*row, "yes" if number <= held else "no"] for number, row in enumerate(rows, 1)]
        self.write_table(name, header, rows)

    def write_front(
        self, stand: Stand, names: Sequence[str], front: Sequence[FrontPoint], knee: int | None, held: int = 0
    ) -> None:
        """front.csv: the value of each objective, the exponential of its loss, and the loss; front/NN.csv: programs.

        A value that no double holds is written with its digits all the same; ``log_NAME`` is to compute with.
        """
        (self.path / "front").mkdir()
        width = max(2, len(str(len(front))))
        rows = []
        for number, point in enumerate(front, 1):
            losses = point.losses.tolist()
            rows.append([number, *map(_value, losses), int(number - 1 == knee), *map(repr, losses)])
            self.write_program(stand, point.settings, held, f"front/{number:0{width}}.csv")
        self.write_table("front.csv", ["point", *names, "knee", *(f"log_{name}" for name in names)], rows)

    def write_alternatives(self, stand: Stand, solutions: Iterable[Solution]) -> None:
        """alternatives.csv: all programs that are equally good, the best first."""
        rows = [
            [number, repr(solution.loss), *row]
            for number, solution in enumerate(solutions, 1)
            for row in _rows(stand, solution.settings)
        ]
        self.write_table("alternatives.csv", ["program", "loss", "position", *_columns(stand)], rows)

    def write_weights(self, stand: Stand, design: ApproximateDesign) -> None:
        """weights.csv: the positions of an approximate design, the heaviest support point first.

        Neighbors on the grid that belong to the same support point have the same number.
        """
        totals = np.bincount(design.points, design.weights)
        rank = np.empty(len(totals), dtype=int)
        rank[np.argsort(-totals, kind="stable")] = np.arange(1, len(totals) + 1)
        order = np.lexsort([-design.weights, rank[design.points]])
        weights = design.weights[order].tolist()
        rows = [
            [int(rank[design.points[k]]), *row[1:], repr(weight), repr(100 * weight)]
            for k, row, weight in zip(order, _rows(stand, design.settings[order]), weights, strict=True)
        ]
        self.write_table("weights.csv", ["point", *_columns(stand), "weight", "dwell_share"], rows)

    def write_history(self, history: Iterable[tuple[int, float, float]]) -> None:
        """history.csv: the best loss against evaluations and seconds."""
        rows = [[evaluations, f"{seconds:.6f}", repr(loss)] for evaluations, seconds, loss in history]
        self.write_table("history.csv", ["evaluations", "seconds", "loss"], rows)

    def write_survey(self, survey: Survey, name: str = "landscape.csv") -> None:
        """landscape.csv: the loss per measurement of each sequence with each number of positions."""
        rows = [
            [*map(repr, sequence), number, repr(loss)]
            for sequence, losses in zip(survey.sequences.tolist(), survey.losses.tolist(), strict=True)
            for number, loss in zip(survey.numbers.tolist(), losses, strict=True)
        ]
        self.write_table(name, [*survey.names, "n", "loss_per_measurement"], rows)

    def write_table(self, name: str, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
        """Write a CSV file of the run: a header, then the rows, all of the same width."""
        with (self.path / name).open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(header)
            writer.writerows(rows)


@cache
def versions() -> Mapping[str, str]:
    """Versions of what a result depends on."""
    names = ("acalx", "numpy", "scipy", "pymoo", "hydra-core")
    found = {name: metadata.version(name) for name in names}
    return {**found, "python": platform.python_version(), "platform": sys.platform}


def _columns(stand: Stand) -> list[str]:
    vertical = stand.stimulus(stand.axes.bounds[:, 0][None]).vertical() is not None
    return [*stand.axes.columns, *(("eta_x", "eta_y", "eta_z") if vertical else ())]


def _rows(stand: Stand, settings: Array) -> list[list[Any]]:
    force = stand.stimulus(settings).vertical()
    angles = stand.axes.written(settings).tolist()
    directions = [[]] * len(angles) if force is None else (force + 0.0).tolist()
    return [
        [number, *map(repr, row), *map(repr, eta)]
        for number, (row, eta) in enumerate(zip(angles, directions, strict=True), 1)
    ]


def _value(loss: float) -> str:
    """The value of a loss with all its digits, also where no double holds it."""
    value = from_log(loss)
    return repr(value) if 0.0 < value < np.inf else written_from_log(loss, 17)


def _plain(value: Any) -> Any:
    """The value as JSON has it: arrays as lists, what is not finite as null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(entry) for entry in value]
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
