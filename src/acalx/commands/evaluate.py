"""Figures of merit of a program that someone already uses: ``python -m acalx.evaluate program=NAME-or-CSV``."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from typing import Any

from omegaconf import DictConfig

from acalx.commands.composition import build, build_model
from acalx.commands.launch import FAILED, Entry, launch
from acalx.commands.options import program_of
from acalx.criteria import Criterion
from acalx.planning.evaluation import evaluate
from acalx.programs import find_program
from acalx.recording import RunDirectory
from acalx.recording.evaluation import record, record_result, singular_message
from acalx.recording.parts import described
from acalx.reporting.evaluation import draw, show_figures, show_program
from acalx.stands import Stand

__all__ = ["ENTRY", "main"]


@dataclass
class EvaluateConfig:
    """Root of the configuration; the groups are built from what they name."""

    program: Any = "???"
    model: Any = None
    stand: Any = None
    criterion: Any = None
    dwell_s: Any = 60
    certificate: bool = True
    figures: bool = True
    traceback: bool = False


def run(config: DictConfig, directory: RunDirectory) -> int:
    """Read a program, evaluate it, record and show its figures; the exit status is 1 where it is singular."""
    started = time.perf_counter()
    name = program_of(config)
    directory.remember(program=name, inestimable=[])
    stand, model = build(config, "stand", Stand), build_model(config)
    criterion = build(config, "criterion", Criterion)
    directory.remember(model=described(model), stand=described(stand), criterion=described(criterion))
    program = find_program(name, stand)
    directory.remember(n=program.n)
    evaluation = evaluate(program, stand, model, criterion, certificate=False, dwell_s=config.dwell_s)
    show_program(evaluation)
    record(evaluation, directory)
    parts: dict[str, float] = {}
    record_result(evaluation, directory, time.perf_counter() - started)
    if config.certificate:
        begun = time.perf_counter()
        evaluation = evaluation.certified()
        parts["certificate"] = time.perf_counter() - begun
    record_result(evaluation, directory, time.perf_counter() - started, **parts)
    if evaluation.inestimable:
        print(f"acalx: {singular_message(evaluation)}", file=sys.stderr)
        return FAILED
    show_figures(evaluation)
    if config.figures:
        begun = time.perf_counter()
        draw(evaluation, directory.path)
        now = time.perf_counter()
        record_result(evaluation, directory, now - started, **parts, drawing=now - begun)
    print(f"written to {directory.path}")
    return 0


ENTRY = Entry("evaluate", "evaluate", EvaluateConfig, run)


def main() -> int:
    """Evaluate a program as the command line says; returns the exit status."""
    return launch(ENTRY)


if __name__ == "__main__":
    sys.exit(main())
