"""What acalx.evaluate shows of a given program."""

from __future__ import annotations

from pathlib import Path

from acalx.planning.evaluation import Evaluation
from acalx.planning.metrics import figures_of_merit
from acalx.quantities.magnitude import significant
from acalx.reporting.tables import align, figures_table, program_table

__all__ = ["draw", "show_figures", "show_program"]


def show_program(evaluation: Evaluation) -> None:
    """Print the positions, and which of them the stand can't take."""
    print(f"{evaluation.program.title}\n\n{program_table(evaluation.stand, evaluation.settings)}\n")
    if evaluation.outside:
        numbers = ", ".join(map(str, evaluation.outside))
        print(f"the stand as it is set here can't take position {numbers}\n")


def show_figures(evaluation: Evaluation) -> None:
    """Print figures of merit beside the best published program, standard deviations, the certificate."""
    metrics, reference = evaluation.metrics, evaluation.reference
    columns = {evaluation.program.name: metrics}
    if reference is not None:
        other = evaluation.problem.information(reference.settings_for(evaluation.stand))
        columns[f"best published: {reference.name}"] = figures_of_merit(other)
    print(f"{align(figures_table(columns))}\n")
    deviations = [["standard deviation", "", "unit"]]
    for parameter in evaluation.model.parameters:
        deviation = significant(metrics["standard_deviations"][parameter.name])
        deviations.append([parameter.name, deviation, parameter.unit])
    print(f"{align(deviations)}\n")
    for remark in evaluation.remarks:
        print(f"{remark}\n")
    if evaluation.certificate is not None:
        print(f"{evaluation.certificate}\n")


def draw(evaluation: Evaluation, directory: Path) -> None:
    """Draw all the figures of the evaluation into a directory, as SVG and PNG."""
    from acalx.reporting.figures import draw_entries, draw_verticals

    draw_verticals(evaluation.stand.stimulus(evaluation.settings), directory, evaluation.program.title)
    draw_entries({evaluation.program.name: evaluation.problem.response.regressors(evaluation.settings)}, directory)
