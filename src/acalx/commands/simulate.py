"""Simulate calibrations with a program: ``python -m acalx.simulate program=NAME-or-CSV trials=20000``."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from omegaconf import DictConfig, ListConfig, OmegaConf

from acalx.commands.composition import build
from acalx.commands.launch import FAILED, Entry, launch
from acalx.commands.options import seed_of
from acalx.errors import ArgumentError
from acalx.estimation import Estimator, SingularError
from acalx.models import Model
from acalx.planning.itinerary import check_order, itinerary
from acalx.programs import Program, find_program, published
from acalx.recording import RunDirectory
from acalx.reporting.tables import align, units_line
from acalx.simulation import Campaign, ErrorSources, Outcome, default_estimator, simulate
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


def run(config: DictConfig, directory: RunDirectory) -> int:
    """Simulate each program with the same sensors, record, show."""
    started = time.perf_counter()
    if OmegaConf.is_missing(config, "program"):
        raise ArgumentError(f"which program? Give program=FILE.csv or program=NAME; names: {', '.join(published())}")
    directory.remember(inestimable=[], seed=config.seed, trials=config.trials)
    seed = seed_of(config)
    check_order(config.order, config.dwell_s)
    programs = _programs(config)
    directory.remember(program=[program.name for program in programs], n=max(program.n for program in programs))
    stand, model = build(config, "stand", Stand), build(config, "model", Model)
    sources = build(config, "errors", ErrorSources)
    given = config.estimator is not None
    estimator = build(config, "estimator", Estimator) if given else default_estimator(model)
    outcomes, visits = [], {}
    try:
        for program in programs:
            visit = itinerary(stand, program.settings_for(stand), config.order, np.random.default_rng(seed))
            visits[program.name] = visit.entries(config.dwell_s)
            campaign = Campaign(model, stand, visit.settings, sources, seed, config.order == "random")
            outcomes.append(simulate(campaign, estimator, config.trials, program.name, config.confidence))
    except SingularError as error:
        seconds = time.perf_counter() - started
        directory.write_result("singular", str(error), inestimable=error.inestimable, seconds=seconds)
        print(f"acalx: {error}", file=sys.stderr)
        return FAILED
    _record(outcomes, config, directory)
    directory.write_result(
        "ok",
        "; ".join(_verdict(outcome) for outcome in outcomes),
        metrics={outcome.name: outcome.groups for outcome in outcomes},
        agrees={outcome.name: outcome.agrees for outcome in outcomes},
        visits=visits,
        evaluations=len(outcomes) * config.trials,
        seconds=time.perf_counter() - started,
    )
    _show(outcomes, model, directory)
    return 0


def _programs(config: DictConfig) -> list[Program]:
    """Those that the configuration names, each once."""
    given = list(config.program) if isinstance(config.program, ListConfig) else [config.program]
    names = [str(name) for name in given]
    if not names:
        raise ArgumentError("program=[]: give one program or more, as in program=[icosahedron_12,mine.csv]")
    for k, name in enumerate(names):
        if name in names[:k]:
            raise ArgumentError(f"program: {name} is there twice; once is right")
    return [find_program(name) for name in names]


def _record(outcomes: Sequence[Outcome], config: DictConfig, directory: RunDirectory) -> None:
    entries = [outcome.entries() for outcome in outcomes]
    errors = OmegaConf.to_container(config.errors, resolve=True)
    directory.write_json("simulation.json", {"errors": errors, "order": config.order, "programs": entries})
    head = ["bias", "bias_low", "bias_high", "standard_deviation", "standard_deviation_low", "standard_deviation_high"]
    head += ["predicted", "as_predicted", "relative_error", "coverage"]
    rows = []
    for entry in entries:
        for name, p in entry["parameters"].items():
            numbers = [p["bias"], *p["bias_limits"], p["standard_deviation"], *p["standard_deviation_limits"]]
            numbers += [p["predicted"], int(p["as_predicted"]), p["relative_error"], p["coverage"]]
            rows.append([entry["program"], name, p["unit"], *map(repr, numbers)])
    directory.write_table("simulation.csv", ["program", "parameter", "unit", *head], rows)
    if config.figures:
        from acalx.reporting.simulation import draw_simulation

        draw_simulation(outcomes, directory.path)


def _show(outcomes: Sequence[Outcome], model: Model, directory: RunDirectory) -> None:
    for outcome in outcomes:
        print(f"{outcome.name}: {outcome.n} positions, {outcome.trials} trials\n")
        rows = [["group", "s", "limits", "theta", "agree", "inequality", "predicted", "largest bias"]]
        for group, entry in outcome.groups.items():
            low, high = entry["s_limits"]
            rows.append(
                [
                    group,
                    f"{entry['s']:.4g}",
                    f"{low:.4g} to {high:.4g}",
                    f"{entry['theta']:.4g}",
                    "yes" if entry["as_predicted"] else "no",
                    _percent(entry.get("inequality")),
                    _percent(entry.get("inequality_predicted")),
                    f"{entry['bias'] / outcome.noise:.2g}",
                ]
            )
        print(f"{align(rows)}\n\n{_parameters(outcome)}\n\n{_verdict(outcome)}\n{_relative(outcome)}\n")
    print(f"s, theta and bias of groups are divided by the noise, {outcomes[0].noise:g}")
    print(units_line(model.parameters))
    print(f"written to {directory.path}")


def _relative(outcome: Outcome) -> str:
    """Error of the worst parameter relative to its own size, and a question where that is too large to be meant."""
    errors = np.nan_to_num(outcome.relative_errors, posinf=0.0)  # of a parameter that is zero there is none
    worst = int(errors.argmax())
    name = outcome.information.parameters[worst].name
    text = f"largest error relative to the parameter: {100 * errors[worst]:.3g} %, {name}"
    if errors[worst] > 1.0:
        text += (
            "; more than the parameter itself: is the noise that of the sensor? It is errors.noise times what the "
            "model says, as in model.gyro_noise_deg_h=0.001 model.accel_noise_g=1.02e-7"
        )
    return text


def _parameters(outcome: Outcome) -> str:
    """The table of the parameters."""
    percent = f"{100 * outcome.confidence:g} %"
    rows = [["parameter", "bias", f"{percent} limits", "deviation", f"{percent} limits", "predicted", "", "covered"]]
    for k, parameter in enumerate(outcome.information.parameters):
        low, high = outcome.bias_limits[k]
        least, most = outcome.deviation_limits[k]
        rows.append(
            [
                parameter.name,
                f"{outcome.bias[k]:+.2e}",
                f"{low:+.2e} to {high:+.2e}",
                f"{outcome.deviations[k]:.4g}",
                f"{least:.4g} to {most:.4g}",
                f"{outcome.predicted[k]:.4g}",
                "" if outcome.as_predicted[k] else "outside",
                f"{100 * outcome.coverage[k]:.1f} %",
            ]
        )
    return align(rows)


def _verdict(outcome: Outcome) -> str:
    """One line on agreement with theory."""
    probabilities = f"{outcome.scatter_probability:.3g} (spread), {outcome.bias_probability:.3g} (bias)"
    failed = f"; {outcome.moments.failed} trials did not settle" if outcome.moments.failed else ""
    word = "agrees with theory" if outcome.agrees else "does not agree with theory"
    return f"{outcome.name} {word}: probability {probabilities}{failed}"


def _percent(share: float | None) -> str:
    return "-" if share is None else f"{100 * share:.2f} %"


ENTRY = Entry("simulate", "simulate", SimulateConfig, run)


def main() -> int:
    """Simulate calibrations as the command line says; returns the exit status."""
    return launch(ENTRY)


if __name__ == "__main__":
    sys.exit(main())
