"""Design a calibration program: ``python -m acalx.run model=scalar_accel criterion=d_fair optimizer=de n=9``."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass, replace
from typing import Any

from omegaconf import DictConfig

from acalx.commands.asked import certificate_of, problem_of, request_of
from acalx.commands.composition import RESOLVED, composed, resolved
from acalx.commands.launch import FAILED, INTERRUPTED, Entry, launch
from acalx.planning.design import Designed, searched
from acalx.recording import RunDirectory
from acalx.recording.design import asked, record, record_result
from acalx.reporting.design import draw, show
from acalx.reporting.progress import Progress

__all__ = ["ENTRY", "main"]


@dataclass
class RunConfig:
    """Root of the configuration; the groups are built from what they name."""

    model: Any = None
    stand: Any = None
    criterion: Any = None
    objectives: Any = None
    optimizer: Any = None
    scheme: Any = None
    n: Any = None
    target: Any = None
    n_most: Any = 500
    fixed: Any = None
    replicates: Any = True
    orient: Any = None
    order: Any = "given"
    dwell_s: Any = 60
    seed: Any = 0
    certificate: Any = "auto"
    figures: bool = True
    traceback: bool = False


def run(config: DictConfig, directory: RunDirectory) -> int:
    """Design what the configuration asks for, record it, show it; gives the exit status."""
    started = time.perf_counter()
    directory.remember(n=config.n, seed=config.seed)
    config = composed(config, directory.overrides)
    directory.write_text(RESOLVED, resolved(config, ENTRY.name))
    bounded, problem, request = certificate_of(config), problem_of(config), request_of(config)
    directory.remember(**asked(problem, request))
    progress = Progress()
    try:
        designed = searched(problem, request, progress)
    finally:
        progress.close()
    if designed.smallest is not None:
        print(f"{designed.smallest}\n")
    record(designed, directory)  # before anything else can go wrong
    wrong = record_result(designed, directory, total=time.perf_counter() - started)
    if bounded and not wrong and designed.status != "interrupted":
        designed = designed.certified()
        record_result(designed, directory, total=time.perf_counter() - started)
    show(designed)
    print(f"written to {directory.path}")
    if config.figures:
        try:
            _draw(designed, directory, started)
        except KeyboardInterrupt:
            result = designed.result.ended("interrupted", f"{designed.result.message}; interrupted while drawing")
            designed = replace(designed, result=result)
            record_result(designed, directory, total=time.perf_counter() - started)
    if wrong:
        print(f"acalx: {wrong}", file=sys.stderr)
        return FAILED
    return INTERRUPTED if designed.status == "interrupted" else 0


def _draw(designed: Designed, directory: RunDirectory, started: float) -> None:
    """The figures, and how long they took."""
    begun = time.perf_counter()
    draw(designed, directory.path)
    now = time.perf_counter()
    record_result(designed, directory, drawing=now - begun, total=now - started)


ENTRY = Entry("run", "config", RunConfig, run)


def main() -> int:
    """Design a program as the command line says; returns the exit status."""
    return launch(ENTRY)


if __name__ == "__main__":
    sys.exit(main())
