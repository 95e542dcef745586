"""Static positions found in a raw recording."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.errors import ArgumentError, DataError, Option
from acalx.estimation.blocks import Blocks, Interval, Run
from acalx.estimation.files import AXES, data_file, find_columns
from acalx.estimation.readings import Readings
from acalx.files import CsvFile
from acalx.numerics.arrays import Array
from acalx.options import is_number

__all__ = ["StaticIntervals"]

# Bins of the histogram of variances: per octave, and the range in octaves about 1.
_BINS, _OCTAVES = 16, 200


@final
@dataclass(frozen=True)
class StaticIntervals:
    """Finds static intervals in a recording by the variance of its samples.

    The recording is cut into blocks of `block_s`. A block is quiet where the variance over
    the window of `window_s` centered on it, summed over the axes, is at most `factor` squared
    times that of the quiet part of the recording: the variance that a share `quiet` of
    all windows is below. A run of quiet blocks that lasts `shortest_s` or longer is
    an interval; a block at each of its ends is left out, since the motion reaches into it.

    The file is read twice, a block of rows at a time, so it may be larger than memory.

    Parameters
    ----------
    window_s, block_s, shortest_s : float, s
    factor : float
        In standard deviations.
    quiet : float
        A share of the recording that is certainly static.
    rate_hz : float, optional
        Samples per second, where the file has no column ``t_s``.

    Raises
    ------
    ArgumentError
        Options that are not positive, a window shorter than a block.
    """

    window_s: float = 1.0
    block_s: float = 0.1
    shortest_s: float = 2.0
    factor: float = 3.0
    quiet: float = 0.1
    rate_hz: float | None = None

    def __post_init__(self) -> None:
        examples = {"window_s": 1.0, "block_s": 0.1, "shortest_s": 2.0, "factor": 3.0, "quiet": 0.1, "rate_hz": 100.0}
        for name, example in examples.items():
            value = getattr(self, name)
            if value is None and name == "rate_hz":
                continue
            if not is_number(value) or value <= 0:
                raise ArgumentError.of(name, value, f"give a positive number, such as {example:g}")
        if not self.block_s < self.window_s <= self.shortest_s:
            times = {name: Option(name, getattr(self, name)) for name in ("block_s", "window_s", "shortest_s")}
            raise ArgumentError("{block_s}, {window_s}, {shortest_s}: each must be longer than the one before", **times)
        if self.quiet >= 1:
            raise ArgumentError.of("quiet", self.quiet, "give a share below 1, such as 0.1")
        if self.factor <= 1:
            raise ArgumentError.of("factor", self.factor, "give a factor above 1, such as 3")

    def find(self, path: str | os.PathLike[str], columns: Sequence[str] = AXES) -> list[Interval]:
        """Find the static intervals of a recording.

        Parameters
        ----------
        path : str or path
            CSV with a sample a row, and the time in seconds in a column ``t_s``.
        columns : three names

        Raises
        ------
        DataError
            No static intervals, a file that can't be used.
        """
        file = data_file(path)
        rate = self._rate(file, columns)
        size = max(4, round(self.block_s * rate))
        width = max(1, round(self.window_s * rate / size))
        threshold = self.factor**2 * self._floor(file, columns, size, width, rate)
        intervals = [
            interval
            for interval in self._runs(file, columns, size, width, rate, threshold)
            if interval.end_s - interval.start_s >= self.shortest_s
        ]
        if not intervals:
            raise DataError(
                "{file}: no static intervals of {shortest_s:g} s in which the samples scatter by less than {most:.4g} "
                "(root of the summed variance, {times:g} times the quietest part); keep the sensor still for longer in "
                "each position, or change {shortest} and {factor}",
                file=file.path,
                shortest_s=self.shortest_s,
                most=math.sqrt(threshold),
                times=self.factor,
                shortest=Option("shortest_s", self.shortest_s),
                factor=Option("factor", self.factor),
            )
        return intervals

    def readings(self, path: str | os.PathLike[str], columns: Sequence[str] = AXES) -> Readings:
        """The same as readings in static positions.

        Raises
        ------
        DataError
            As `find`, and where there is a single interval.
        """
        found = self.find(path, columns)
        if len(found) == 1:
            scatter = float(np.sqrt((found[0].deviation ** 2).sum()))
            seconds = found[0].end_s - found[0].start_s
            raise DataError(
                f"{path}: no static intervals can be told from motion: {seconds:.4g} s in which "
                f"the samples scatter by {scatter:.4g} throughout; was the sensor never turned, or never still?"
            )
        return Readings(
            os.fspath(path),
            np.array([interval.mean for interval in found]),
            np.array([interval.deviation for interval in found]),
            np.array([float(interval.count) for interval in found]),
        )

    def _rate(self, file: CsvFile, columns: Sequence[str]) -> float:
        header = file.header()
        find_columns(file, header, columns)
        if self.rate_hz is not None:
            return float(self.rate_hz)
        if "t_s" not in header:
            raise DataError(
                "{path}: no column t_s with the time in seconds; give {rate} instead",
                path=file.path,
                rate=Option("static.rate_hz", "NUMBER", "NUMBER"),
            )
        _, times = next(file.blocks(("t_s",)), ([], np.empty((0, 1))))
        steps = np.diff(times[:, 0])
        if len(steps) < 10 or not np.median(steps) > 0:
            raise DataError(f"{file.path}: too short a recording, or times in t_s that do not go on")
        return float(1.0 / np.median(steps))

    def _blocks(self, file: CsvFile, columns: Sequence[str], size: int, rate: float) -> Iterator[Blocks]:
        """Sums of the whole recording, some thousand blocks at a time."""
        timed = self.rate_hz is None
        names = (*columns, "t_s") if timed else tuple(columns)
        rest = np.empty((0, len(names)))
        done = 0
        for _, values in file.blocks(names, size=max(2**15, 8 * size)):
            rest = np.concatenate([rest, values])
            count = len(rest) // size
            samples = rest[: count * size].reshape(count, size, len(names))
            rest = rest[count * size :]
            times = samples[..., -1] if timed else (done + np.arange(count * size).reshape(count, size)) / rate
            done += count * size
            yield Blocks.of(times, samples[..., : len(columns)])

    def _windows(
        self, file: CsvFile, columns: Sequence[str], size: int, width: int, rate: float
    ) -> Iterator[tuple[Blocks, Array]]:
        """Blocks with the variance of the window about each, summed over the axes."""
        before = width // 2
        held: Blocks | None = None
        for new in self._blocks(file, columns, size, rate):
            held = new if held is None else held.followed_by(new)
            count = len(held) - width + 1
            if count > 0:
                yield held.part(slice(before, before + count)), held.variance(size, width)
                held = held.part(slice(count, None))

    def _floor(self, file: CsvFile, columns: Sequence[str], size: int, width: int, rate: float) -> float:
        """The variance that a share `quiet` of the windows is below, by a histogram on a scale of octaves."""
        histogram = np.zeros(_OCTAVES * _BINS, dtype=np.int64)
        for _, variance in self._windows(file, columns, size, width, rate):
            octaves = np.log2(np.maximum(variance, 2.0 ** (-_OCTAVES // 2)))
            bins = np.clip(((octaves + _OCTAVES // 2) * _BINS).astype(int), 0, len(histogram) - 1)
            histogram += np.bincount(bins, minlength=len(histogram))
        total = histogram.sum()
        if total == 0:
            raise DataError(f"{file.path}: shorter than one window of {self.window_s:g} s")
        place = int(np.searchsorted(np.cumsum(histogram), self.quiet * total))
        return float(2.0 ** ((place + 1) / _BINS - _OCTAVES // 2))

    def _runs(
        self, file: CsvFile, columns: Sequence[str], size: int, width: int, rate: float, threshold: float
    ) -> Iterator[Interval]:
        """Runs of quiet blocks, summed up on the way."""
        run = Run(size)
        for blocks, variance in self._windows(file, columns, size, width, rate):
            quiet = variance <= threshold
            edges = np.flatnonzero(np.diff(quiet)) + 1
            for part in np.split(np.arange(len(quiet)), edges):
                if quiet[part[0]]:
                    run.extend(blocks.part(slice(part[0], part[-1] + 1)))
                elif (interval := run.close()) is not None:
                    yield interval
        if (interval := run.close()) is not None:
            yield interval
