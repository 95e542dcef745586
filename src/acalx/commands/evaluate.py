"""Figures of merit of a program that someone already uses: ``python -m acalx.evaluate program=NAME-or-CSV``."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from typing import Any

from omegaconf import DictConfig, OmegaConf

from acalx.bounds import certify
from acalx.commands.launch import FAILED, Entry, build, launch
from acalx.criteria import Criterion
from acalx.errors import ArgumentError
from acalx.models import Model
from acalx.planning.metrics import best_published, figures_of_merit
from acalx.problem import Problem
from acalx.programs import Program, find_program, published
from acalx.recording import RunDirectory
from acalx.reporting.tables import align, figures_table, program_table
from acalx.stands import Stand

__all__ = ["ENTRY", "main"]


@dataclass
class EvaluateConfig:
    """Root of the configuration; the groups are built from what they name."""

    program: Any = "???"
    model: Any = None
    stand: Any = None
    criterion: Any = None
    certificate: bool = True
    figures: bool = True
    traceback: bool = False


def evaluate(config: DictConfig, directory: RunDirectory) -> int:
    """Find the program, compute its figures, record, show."""
    started = time.perf_counter()
    if OmegaConf.is_missing(config, "program"):
        raise ArgumentError(f"which program? Give program=FILE.csv or program=NAME; names: {', '.join(published())}")
    directory.remember(program=str(config.program), inestimable=[])
    stand, model = build(config, "stand", Stand), build(config, "model", Model)
    criterion = build(config, "criterion", Criterion)
    program = find_program(str(config.program))
    directory.remember(n=program.n)
    settings = program.settings_for(stand)
    information = model.information(stand.stimulus(settings))
    unseen = information.inestimable()
    directory.write_program(stand, settings)
    print(f"{program.title}\n\n{program_table(stand, settings)}\n")
    outside = [str(k + 1) for k, allowed in enumerate(stand.axes.allows(settings, tolerance=1e-6)) if not allowed]
    if outside:
        print(f"the stand as it is set here can't take position {', '.join(outside)}\n")
    if unseen:
        return _singular(program, unseen, directory, time.perf_counter() - started)
    problem = Problem(stand, model, criterion, program.n)
    loss = float(problem.objective.loss(settings))
    certificate = certify(problem, settings) if config.certificate and not outside else None  # else incomparable
    _show(problem, program, figures_of_merit(information))
    if certificate is not None:
        print(f"{certificate}\n")
    if config.figures:
        from acalx.reporting.figures import draw_entries, draw_positions

        stimulus = stand.stimulus(settings)
        if stimulus.specific_force is not None:
            draw_positions(stimulus.specific_force, directory.path, program.title)
        draw_entries({program.name: model.regressors(stimulus)}, directory.path)
    directory.write_result(
        "ok",
        program.title,
        metrics=figures_of_merit(information),
        loss=loss,
        certificate=None if certificate is None else certificate.entries(),
        evaluations=1,
        seconds=time.perf_counter() - started,
        outside=[int(number) for number in outside],
    )
    print(f"written to {directory.path}")
    return 0


def _show(problem: Problem, program: Program, metrics: dict[str, Any]) -> None:
    columns = {program.name: metrics}
    reference = best_published(problem)
    if reference is not None and reference.name != program.name:
        other = problem.information(reference.settings_for(problem.stand))
        columns[f"best published: {reference.name}"] = figures_of_merit(other)
    print(f"{align(figures_table(columns))}\n")
    deviations = [["standard deviation", "", "unit"]]
    for parameter, value in zip(problem.parameters, metrics["standard_deviations"].values(), strict=True):
        deviations.append([parameter.name, f"{value:.4f}", parameter.unit])
    print(f"{align(deviations)}\n")


def _singular(program: Program, unseen: list[str], directory: RunDirectory, seconds: float) -> int:
    """The answer where some parameters can't be estimated: which combinations of them."""
    message = (
        f"{program.name}: its {program.n} positions can't estimate all the parameters; "
        f"they can't see: {'; '.join(unseen)}"
    )
    directory.write_result("singular", message, inestimable=unseen, evaluations=1, seconds=seconds)
    print(f"acalx: {message}", file=sys.stderr)
    return FAILED


ENTRY = Entry("evaluate", "evaluate", EvaluateConfig, evaluate)


def main() -> int:
    """Entry point."""
    return launch(ENTRY)


if __name__ == "__main__":
    sys.exit(main())
