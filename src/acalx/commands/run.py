"""Design a calibration program: ``python -m acalx.run model=scalar_accel criterion=d_fair optimizer=de n=9``."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from omegaconf import DictConfig, OmegaConf

from acalx.bounds import certify
from acalx.commands.composition import build_objectives, compose_default_optimizer, compose_objectives, compose_orient
from acalx.commands.launch import INTERRUPTED, Entry, build, launch
from acalx.commands.options import seed_of, target_of
from acalx.criteria import Criterion, Target
from acalx.errors import ArgumentError
from acalx.models import Model
from acalx.optimizers import Optimizer
from acalx.planning.itinerary import check_order, itinerary
from acalx.planning.metrics import best_published
from acalx.planning.orientation import check_orientation, orient
from acalx.planning.smallest import smallest_program
from acalx.problem import Problem
from acalx.programs import find_program
from acalx.recording import RunDirectory
from acalx.recording.design import record, record_parts, record_result
from acalx.reporting.design import draw, show
from acalx.reporting.progress import Progress
from acalx.schemes import Designed, Scheme
from acalx.search.result import Found, Front, Result
from acalx.stands import Stand

__all__ = ["ENTRY", "main"]


@dataclass
class RunConfig:
    """Root of the configuration; the groups are built from what they name."""

    model: Any = None
    stand: Any = None
    criterion: Any = None
    objectives: Any = None
    optimizer: Any = None
    scheme: Any = None
    n: Any = 9
    target: Any = None
    n_most: Any = 500
    fixed: Any = None
    replicates: Any = True
    orient: Any = None
    order: Any = "given"
    dwell_s: Any = 60
    seed: Any = 0
    certificate: Any = "auto"
    figures: bool = True
    traceback: bool = False


def design(config: DictConfig, directory: RunDirectory) -> int:
    """Search, record, show."""
    directory.remember(n=config.n, seed=config.seed)
    config = _composed(config, directory)
    directory.write_text("resolved.yaml", _resolved(config))
    bounded, seed = _wants_certificate(config), seed_of(config)
    check_order(config.order, config.dwell_s)
    problem, target = _problem(config)
    optimizer, scheme = build(config, "optimizer", Optimizer), build(config, "scheme", Scheme)
    second = None if config.orient is None else build(config, "orient", Criterion)
    if second is not None:
        check_orientation(problem, second, np.random.default_rng(seed))
    designed = _search(config, problem, target, optimizer, scheme, directory)
    result = designed.result
    if len(result.program) != problem.n:  # where the optimizer or the scheme chooses how many
        problem = replace(problem, n=len(result.program))
    if second is not None and result.status != "interrupted":
        result = _turned(problem, result, second, np.random.default_rng(seed))
    visit = itinerary(problem.stand, result.program, config.order, np.random.default_rng(seed), problem.held)
    result = result.with_program(visit.settings)
    directory.remember(order=config.order, **visit.entries(config.dwell_s))
    record_parts(designed.parts, directory)
    record(problem, result, directory)  # before anything else can go wrong
    certificate = None
    if bounded and result.status != "interrupted":
        try:
            certificate = certify(problem, result.program)
        except KeyboardInterrupt:  # the program is there, and is not to be lost
            result = result.ended("interrupted", f"{result.message}; interrupted while bounding it")
        record_result(problem, result, certificate, directory)
    reference = None if isinstance(result, Front) else best_published(problem)
    show(problem, result, reference, certificate)
    print(f"in the order of visit ({config.order}) {visit.summary(config.dwell_s)}\nwritten to {directory.path}")
    if config.figures:
        draw(problem, replace(designed, result=result), reference, directory.path)
    return INTERRUPTED if result.status == "interrupted" else 0


def _composed(config: DictConfig, directory: RunDirectory) -> DictConfig:
    """The configuration with all that names stand for, and the optimizer that suits where none is named."""
    if config.objectives is not None:
        config = compose_objectives(config, directory.overrides)
        config = compose_default_optimizer(config, directory.overrides, "scalarized")
    elif build(config, "stand", Stand).stepped:
        config = compose_default_optimizer(config, directory.overrides, "exchange")
    return compose_orient(config)


def _problem(config: DictConfig) -> tuple[Problem, Target | None]:
    """The problem, and the target where the number of positions is to be found."""
    stand, model = build(config, "stand", Stand), build(config, "model", Model)
    several = config.objectives is not None
    criterion = build_objectives(config) if several else build(config, "criterion", Criterion)
    target = target_of(config, criterion)
    fixed = None if config.fixed is None else find_program(str(config.fixed)).settings_for(stand)
    n = config.n
    if isinstance(n, float) and n.is_integer():
        n = int(n)  # 1e9 is a float in YAML
    if target is not None:  # to begin with
        n = model.smallest_n + (0 if fixed is None else len(fixed))
    return Problem(stand, model, criterion, n, fixed, config.replicates), target


def _search(
    config: DictConfig,
    problem: Problem,
    target: Target | None,
    optimizer: Optimizer[Any],
    scheme: Scheme,
    directory: RunDirectory,
) -> Designed:
    """The program for a number of positions, or for the smallest that meets a target."""
    progress = Progress()
    try:
        if target is None:
            return scheme.solve(problem, optimizer, np.random.default_rng(config.seed), progress)

        def solve(at: Problem) -> Designed:
            return scheme.solve(at, optimizer.exact(), np.random.default_rng(config.seed), progress)

        smallest = smallest_program(problem, target, scheme, solve, config.n_most)
    finally:
        progress.close()
    directory.remember(n=smallest.n, **smallest.recorded)
    print(f"{smallest}\n")
    return smallest.designed


def _turned(problem: Problem, result: Found, second: Criterion, rng: np.random.Generator) -> Found:
    """The result with its best program rotated, and that said."""
    assert isinstance(result, Result)  # check_orientation has refused several objectives
    turned = orient(problem, result.solutions, second, rng)
    message = (
        f"{result.message}; turned at no cost, by which the second criterion fell "
        f"from {np.exp(turned.before):.6g} to {np.exp(turned.after):.6g}"
    )
    return replace(result, message=message, solutions=(turned.solution, *result.solutions))


def _wants_certificate(config: DictConfig) -> bool:
    """Whether to bound what any program could reach."""
    wanted = config.certificate
    if wanted != "auto" and not isinstance(wanted, bool):
        raise ArgumentError(f"certificate={wanted}: must be auto, true or false")
    if wanted is True and config.objectives is not None:
        name = next(iter(config.objectives))
        raise ArgumentError(
            "certificate=true: several objectives have no bound together; ask it of one criterion alone, by "
            f"acalx.run criterion={name}, or by acalx.evaluate program=DIRECTORY/program.csv criterion={name}"
        )
    return bool(wanted) and config.objectives is None


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
