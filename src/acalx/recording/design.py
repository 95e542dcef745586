"""What a run of acalx.run leaves in its directory."""

from __future__ import annotations

import math
from typing import Any

from acalx.bounds.certificate import Certificate
from acalx.criteria import Objectives
from acalx.planning.metrics import figures_of_merit
from acalx.problem import Problem
from acalx.recording.run_directory import RunDirectory
from acalx.schemes import Part
from acalx.search.result import ApproximateDesign, Found, Front, Result

__all__ = ["record", "record_parts", "record_result"]


def record_parts(parts: tuple[Part, ...], directory: RunDirectory) -> None:
    """What each part of the model got, with its landscape where there is one."""
    if not parts:
        return
    told = []
    for part in parts:
        found = part.result
        told.append(
            {
                "part": part.name,
                "positions": len(part.settings),
                "dropped": part.dropped,
                "loss": None if found is None else found.best.loss,
                "message": "" if found is None else found.message,
            }
        )
        if found is not None and found.survey is not None:
            directory.write_survey(found.survey, f"landscape_{part.name}.csv")
    directory.remember(parts=told)


def record(problem: Problem, result: Found, directory: RunDirectory) -> None:
    """The program, what is as good, how the search went, and the result without a certificate."""
    directory.write_program(problem.stand, result.program, problem.held)
    if isinstance(result, Front):
        directory.write_front(problem.stand, names_of(problem), result.points, result.knee, problem.held)
    if isinstance(result, Result):
        directory.write_alternatives(problem.stand, result.solutions)
        directory.write_history(result.history)
        if result.survey is not None:
            directory.write_survey(result.survey)
        if result.design is not None:
            directory.write_weights(problem.stand, result.design)
    record_result(problem, result, None, directory)


def names_of(problem: Problem) -> tuple[str, ...]:
    """What the criterion is called, or each of several objectives."""
    return problem.criterion.labels if isinstance(problem.criterion, Objectives) else (problem.criterion.label,)


def record_result(problem: Problem, result: Found, certificate: Certificate | None, directory: RunDirectory) -> None:
    """result.json."""
    entries: dict[str, Any] = {}
    if isinstance(result, Front):
        losses = result.points[result.knee].losses
        entries = {
            "objectives": names_of(problem),
            "losses": losses,
            "points": len(result.points),
            "knee": result.knee + 1,
        }
        entries |= {"loss": None, "gain": None, "alternatives": 0}
    if isinstance(result, Result):
        entries = {"loss": result.best.loss, "gain": result.gain, "alternatives": len(result.solutions) - 1}
        entries |= _design_entries(result.design)
    directory.write_result(
        result.status,
        result.message,
        n=problem.n,
        metrics=figures_of_merit(problem.information(result.program)),
        evaluations=result.evaluations,
        seconds=result.seconds,
        certificate=None if certificate is None else certificate.entries(),
        **entries,
    )


def _design_entries(design: ApproximateDesign | None) -> dict[str, Any]:
    """The approximate design in result.json, where the optimizer gives one."""
    if design is None:
        return {}
    entries = {
        "value": math.exp(design.loss),
        "loss": design.loss,
        "gap": design.gap,
        "efficiency": 1.0 / (1.0 + design.gap),
        "support_points": design.count,
        "positions": len(design.weights),
        "candidates": design.candidates,
        "method": design.method,
    }
    return {"design": entries}
