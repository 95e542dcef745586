"""Simulate calibrations with a program: ``python -m acalx.simulate program=NAME-or-CSV trials=20000``."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from typing import Any

from omegaconf import DictConfig, ListConfig, OmegaConf

from acalx.commands.composition import build, build_model
from acalx.commands.launch import Entry, launch
from acalx.commands.singular import answers_singular
from acalx.errors import ArgumentError
from acalx.estimation import Estimator
from acalx.programs import published
from acalx.recording import RunDirectory
from acalx.recording.parts import described
from acalx.recording.simulation import record, record_result
from acalx.reporting.simulation import draw_simulation, show
from acalx.simulation import ErrorSources, default_estimator, find_programs, simulate
from acalx.stands import Stand

__all__ = ["ENTRY", "main"]


@dataclass
class SimulateConfig:
    """Root of the configuration; the groups are built from what they name."""

    program: Any = "???"
    trials: Any = 20000
    model: Any = None
    stand: Any = None
    errors: Any = None
    estimator: Any = None
    order: Any = "given"
    dwell_s: Any = 60
    confidence: Any = 0.95
    seed: Any = 0
    figures: bool = True
    traceback: bool = False


@answers_singular
def run(config: DictConfig, directory: RunDirectory) -> int:
    """Simulate each program with the same sensors, record, show; gives the exit status."""
    started = time.perf_counter()
    names = _names(config)
    directory.remember(inestimable=[], seed=config.seed, trials=config.trials)
    stand, model = build(config, "stand", Stand), build_model(config)
    programs = find_programs(names, stand)
    directory.remember(program=[program.name for program in programs], n=max(program.n for program in programs))
    errors = build(config, "errors", ErrorSources)
    given = config.estimator is not None
    estimator = build(config, "estimator", Estimator) if given else default_estimator(model)
    parts = {"model": model, "stand": stand, "errors": errors, "estimator": estimator}
    directory.remember(order=config.order, dwell_s=config.dwell_s, confidence=config.confidence)
    directory.remember(**{name: described(part) for name, part in parts.items()})
    simulated = simulate(
        programs,
        **parts,
        trials=config.trials,
        order=config.order,
        dwell_s=config.dwell_s,
        confidence=config.confidence,
        seed=config.seed,
    )
    as_given: Any = OmegaConf.to_container(config.errors, resolve=True)
    record(simulated, as_given, directory)
    if config.figures:
        draw_simulation(list(simulated.outcomes.values()), directory.path)
    record_result(simulated, directory, time.perf_counter() - started)
    show(simulated)
    print(f"written to {directory.path}")
    return 0


def _names(config: DictConfig) -> list[str]:
    """Names of the programs, one or several."""
    if OmegaConf.is_missing(config, "program"):
        raise ArgumentError(f"which program? Give program=FILE.csv or program=NAME; names: {', '.join(published())}")
    given = list(config.program) if isinstance(config.program, ListConfig) else [config.program]
    return [str(name) for name in given]


ENTRY = Entry("simulate", "simulate", SimulateConfig, run)


def main() -> int:
    """Simulate calibrations as the command line says; returns the exit status."""
    return launch(ENTRY)


if __name__ == "__main__":
    sys.exit(main())
