"""What a configuration asks to be designed, as plain objects."""

from __future__ import annotations

from typing import Any

from omegaconf import DictConfig, OmegaConf

from acalx.commands.composition import build, build_model, build_objectives
from acalx.commands.options import seed_of
from acalx.criteria import Criterion, Objectives, Target
from acalx.errors import ArgumentError
from acalx.optimizers import Optimizer
from acalx.planning.defaults import usual_n
from acalx.planning.design import Request
from acalx.problem import Problem
from acalx.programs import find_program
from acalx.schemes import Scheme
from acalx.stands import Stand

__all__ = ["certificate_of", "problem_of", "request_of"]

_AUTO = "auto"


def problem_of(config: DictConfig) -> Problem:
    """The problem; where the number of positions is to be found, with the fewest that there can be."""
    stand, model = build(config, "stand", Stand), build_model(config)
    several = config.objectives is not None
    criterion = build_objectives(config) if several else build(config, "criterion", Criterion)
    _check_target(config, criterion)
    fixed = None if config.fixed is None else find_program(str(config.fixed), stand).settings_for(stand)
    n = usual_n(model) if config.n is None else config.n
    if isinstance(n, float) and n.is_integer():
        n = int(n)  # 1e9 is a float in YAML
    if n == _AUTO:
        n = model.smallest_n + (0 if fixed is None else len(fixed))
    return Problem(stand, model, criterion, n, fixed, config.replicates, config.dwell_s)


def request_of(config: DictConfig) -> Request:
    """How it is to be solved, and what is wanted beside the program."""
    return Request(
        optimizer=build(config, "optimizer", Optimizer),
        scheme=build(config, "scheme", Scheme),
        target=_target_of(config),
        n_most=config.n_most,
        orient=None if config.orient is None else build(config, "orient", Criterion),
        order=config.order,
        dwell_s=config.dwell_s,
        seed=seed_of(config),
    )


def certificate_of(config: DictConfig) -> bool:
    """Whether to bound what any program could reach."""
    wanted = config.certificate
    if wanted != _AUTO and not isinstance(wanted, bool):
        raise ArgumentError.of("certificate", wanted, "must be auto, true or false")
    if wanted is True and config.objectives is not None:
        name = next(iter(config.objectives))
        raise ArgumentError(
            "certificate=true: several objectives have no bound together; ask it of one criterion alone, by "
            f"acalx.run criterion={name}, or by acalx.evaluate program=DIRECTORY/program.csv criterion={name}"
        )
    return bool(wanted) and config.objectives is None


def _target_of(config: DictConfig) -> Target | None:
    """What n=auto is to reach; None where n is given."""
    if config.n != _AUTO:
        return None
    whole: Any = OmegaConf.to_container(config, resolve=True)
    return Target(whole["target"])


def _check_target(config: DictConfig, criterion: Criterion | Objectives) -> None:
    """Raise ArgumentError for a target that nothing asks for, or that is missing."""
    if config.n != _AUTO:
        if config.target is not None and not _has_target(criterion):
            given = "" if config.n is None else f" with n={config.n}"
            raise ArgumentError(f"target={config.target}{given}: a target is for n=auto or criterion=target")
        return
    if config.target is None:
        raise ArgumentError(
            "n=auto: give the largest standard error of each group that matters, as in 'target={bias: 0.5}'"
        )


def _has_target(criterion: Criterion | Objectives) -> bool:
    each = criterion.criteria if isinstance(criterion, Objectives) else (criterion,)
    return any(isinstance(ceiling, Target) for one in each for _, ceiling in one.terms().ceilings)
