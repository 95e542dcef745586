"""What acalx.run shows of the program that it designed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from acalx.bounds.certificate import Certificate
from acalx.planning.metrics import figures_of_merit, published_losses
from acalx.problem import Problem
from acalx.programs import Program
from acalx.recording.design import names_of
from acalx.reporting.tables import align, figures_table, program_table, units_line, weights_table
from acalx.schemes import Designed
from acalx.search.result import Found, Front, Result

__all__ = ["draw", "show"]


def draw(problem: Problem, designed: Designed, reference: Program | None, directory: Path) -> None:
    """All the figures, into a directory."""
    from acalx.reporting.figures import draw_convergence, draw_entries, draw_landscape, draw_positions

    result = designed.result
    stimulus = problem.stand.stimulus(result.program)
    if stimulus.specific_force is not None:
        draw_positions(stimulus.specific_force, directory, f"{problem.n} positions of the vertical")
    if isinstance(result, Front):
        from acalx.reporting.front_figure import draw_front

        values = np.exp([point.losses for point in result.points])
        others = {
            program.name: np.exp(losses)
            for program, losses in published_losses(problem)
            if problem.stand.axes.allows(program.settings_for(problem.stand), tolerance=1e-6).all()
        }
        names = names_of(problem)
        draw_front(names, values, result.knee, directory, f"{problem.n} positions", others)
    elif isinstance(result, Result) and result.survey is not None:
        draw_landscape(result.survey.numbers, result.survey.losses, directory)
    elif designed.parts:
        for part in designed.parts:
            if isinstance(part.result, Result) and part.result.survey is not None:
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
    result: Found,
    reference: Program | None,
    certificate: Certificate | None,
) -> None:
    """Program and figures on the terminal."""
    settings = result.program
    columns = {"this program": figures_of_merit(problem.information(settings))}
    if isinstance(result, Front):
        columns = _notable(problem, result)
    if reference is not None:
        other = reference.settings_for(problem.stand)
        possible = problem.stand.axes.allows(other, tolerance=1e-6).all()
        name = reference.name if possible else f"{reference.name} (not on this stand)"
        columns[name] = figures_of_merit(problem.information(other))
    print(program_table(problem.stand, settings, problem.held))
    print()
    if isinstance(result, Result) and result.design is not None:
        print(weights_table(problem.stand, *result.design.merged()))
        print()
    print(align(figures_table(columns)))
    print(units_line(problem.parameters))
    print()
    print(f"{result.message}; {result.evaluations} programs in {result.seconds:.2f} s")
    if certificate is not None:
        print(f"{certificate}")
    if isinstance(result, Result) and result.gain is not None:
        print(f"the polish lowered the loss by {result.gain:.3g}, to {result.best.loss:.6f}")
    if isinstance(result, Front):
        print("above are the ends and the knee, which is program.csv; front.csv has all the points")
    if isinstance(result, Result) and len(result.solutions) > 1:
        print(f"{len(result.solutions) - 1} other programs are as good; see alternatives.csv")


def _notable(problem: Problem, result: Front) -> dict[str, dict[str, Any]]:
    """Figures of the ends of a front and of its knee, each with its number."""
    losses = np.array([point.losses for point in result.points])
    numbers = {f"best {name}": int(losses[:, k].argmin()) for k, name in enumerate(names_of(problem))}
    chosen = {"knee": result.knee, **numbers}
    return {
        f"{name} ({number + 1})": figures_of_merit(problem.information(result.points[number].settings))
        for name, number in chosen.items()
    }
