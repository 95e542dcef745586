"""What acalx.run shows of the program that it designed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from acalx.planning.design import Designed
from acalx.planning.metrics import figures_of_merit, published_losses
from acalx.problem import Problem
from acalx.programs import Program
from acalx.recording.design import names_of
from acalx.reporting.tables import align, figures_table, program_table, units_line, weights_table
from acalx.search.result import Front, Result

__all__ = ["draw", "show"]


def show(designed: Designed) -> None:
    """Print the program, its figures beside the best published program, how the search ended, the certificate."""
    problem, result, reference = designed.problem, designed.result, designed.reference
    columns = _notable(problem, result) if isinstance(result, Front) else {"this program": designed.metrics}
    if reference is not None:
        columns[_titled(problem, reference)] = figures_of_merit(
            problem.information(reference.settings_for(problem.stand))
        )
    print(program_table(problem.stand, designed.program, problem.held))
    print()
    if isinstance(result, Result) and result.design is not None:
        print(weights_table(problem.stand, *result.design.merged()))
        print()
    print(align(figures_table(columns)))
    print(units_line(problem.parameters, problem.model.channels))
    print()
    print(f"{result.message}; {result.evaluations} programs in {result.seconds:.2f} s")
    if designed.certificate is not None:
        print(f"{designed.certificate}")
    if isinstance(result, Front):
        print("above are the ends and the knee, which is program.csv; front.csv has all the points")
    if isinstance(result, Result):
        _show_result(result)
    for remark in designed.remarks:
        print(remark)
    visit, request = designed.visit, designed.request
    print(f"in the order of visit ({request.order}) {visit.summary(request.dwell_s)}")


def draw(designed: Designed, directory: Path) -> None:
    """Draw all the figures of the design into a directory, as SVG and PNG."""
    from acalx.reporting.figures import draw_convergence, draw_entries, draw_landscape, draw_verticals

    problem, result, reference = designed.problem, designed.result, designed.reference
    title = f"{problem.n} positions of the vertical"
    draw_verticals(problem.stand.stimulus(designed.program), directory, title)
    if isinstance(result, Front):
        _draw_front(problem, result, directory)
    elif isinstance(result, Result) and result.survey is not None:
        draw_landscape(result.survey.numbers, result.survey.losses, directory)
    elif designed.parts:
        for part in designed.parts:
            if isinstance(part.result, Result) and part.result.survey is not None:
                survey = part.result.survey
                draw_landscape(survey.numbers, survey.losses, directory, f"landscape_{part.name}")
    else:
        draw_convergence(result.history, directory)
    entries = {"this program": problem.response.regressors(designed.program)}
    if reference is not None:
        entries[reference.name] = problem.response.regressors(reference.settings_for(problem.stand))
    draw_entries(entries, directory)


def _show_result(result: Result) -> None:
    if result.gain is not None:
        print(f"the polish lowered the loss by {result.gain:.3g}, to {result.best.loss:.6f}")
    if len(result.solutions) > 1:
        others = len(result.solutions) - 1
        print(f"{others} other program{'s are' if others > 1 else ' is'} as good; see alternatives.csv")


def _draw_front(problem: Problem, result: Front, directory: Path) -> None:
    """With the published programs that the stand can take."""
    from acalx.reporting.figures import LARGEST_DRAWN
    from acalx.reporting.front_figure import draw_front

    names, losses = names_of(problem.criterion), result.losses
    others = {program.name: each for program, each in published_losses(problem) if _possible(problem, program)}
    title = f"{problem.n} positions"
    if np.abs(losses).max() < LARGEST_DRAWN:
        values = {name: np.exp(each) for name, each in others.items()}
        draw_front(names, np.exp(losses), result.knee, directory, title, values)
    else:  # no doubles hold the values
        names = tuple(f"log10 {name}" for name in names)
        logs = {name: each / np.log(10.0) for name, each in others.items()}
        draw_front(names, losses / np.log(10.0), result.knee, directory, title, logs)


def _possible(problem: Problem, program: Program) -> bool:
    return bool(problem.stand.axes.allows(program.settings_for(problem.stand), tolerance=1e-6).all())


def _titled(problem: Problem, reference: Program) -> str:
    return reference.name if _possible(problem, reference) else f"{reference.name} (not on this stand)"


def _notable(problem: Problem, result: Front) -> dict[str, dict[str, Any]]:
    """Figures of the ends of a front and of its knee, each with its number."""
    names = names_of(problem.criterion)
    numbers = {f"best {name}": int(result.losses[:, k].argmin()) for k, name in enumerate(names)}
    return {
        f"{name} ({number + 1})": figures_of_merit(problem.information(result.points[number].settings))
        for name, number in {"knee": result.knee, **numbers}.items()
    }
