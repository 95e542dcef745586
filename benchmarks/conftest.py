"""Collects the ratios of a run and prints them at its end."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from statistics import median
from typing import Any

import pytest

# Before numpy is imported. On matrices this small a second thread only waits for the first, which on
# a busy machine slows scipy's L-BFGS-B tenfold and would flatter acalx.
os.environ["OPENBLAS_NUM_THREADS"] = "1"
# As where people work: commands keep what Python has compiled.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

_ROWS: list[list[str]] = []


@dataclass
class Comparison:
    """Times ours with pytest-benchmark and theirs just before each round of it, in turn."""

    benchmark: Any
    title: str
    theirs: list[float] = field(default_factory=list)

    def __call__(self, ours: Callable[[int], Any], theirs: Callable[[int], Any], rounds: int) -> None:
        """Run both so many times; each takes the number of the round."""
        numbers = iter(range(rounds))

        def before() -> tuple[tuple[int], dict[str, Any]]:
            number = next(numbers)
            started = time.perf_counter()
            theirs(number)
            self.theirs.append(time.perf_counter() - started)
            return (number,), {}

        self.benchmark.pedantic(ours, setup=before, rounds=rounds)

    @property
    def seconds(self) -> tuple[float, float]:
        """Median times, ours and theirs."""
        return self.benchmark.stats.stats.median, median(self.theirs)

    def faster(self, times: float, remark: str = "") -> bool:
        """Whether ours is so many times faster; reports it."""
        ours, theirs = self.seconds
        self.report(f">= {times:g} x", f"{theirs / ours:.1f} x", remark)
        return theirs / ours >= times

    def at_most(self, times: float, remark: str = "") -> bool:
        """Whether ours takes no longer than so many times theirs; reports it."""
        ours, theirs = self.seconds
        self.report(f"<= {times:g} x", f"{ours / theirs:.2f} x", remark)
        return ours / theirs <= times

    def report(self, required: str, measured: str, remark: str) -> None:
        ours, theirs = self.seconds
        self.benchmark.extra_info.update(theirs=theirs, measured=measured)
        _ROWS.append([self.title, required, measured, f"{ours:.3g} s", f"{theirs:.3g} s", remark])


@pytest.fixture
def comparison(benchmark, request):
    return Comparison(benchmark, request.node.name.removeprefix("test_").replace("_", " "))


@pytest.fixture
def note():
    """Reports a figure that is not a ratio of times."""
    return lambda title, required, measured: _ROWS.append([title, required, measured, "", "", ""])


def pytest_terminal_summary(terminalreporter):
    if not _ROWS:
        return
    rows = [["", "required", "measured", "acalx", "other", ""], *_ROWS]
    widths = [max(len(row[k]) for row in rows) for k in range(6)]
    terminalreporter.section("ratios")
    for row in rows:
        terminalreporter.write_line("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)))
