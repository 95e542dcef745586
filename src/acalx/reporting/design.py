"""What acalx.run shows of the program that it designed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from acalx.certificate import Certificate
from acalx.metrics import figures_of_merit, published_losses
from acalx.optimizers import Result
from acalx.problem import Problem
from acalx.programs import Program
from acalx.reporting.tables import align, figures_table, program_table, units_line, weights_table
from acalx.schemes import Designed

__all__ = ["draw", "show"]


def draw(problem: Problem, designed: Designed, reference: Program | None, directory: Path) -> None:
    """All the figures, into a directory."""
    from acalx.reporting.figures import draw_convergence, draw_entries, draw_landscape, draw_positions

    result = designed.result
    stimulus = problem.stand.stimulus(result.best.settings)
    if stimulus.specific_force is not None:
        draw_positions(stimulus.specific_force, directory, f"{problem.n} positions of the vertical")
    if result.front and result.knee is not None:
        from acalx.reporting.front_figure import draw_front

        values = np.exp([point.losses for point in result.front])
        others = {
            program.name: np.exp(losses)
            for program, losses in published_losses(problem)
            if problem.stand.allows(program.settings_for(problem.stand), tolerance=1e-6).all()
        }
        names = problem.criterion.objective_names
        draw_front(names, values, result.knee, directory, f"{problem.n} positions: {result.message}", others)
    elif result.survey is not None:
        draw_landscape(result.survey.numbers, result.survey.losses, directory)
    elif designed.parts:
        for part in designed.parts:
            if part.result is not None and part.result.survey is not None:
                survey = part.result.survey
                draw_landscape(survey.numbers, survey.losses, directory, f"landscape_{part.name}")
    else:
        draw_convergence(result.history, directory)
    entries = {"this program": problem.model.regressors(stimulus)}
    if reference is not None:
        feels = problem.stand.stimulus(reference.settings_for(problem.stand))
        entries[reference.name] = problem.model.regressors(feels)
    draw_entries(entries, directory)


def show(
    problem: Problem,
    result: Result,
    reference: Program | None,
    certificate: Certificate | None,
) -> None:
    """Program and figures on the terminal."""
    settings = result.best.settings
    columns = {"this program": figures_of_merit(problem.information(settings))}
    if result.front and result.knee is not None:
        columns = _notable(problem, result)
    if reference is not None:
        other = reference.settings_for(problem.stand)
        columns[reference.name] = figures_of_merit(problem.information(other))
    print(program_table(problem.stand, settings, problem.held))
    print()
    if result.design is not None:
        print(weights_table(problem.stand, *result.design.merged()))
        print()
    print(align(figures_table(columns)))
    print(units_line(problem.parameters))
    print()
    print(f"{result.message}; {result.evaluations} programs in {result.seconds:.2f} s")
    if certificate is not None:
        print(f"{certificate}")
    if result.gain is not None:
        print(f"the polish lowered the loss by {result.gain:.3g}, to {result.best.loss:.6f}")
    if result.front:
        print("above are the ends and the knee, which is program.csv; front.csv has all the points")
    if len(result.solutions) > 1:
        print(f"{len(result.solutions) - 1} other programs are as good; see alternatives.csv")


def _notable(problem: Problem, result: Result) -> dict[str, dict[str, Any]]:
    """Figures of the ends of a front and of its knee, each with its number."""
    losses = np.array([point.losses for point in result.front])
    numbers = {f"best {name}": int(losses[:, k].argmin()) for k, name in enumerate(problem.criterion.objective_names)}
    assert result.knee is not None
    chosen = {"knee": result.knee, **numbers}
    return {
        f"{name} ({number + 1})": figures_of_merit(problem.information(result.front[number].settings))
        for name, number in chosen.items()
    }
