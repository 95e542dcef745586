"""What a run of acalx.run leaves in its directory."""

from __future__ import annotations

from typing import Any

from acalx.criteria import Criterion, Objectives
from acalx.numerics.arrays import Array
from acalx.planning.design import Designed, Request
from acalx.planning.metrics import figures_of_merit
from acalx.planning.smallest import Smallest
from acalx.problem import Problem
from acalx.programs import find_program
from acalx.quantities.magnitude import double_of
from acalx.recording.parts import described, recorded_metrics
from acalx.recording.run_directory import RunDirectory
from acalx.schemes import Part
from acalx.search.result import ApproximateDesign, Front, Result

__all__ = ["asked", "names_of", "record", "record_result"]


def names_of(criterion: Criterion | Objectives) -> tuple[str, ...]:
    """What the criterion is called, or each of several objectives."""
    return criterion.labels if isinstance(criterion, Objectives) else (criterion.label,)


def asked(problem: Problem, request: Request) -> dict[str, Any]:
    """What every result of a run says of its problem and its request, also where the search fails."""
    return {
        "n": problem.n,
        "model": described(problem.model),
        "stand": described(problem.stand),
        "criterion": described(problem.criterion),
        "optimizer": described(request.optimizer_for(problem)),
        "scheme": described(request.scheme),
        "order": request.order,
    }


def record(designed: Designed, directory: RunDirectory) -> None:
    """The program, what is as good, how the search went; and what every result of this run says."""
    problem, result, request = designed.problem, designed.result, designed.request
    directory.write_program(problem.stand, designed.program, problem.held)
    if isinstance(result, Front):
        directory.write_front(problem.stand, names_of(problem.criterion), result.points, result.knee, problem.held)
    if isinstance(result, Result):
        directory.write_alternatives(problem.stand, result.solutions)
        directory.write_history(result.history)
        if result.survey is not None:
            directory.write_survey(result.survey)
        if result.design is not None:
            directory.write_weights(problem.stand, result.design)
    for part in designed.parts:
        if isinstance(part.result, Result) and part.result.survey is not None:
            directory.write_survey(part.result.survey, f"landscape_{part.name}.csv")
    directory.remember(
        **asked(problem, request),
        **designed.visit.entries(request.dwell_s),
        **_part_entries(designed.parts),
        **_smallest_entries(designed.smallest),
    )


def record_result(designed: Designed, directory: RunDirectory, **seconds: float) -> str:
    """result.json; gives how the program as written contradicts the search, nothing where it does not.

    All figures are computed anew from program.csv. Where its loss is another than the search's, the
    run has failed: a model that depends on the order of positions, or on digits that are not written.

    Parameters
    ----------
    designed : Designed
    directory : RunDirectory
        In which the program is written already.
    **seconds
        Of the whole, as ``total``, and of further parts of the run.
    """
    problem, result = designed.problem, designed.result
    written = find_program(str(directory.path / "program.csv"), problem.stand).settings_for(problem.stand)
    status, message = str(result.status), result.message
    wrong = designed.contradiction(written)
    if wrong:
        status, message = "failed", wrong
    parts = {**designed.seconds, **seconds}
    directory.write_result(
        status,
        message,
        metrics=recorded_metrics(figures_of_merit(problem.information(written))),
        evaluations=result.evaluations,
        seconds=parts.pop("total", sum(designed.seconds.values())),
        seconds_by_part=parts,
        certificate=None if designed.certificate is None else designed.certificate.entries(),
        remarks=designed.remarks,
        **_found_entries(designed, written),
    )
    return wrong


def _found_entries(designed: Designed, written: Array) -> dict[str, Any]:
    """What belongs to the kind of answer; losses are those of the program as written."""
    result, problem = designed.result, designed.problem
    losses = [float(single.objective.loss(written)) for single in problem.singles]
    if isinstance(result, Front):
        values = [double_of(loss) for loss in losses]
        several = {"objectives": names_of(problem.criterion), "losses": losses, "values": values}
        front = {"points": len(result.points), "knee": result.knee + 1}
        return {**several, **front, "loss": None, "value": None, "gain": None, "alternatives": 0}
    assert isinstance(result, Result)
    (loss,) = losses
    entries = {"loss": loss, "value": double_of(loss), "gain": result.gain, "alternatives": len(result.solutions) - 1}
    return {**entries, **_design_entries(result.design)}


def _part_entries(parts: tuple[Part, ...]) -> dict[str, Any]:
    """What each part of the model got."""
    told = [
        {
            "part": part.name,
            "positions": len(part.settings),
            "dropped": part.dropped,
            "loss": None if part.result is None else part.result.best.loss,
            "message": "" if part.result is None else part.result.message,
        }
        for part in parts
    ]
    return {"parts": told} if told else {}


def _smallest_entries(smallest: Smallest | None) -> dict[str, Any]:
    return {} if smallest is None else smallest.recorded


def _design_entries(design: ApproximateDesign | None) -> dict[str, Any]:
    """The approximate design in result.json, where the optimizer gives one."""
    if design is None:
        return {}
    entries = {
        "value": double_of(design.loss),
        "loss": design.loss,
        "gap": design.gap,
        "efficiency": 1.0 / (1.0 + design.gap),
        "support_points": design.count,
        "positions": len(design.weights),
        "candidates": design.candidates,
        "method": design.method,
    }
    return {"design": entries}
