"""What a run of acalx.evaluate leaves in its directory."""

from __future__ import annotations

from acalx.planning.evaluation import Evaluation
from acalx.quantities.magnitude import double_of
from acalx.recording.parts import described, recorded_metrics
from acalx.recording.run_directory import RunDirectory

__all__ = ["record", "record_result", "singular_message"]


def singular_message(evaluation: Evaluation) -> str:
    """Why a program can't estimate all the parameters."""
    return (
        f"{evaluation.program.name}: its {evaluation.program.n} positions can't estimate all the parameters; "
        f"they can't see: {'; '.join(evaluation.inestimable)}"
    )


def record(evaluation: Evaluation, directory: RunDirectory) -> None:
    """The program, and what every result of this run says."""
    directory.write_program(evaluation.stand, evaluation.settings)
    directory.remember(
        n=evaluation.program.n,
        model=described(evaluation.model),
        stand=described(evaluation.stand),
        criterion=described(evaluation.criterion),
        outside=evaluation.outside,
        inestimable=evaluation.inestimable,
    )


def record_result(evaluation: Evaluation, directory: RunDirectory, total: float, **seconds: float) -> None:
    """result.json with the figures of merit and the certificate, and how long its parts took."""
    times = {"seconds": total, "seconds_by_part": seconds}
    if evaluation.inestimable:
        directory.write_result("singular", singular_message(evaluation), evaluations=1, **times)
        return
    certificate = evaluation.certificate
    loss = evaluation.loss
    directory.write_result(
        "ok",
        evaluation.program.title,
        metrics=recorded_metrics(evaluation.metrics),
        loss=loss,
        value=double_of(loss),
        certificate=None if certificate is None else certificate.entries(),
        evaluations=1,
        **times,
    )
