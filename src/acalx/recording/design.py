"""What a run of acalx.run leaves in its directory."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from acalx.certificate import Certificate
from acalx.metrics import figures_of_merit
from acalx.optimizers import Design, Result
from acalx.problem import Problem
from acalx.recording.run_directory import RunDirectory
from acalx.schemes import Part

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


def record(problem: Problem, result: Result, directory: RunDirectory) -> None:
    """The program, what is as good, how the search went, and the result without a certificate."""
    directory.write_program(problem.stand, result.best.settings, problem.held)
    if result.front:
        directory.write_front(problem.stand, problem.criterion.objective_names, result.front, result.knee, problem.held)
    else:
        directory.write_alternatives(problem.stand, result.solutions)
        directory.write_history(result.history)
    if result.survey is not None:
        directory.write_survey(result.survey)
    if result.design is not None:
        directory.write_weights(problem.stand, result.design)
    record_result(problem, result, None, directory)


def record_result(problem: Problem, result: Result, certificate: Certificate | None, directory: RunDirectory) -> None:
    """result.json."""
    front: dict[str, Any] = {}
    if result.front and result.knee is not None:
        names, losses = problem.criterion.objective_names, result.front[result.knee].losses
        front = {"objectives": names, "losses": losses, "points": len(result.front), "knee": result.knee + 1}
    directory.write_result(
        result.status,
        result.message,
        n=problem.n,
        metrics=figures_of_merit(problem.information(result.best.settings)),
        loss=result.best.loss,
        evaluations=result.evaluations,
        seconds=result.seconds,
        gain=result.gain,
        alternatives=len(result.solutions) - 1,
        certificate=None if certificate is None else asdict(certificate),
        **front,
        **_design_entries(result.design),
    )


def _design_entries(design: Design | None) -> dict[str, Any]:
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
