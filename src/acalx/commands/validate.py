"""How right a calibration is on positions that it has not seen: ``python -m acalx.validate data=measurements.csv``."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from typing import Any

from omegaconf import DictConfig, OmegaConf

from acalx.commands.composition import build, build_model
from acalx.commands.launch import Entry, launch
from acalx.commands.options import channels_of, names_of, where_of
from acalx.commands.singular import answers_singular
from acalx.criteria import Criterion
from acalx.errors import ArgumentError
from acalx.estimation import Estimator, Readings, Unit, read_groups
from acalx.estimation.columns import needs_of
from acalx.models import Model
from acalx.recording import RunDirectory
from acalx.recording.parts import described
from acalx.recording.validation import record, record_result
from acalx.reporting.validation import draw, show
from acalx.stands import Stand
from acalx.validation import validate

__all__ = ["ENTRY", "main"]


@dataclass
class ValidateConfig:
    """Root of the configuration; the groups are built from what they name."""

    data: Any = "???"
    test: Any = None
    by: Any = None
    columns: Any = None
    where: Any = None
    model: Any = None
    stand: Any = None
    criterion: Any = None
    estimator: Any = None
    unit: Any = None
    splits: Any = 200
    share: Any = 0.6667
    folds: Any = 5
    programs: Any = None
    turns: Any = 200
    seed: Any = 0
    figures: bool = True
    traceback: bool = False


@answers_singular
def run(config: DictConfig, directory: RunDirectory) -> int:
    """Read, hold positions out, record, show."""
    started = time.perf_counter()
    if OmegaConf.is_missing(config, "data"):
        raise ArgumentError("which measurements? Give data=FILE.csv with columns ax, ay, az, a static position a row")
    options = {key: config[key] for key in ("splits", "share", "folds", "turns", "seed")}
    directory.remember(data=str(config.data), inestimable=[], **options)
    kinds = {"estimator": Estimator, "criterion": Criterion, "stand": Stand}
    parts = {group: build(config, group, kind) for group, kind in kinds.items()}
    model = build_model(config)
    unit = build(config, "unit", Unit).named_for(model.channels)
    told = {"model": model, "unit": unit, **parts}
    directory.remember(**{group: described(part) for group, part in told.items()})
    compared, stand = parts["estimator"].model_for(model), parts["stand"]
    validated = validate(
        _read(config, str(config.data), compared, stand),
        model,
        unit=unit,
        test=None if config.test is None else _read(config, str(config.test), compared, stand),
        programs=None if config.programs is None else names_of(config, "programs"),
        **parts,
        **options,
    )
    directory.remember(n=max(sensor.n for sensor in validated.sensors))
    record(validated, str(config.data), config.test, directory)
    if config.figures:
        draw(validated, directory.path)
    record_result(validated, directory, time.perf_counter() - started)
    show(validated)
    print(f"written to {directory.path}")
    return 0


def _read(config: DictConfig, path: str, model: Model, stand: Stand) -> dict[str, Readings]:
    """The sensors of a file by name; a single one is called 1."""
    columns, by = channels_of(config, model), names_of(config, "by")
    groups = read_groups(path, by, columns, where_of(config), stand, needs_of(model))
    names = [" ".join(key) or "1" for key in groups]
    if len(set(names)) < len(names):  # as of "a b" and "c" beside "a" and "b c"
        names = [str(key) for key in groups]
    return dict(zip(names, groups.values(), strict=True))


ENTRY = Entry("validate", "validate", ValidateConfig, run)


def main() -> int:
    """Validate a calibration as the command line says; returns the exit status."""
    return launch(ENTRY)


if __name__ == "__main__":
    sys.exit(main())
