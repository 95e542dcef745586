"""Design a calibration program: ``python -m acalx.run model=scalar_accel criterion=d_fair optimizer=de n=9``."""

from __future__ import annotations

import math
import sys
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from omegaconf import DictConfig, OmegaConf

from acalx.certificate import Certificate, certify
from acalx.criteria import Criterion
from acalx.errors import ArgumentError
from acalx.launch import INTERRUPTED, Entry, build, launch
from acalx.metrics import best_published, figures_of_merit
from acalx.models import Model
from acalx.optimizers import Design, Optimizer, Result
from acalx.problem import Problem
from acalx.programs import Program
from acalx.recording import RunDirectory
from acalx.reporting.progress import Progress
from acalx.reporting.tables import align, figures_table, program_table, weights_table
from acalx.stands import Stand

__all__ = ["ENTRY", "main"]


@dataclass
class RunConfig:
    """Root of the configuration; the groups are built from what they name."""

    model: Any = None
    stand: Any = None
    criterion: Any = None
    optimizer: Any = None
    n: Any = 9
    seed: Any = 0
    certificate: bool = True
    figures: bool = True
    traceback: bool = False


def design(config: DictConfig, directory: RunDirectory) -> int:
    """Search, record, show."""
    directory.remember(n=config.n, seed=config.seed)
    directory.write_text("resolved.yaml", _resolved(config))
    seed = config.seed
    if not isinstance(seed, int) or isinstance(seed, bool) or seed < 0:
        raise ArgumentError(f"seed={seed}: the seed must be a whole number, 0 or more")
    stand, model = build(config, "stand", Stand), build(config, "model", Model)
    criterion, optimizer = build(config, "criterion", Criterion), build(config, "optimizer", Optimizer)
    n = config.n
    if isinstance(n, float) and n.is_integer():
        n = int(n)  # 1e9 is a float in YAML
    problem = Problem(stand, model, criterion, n)
    progress = Progress()
    try:
        result: Result = optimizer.solve(problem, np.random.default_rng(seed), progress)
    finally:
        progress.close()
    _record(problem, result, directory)  # before anything else can go wrong
    certificate = None
    if config.certificate and result.status != "interrupted":
        try:
            certificate = certify(problem, result.best.loss)
        except KeyboardInterrupt:  # the program is there, and is not to be lost
            result = replace(result, status="interrupted", message=f"{result.message}; interrupted while bounding it")
        _record_result(problem, result, certificate, directory)
    reference = best_published(problem)
    _show(problem, result, reference, certificate, directory)
    if config.figures:
        _draw(problem, result, reference, directory)
    return INTERRUPTED if result.status == "interrupted" else 0


def _record(problem: Problem, result: Result, directory: RunDirectory) -> None:
    directory.write_program(problem.stand, result.best.settings)
    directory.write_alternatives(problem.stand, result.solutions)
    directory.write_history(result.history)
    if result.design is not None:
        directory.write_weights(problem.stand, result.design)
    _record_result(problem, result, None, directory)


def _record_result(problem: Problem, result: Result, certificate: Certificate | None, directory: RunDirectory) -> None:
    directory.write_result(
        result.status,
        result.message,
        metrics=figures_of_merit(problem.information(result.best.settings)),
        loss=result.best.loss,
        evaluations=result.evaluations,
        seconds=result.seconds,
        gain=result.gain,
        alternatives=len(result.solutions) - 1,
        certificate=None if certificate is None else asdict(certificate),
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


def _draw(problem: Problem, result: Result, reference: Program | None, directory: RunDirectory) -> None:
    from acalx.reporting.figures import draw_convergence, draw_entries, draw_positions

    stimulus = problem.stand.stimulus(result.best.settings)
    if stimulus.specific_force is not None:
        draw_positions(stimulus.specific_force, directory.path, f"{problem.n} positions of the vertical")
    draw_convergence(result.history, directory.path)
    entries = {"this program": problem.model.regressors(stimulus)}
    if reference is not None:
        feels = problem.stand.stimulus(reference.settings_for(problem.stand))
        entries[reference.name] = problem.model.regressors(feels)
    draw_entries(entries, directory.path)


def _show(
    problem: Problem,
    result: Result,
    reference: Program | None,
    certificate: Certificate | None,
    directory: RunDirectory,
) -> None:
    settings = result.best.settings
    columns = {"this program": figures_of_merit(problem.information(settings))}
    if reference is not None:
        other = reference.settings_for(problem.stand)
        columns[reference.name] = figures_of_merit(problem.information(other))
    print(program_table(problem.stand, settings))
    print()
    if result.design is not None:
        print(weights_table(problem.stand, *result.design.merged()))
        print()
    print(align(figures_table(columns)))
    print()
    print(f"{result.message}; {result.evaluations} programs in {result.seconds:.2f} s")
    if certificate is not None:
        print(f"{certificate}")
    if result.gain is not None:
        print(f"the polish lowered the loss by {result.gain:.3g}, to {result.best.loss:.6f}")
    if len(result.solutions) > 1:
        print(f"{len(result.solutions) - 1} other programs are as good; see alternatives.csv")
    print(f"written to {directory.path}")


def _resolved(config: DictConfig) -> str:
    """The configuration as it was, which runs again by itself."""
    chosen = {"launcher": "acalx", "sweeper": "acalx", "job_logging": "none", "hydra_logging": "none"}
    defaults = ["run_schema", "settings", *({f"override hydra/{group}": option} for group, option in chosen.items())]
    head = {"defaults": [*defaults, "_self_"]}
    body = OmegaConf.to_container(config, resolve=True)
    return (
        "# This run again: python -m acalx.run --config-dir=THIS_DIRECTORY --config-name=resolved\n"
        + OmegaConf.to_yaml(OmegaConf.create(head))
        + OmegaConf.to_yaml(OmegaConf.create(body))
    )


ENTRY = Entry("run", "config", RunConfig, design)


def main() -> int:
    """Entry point."""
    return launch(ENTRY)


if __name__ == "__main__":
    sys.exit(main())
