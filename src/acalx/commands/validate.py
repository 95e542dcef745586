"""How right a calibration is on positions that it has not seen: ``python -m acalx.validate data=measurements.csv``."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from omegaconf import DictConfig, OmegaConf

from acalx.commands.composition import build
from acalx.commands.launch import FAILED, Entry, launch
from acalx.commands.options import names_of, where_of
from acalx.criteria import Criterion
from acalx.errors import ArgumentError, DataError
from acalx.estimation import Estimator, Readings, SingularError, Unit, calibrate, read_groups
from acalx.models import ScalarAccel
from acalx.numerics.arrays import Array
from acalx.programs import find_program, published_for
from acalx.recording import RunDirectory
from acalx.reporting.tables import align
from acalx.stands import Stand
from acalx.validation.comparison import Compared, compare_programs
from acalx.validation.splits import (
    Validation,
    held_out,
    random_splits,
    take_folds,
    validate_folds,
    validate_splits,
)

__all__ = ["ENTRY", "main"]

_MOST_SHOWN = 20


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


@dataclass(frozen=True)
class _Parts:
    """What the configuration describes."""

    model: ScalarAccel
    estimator: Estimator
    unit: Unit
    criterion: Criterion
    programs: Mapping[str, Array]


@dataclass(frozen=True)
class _Sensor:
    """What came out for one sensor."""

    name: str
    n: int
    figures: dict[str, float]
    left_out: Validation
    compared: Sequence[Compared]


def validate(config: DictConfig, directory: RunDirectory) -> int:
    """Hold positions out in every way there are enough for; compare programs; record, show."""
    started = time.perf_counter()
    if OmegaConf.is_missing(config, "data"):
        raise ArgumentError("which measurements? Give data=FILE.csv with columns ax, ay, az, a static position a row")
    directory.remember(data=str(config.data), inestimable=[], seed=config.seed)
    seed, turns = config.seed, config.turns
    if not isinstance(seed, int) or isinstance(seed, bool) or seed < 0:
        raise ArgumentError(f"seed={seed}: the seed must be a whole number, 0 or more")
    if not isinstance(turns, int) or isinstance(turns, bool) or turns < 1:
        raise ArgumentError(f"turns={turns}: give a whole number; 1 leaves programs as they are")
    stand = build(config, "stand", Stand)
    parts = _Parts(
        build(config, "model", ScalarAccel),
        build(config, "estimator", Estimator),
        build(config, "unit", Unit),
        build(config, "criterion", Criterion),
        _programs(config, stand),
    )
    parts.criterion.check(parts.model.parameters)
    columns, by, where = names_of(config, "columns", 3), names_of(config, "by"), where_of(config)
    groups = read_groups(str(config.data), by, columns, where, stand)
    tests = None if config.test is None else read_groups(str(config.test), by, columns, where, stand)
    rng = np.random.default_rng(seed)
    sensors = []
    try:
        for key, readings in groups.items():
            sensors.append(_sensor(" ".join(key) or "1", readings, _partner(tests, key), parts, config, rng))
    except SingularError as error:
        seconds = time.perf_counter() - started
        directory.write_result("singular", str(error), inestimable=error.inestimable, seconds=seconds)
        print(f"acalx: {error}", file=sys.stderr)
        return FAILED
    directory.remember(n=max(sensor.n for sensor in sensors))
    programs = _medians(sensors)
    _record(sensors, programs, config, directory)
    summary = {key: float(np.median([s.figures[key] for s in sensors])) for key in sensors[0].figures}
    message = f"{len(sensors)} sensor{'s' * (len(sensors) > 1)} validated"
    directory.write_result("ok", message, metrics=summary, seconds=time.perf_counter() - started)
    _show(sensors, summary, programs, directory)
    return 0


def _programs(config: DictConfig, stand: Stand) -> dict[str, Array]:
    """The vertical in sensor axes of the programs to compare."""
    names = list(published_for(stand)) if config.programs is None else names_of(config, "programs")
    directions = {}
    for name in names:
        program = find_program(name)
        force = stand.stimulus(program.settings_for(stand)).specific_force
        if force is not None:
            directions[program.name] = force
    return directions


def _partner(tests: Mapping[tuple[str, ...], Readings] | None, key: tuple[str, ...]) -> Readings | None:
    if tests is None:
        return None
    if key not in tests:
        raise DataError(f"the test file has no sensor {' '.join(key)}; the two files must have the same sensors")
    return tests[key]


def _sensor(
    name: str,
    readings: Readings,
    test: Readings | None,
    parts: _Parts,
    config: DictConfig,
    rng: np.random.Generator,
) -> _Sensor:
    model, estimator, unit = parts.model, parts.estimator, parts.unit
    calibration = calibrate(readings, model, estimator, unit)
    n, least = readings.n, model.smallest_n
    figures: dict[str, float] = {}
    if test is not None:
        tested = held_out(readings, test, model, estimator, unit)
        figures |= {"test_r_squared": float(tested.r_squared[0]), "test_rms_g": float(tested.rms[0])}
        return _Sensor(name, n, figures, Validation(tested.before[0], tested.after[0]), [])
    if n <= least:
        raise DataError(
            f"{readings.name}: {n} positions for {least} parameters leave none to test on; give test=FILE.csv"
        )
    train, held = random_splits(n, config.share, config.splits, rng)
    if train.shape[1] >= least:
        splits = validate_splits(readings, train, held, model, estimator, unit)
        figures |= {
            "splits_r_squared": float(np.median(splits.r_squared)),
            "splits_rms_g": float(np.median(splits.rms)),
            "splits_failed": float(splits.failed),
        }
    folds = take_folds(n, config.folds, rng)
    if n - max(len(fold) for fold in folds) >= least:
        pooled = validate_folds(readings, folds, model, estimator, unit)
        figures |= {"folds_r_squared": float(pooled.r_squared), "folds_rms_g": float(pooled.rms)}
    left_out = validate_folds(readings, take_folds(n, n, rng), model, estimator, unit)
    figures |= {"leave_one_out_r_squared": float(left_out.r_squared), "leave_one_out_rms_g": float(left_out.rms)}
    compared = compare_programs(calibration, parts.programs, parts.criterion, estimator, rng, turns=config.turns)
    return _Sensor(name, n, figures, left_out, compared)


def _medians(sensors: Sequence[_Sensor]) -> list[Compared]:
    """Each row of the comparison, its figures the medians over the sensors that have it."""
    rows: dict[str, list[Compared]] = {}
    for sensor in sensors:
        for row in sensor.compared:
            rows.setdefault(row.name, []).append(row)
    return [
        Compared(
            name,
            found[0].n,
            *(float(np.median([getattr(row, key) for row in found])) for key in _COMPARED),
        )
        for name, found in sorted(rows.items(), key=lambda item: item[1][0].n)
    ]


_COMPARED = ("angle_deg", "efficiency", "r_squared", "rms_g")


def _record(
    sensors: Sequence[_Sensor], programs: Sequence[Compared], config: DictConfig, directory: RunDirectory
) -> None:
    keys = list(sensors[0].figures)
    directory.write_json(
        "validation.json",
        {
            "data": str(config.data),
            "test": config.test,
            "sensors": [{"sensor": s.name, "positions": s.n, **s.figures} for s in sensors],
            "programs": [asdict(row) for row in programs],
        },
    )
    directory.write_table(
        "validation.csv",
        ["sensor", "positions", *keys],
        ([s.name, s.n, *(repr(s.figures.get(key, float("nan"))) for key in keys)] for s in sensors),
    )
    directory.write_table(
        "programs.csv",
        ["sensor", "program", "positions", *_COMPARED],
        ([s.name, r.name, r.n, *(repr(getattr(r, k)) for k in _COMPARED)] for s in sensors for r in s.compared),
    )
    if config.figures:
        from acalx.reporting.validation import draw_validation

        before = np.concatenate([sensor.left_out.before for sensor in sensors])
        after = np.concatenate([sensor.left_out.after for sensor in sensors])
        draw_validation(before, after, [(r.name, r.efficiency, r.rms_g) for r in programs], directory.path)


def _show(
    sensors: Sequence[_Sensor], summary: Mapping[str, float], programs: Sequence[Compared], directory: RunDirectory
) -> None:
    ways = [key.removesuffix("_r_squared") for key in summary if key.endswith("_r_squared")]
    rows = [["sensor", "positions"]]
    for way in ways:
        rows[0] += [f"{way.replace('_', ' ')} R^2", "rms mg"]
    listed = [(s.name, str(s.n), s.figures) for s in sensors[:_MOST_SHOWN]]
    if len(sensors) > 1:
        listed.append((f"median of {len(sensors)}", "", dict(summary)))
    for name, n, figures in listed:
        row = [name, n]
        for way in ways:
            row += [f"{figures[f'{way}_r_squared']:.5f}", f"{1e3 * figures[f'{way}_rms_g']:.4f}"]
        rows.append(row)
    print(f"{align(rows)}\n")
    if len(sensors) > _MOST_SHOWN:
        print(f"... {len(sensors) - _MOST_SHOWN} more in validation.csv\n")
    if programs:
        table = [["calibrated on the nearest to", "positions", "angle deg", "efficiency", "R^2", "rms mg"]]
        for row_ in programs:
            angle = "-" if np.isnan(row_.angle_deg) else f"{row_.angle_deg:.1f}"
            r_squared = f"{row_.r_squared:.5f}" if np.isfinite(row_.r_squared) else "can't"
            rms = f"{1e3 * row_.rms_g:.4f}" if np.isfinite(row_.rms_g) else "-"
            table.append([row_.name, str(row_.n), angle, f"{row_.efficiency:.3f}", r_squared, rms])
        print(f"{align(table)}\n")
    print(f"written to {directory.path}")


ENTRY = Entry("validate", "validate", ValidateConfig, validate)


def main() -> int:
    """Validate a calibration as the command line says; returns the exit status."""
    return launch(ENTRY)


if __name__ == "__main__":
    sys.exit(main())
