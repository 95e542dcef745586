"""From the readings of one or several sensors to how right calibrations from them are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.criteria import Criterion, D
from acalx.errors import ArgumentError, DataError, Option
from acalx.estimation import Calibration, Estimator, Iterated, Readings, Unit, calibrate
from acalx.estimation.procedure import prepared
from acalx.estimation.residuals import unit_of_residuals
from acalx.models import Model, ScalarAccel, as_model
from acalx.numerics.arrays import Array
from acalx.options import is_whole, require_part, require_seed
from acalx.programs import Program, find_program, published_for
from acalx.sensors import Sensor
from acalx.stands import Stand, TwoAxis
from acalx.validation.comparison import Compared, compare_programs, median_of
from acalx.validation.splits import (
    Validation,
    held_out,
    random_splits,
    take_folds,
    validate_folds,
    validate_splits,
)

__all__ = ["Validated", "ValidatedSensor", "validate"]

_MODEL, _ESTIMATOR, _CRITERION, _STAND = ScalarAccel(), Iterated(), D(), TwoAxis()


@final
@dataclass(frozen=True, eq=False)
class ValidatedSensor:
    """How right calibrations of one sensor are on positions that they have not seen.

    Parameters
    ----------
    name : str
    n : int
        Number of its positions.
    figures : mapping
        R^2 and root mean square of each way, with its unit, to hold positions out that there were enough
        for: ``splits_r_squared``, ``splits_rms_g``, ``folds_...``, ``leave_one_out_...``, or ``test_...``
        with readings of their own; ``splits_failed`` counts splits that could not show the parameters.
    left_out : Validation
        Residuals of positions left out one at a time, or of the test readings.
    compared : sequence of Compared
        Programs by the measured positions that are nearest to theirs.
    """

    name: str
    n: int
    figures: Mapping[str, float]
    left_out: Validation
    compared: Sequence[Compared]


@final
@dataclass(frozen=True, eq=False)
class Validated:
    """All the sensors that were validated, and what they say together.

    Parameters
    ----------
    sensors : sequence of ValidatedSensor
    unit : str
        Of residuals, as names in files have it: ``g``, or ``relative`` to the model's noise.
    """

    sensors: Sequence[ValidatedSensor]
    unit: str = "g"

    @property
    def medians(self) -> dict[str, float]:
        """Medians of each figure over the sensors that have it: few positions leave none to hold out in some ways."""
        keys = dict.fromkeys(key for sensor in self.sensors for key in sensor.figures)
        each = {key: [sensor.figures[key] for sensor in self.sensors if key in sensor.figures] for key in keys}
        return {key: float(np.median(values)) for key, values in each.items()}

    @property
    def programs(self) -> list[Compared]:
        """Each program that was compared, fewest positions first: the medians over the sensors that have it."""
        rows: dict[str, list[Compared]] = {}
        for sensor in self.sensors:
            for row in sensor.compared:
                rows.setdefault(row.name, []).append(row)
        return [median_of(found) for found in sorted(rows.values(), key=lambda found: found[0].n)]

    def summary(self) -> str:
        """How many sensors were validated."""
        return f"{len(self.sensors)} sensor{'s' * (len(self.sensors) > 1)} validated"


@dataclass(frozen=True, eq=False)
class _Ways:
    """How each sensor is calibrated, and how its positions are held out."""

    model: Model
    estimator: Estimator
    unit: Unit
    criterion: Criterion
    programs: Mapping[str, Array]
    splits: int
    share: float
    folds: int
    turns: int

    def __post_init__(self) -> None:
        kinds = {"estimator": Estimator, "criterion": Criterion}
        for name, kind in kinds.items():
            require_part(name, getattr(self, name), kind)
        self.criterion.check(self.model.parameters)
        if not is_whole(self.turns) or self.turns < 1:
            raise ArgumentError.of("turns", self.turns, "give a whole number; 1 leaves programs as they are")

    @property
    def rms(self) -> str:
        """What root mean squares are called: with the unit that residuals are in."""
        return f"rms_{unit_of_residuals(self.model)}"

    def sensor(
        self, name: str, readings: Readings, tests: Mapping[str, Readings] | None, rng: np.random.Generator
    ) -> ValidatedSensor:
        """Validate one sensor, on the readings of the same name where there are any to test on."""
        calibration = calibrate(readings, self.model, self.estimator, self.unit)
        if tests is None:
            return _held_out_ways(name, calibration, self, rng)
        if name not in tests:
            raise DataError(f"the test file has no sensor {name}; the two files must have the same sensors")
        tested = held_out(readings, tests[name], self.model, self.estimator, self.unit)
        figures = {"test_r_squared": float(tested.r_squared[0]), f"test_{self.rms}": float(tested.rms[0])}
        return ValidatedSensor(name, readings.n, figures, Validation(tested.before[0], tested.after[0]), [])


def validate(
    readings: Readings | Array | Mapping[str, Readings | Array],
    model: Model | Sensor = _MODEL,
    estimator: Estimator = _ESTIMATOR,
    unit: Unit | None = None,
    *,
    test: Readings | Array | Mapping[str, Readings | Array] | None = None,
    criterion: Criterion = _CRITERION,
    programs: Sequence[Program | str | Array] | None = None,
    stand: Stand = _STAND,
    splits: int = 200,
    share: float = 0.6667,
    folds: int = 5,
    turns: int = 200,
    seed: int = 0,
) -> Validated:
    """Hold positions out in every way that there are enough for, and compare programs on what was measured.

    Parameters
    ----------
    readings : Readings, array (n, 3) of means, or a mapping from the names of sensors to these
    model, estimator : Model or Sensor, Estimator
    unit : Unit of the readings, where it is not that of the sensor's channels
    test : as readings, optional
        Other readings of the same sensors: calibrate on `readings`, test on these, and nothing else.
    criterion : Criterion
        By which the best of the measured positions are chosen.
    programs : sequence of Program, name or file of one, or array (n, 3), optional
        To compare, all published ones of the stand if not given; rows of an array are unit vectors in sensor axes.
    stand : Stand of the programs
    splits, share : int, float
        So many random splits, each with this share of the positions for training.
    folds : int
        From 2 to the number of positions; besides, each position is left out by itself.
    turns : int
        Of each program as a whole, that are tried to find measured positions near it.
    seed : int of the splits and the turns

    Raises
    ------
    ArgumentError, ProgramError
        Options that are not acceptable.
    CompatibilityError
        A criterion, an estimator or programs that do not go with the model or the stand.
    DataError
        Readings that can't be used, or too few of them; a sensor that the test lacks.
    SingularError
        Positions that can't show all the parameters.
    """
    require_seed(seed)
    for name, part, kind in (("stand", stand, Stand), ("estimator", estimator, Estimator)):
        require_part(name, part, kind)
    model = estimator.model_for(as_model(model))
    unit = prepared(model, unit)
    verticals = _verticals(model, list(published_for(stand)) if programs is None else programs, stand)
    ways = _Ways(model, estimator, unit, criterion, verticals, splits, share, folds, turns)
    tests = None if test is None else _by_name(test)
    rng = np.random.default_rng(seed)
    sensors = [ways.sensor(name, given, tests, rng) for name, given in _by_name(readings).items()]
    return Validated(sensors, unit_of_residuals(model))


def _by_name(readings: Readings | Array | Mapping[str, Readings | Array]) -> dict[str, Readings]:
    """Readings of each sensor; a single one is called 1."""
    if not isinstance(readings, Mapping):
        return {"1": Readings.of(readings)}
    if not readings:
        raise DataError("there are no readings; give those of one sensor or more")
    return {name: Readings.of(given, name) for name, given in readings.items()}


def _verticals(model: Model, programs: Sequence[Program | str | Array], stand: Stand) -> dict[str, Array]:
    """The one vector that a model reads, arrays (n, 3) in sensor axes, of programs by name, if they say it."""
    quantity = next(iter(model.needs))
    verticals = {}
    for k, one in enumerate(programs, 1):
        if isinstance(one, np.ndarray):
            name = f"program {k}"
            directions = Program(name, name, "given", directions=one).directions  # checked, of length 1
            assert directions is not None
            verticals[name] = directions
            continue
        program = find_program(one, stand) if isinstance(one, str) else one
        felt = stand.stimulus(program.settings_for(stand))
        if quantity in felt and felt.weights is None:
            verticals[program.name] = felt[quantity]
    return verticals


def _held_out_ways(name: str, calibration: Calibration, ways: _Ways, rng: np.random.Generator) -> ValidatedSensor:
    """Random splits, folds and leaving one out where there are enough positions; programs on those there are."""
    readings, model, estimator, unit = calibration.readings, ways.model, ways.estimator, ways.unit
    n, least = readings.n, model.smallest_n
    figures: dict[str, float] = {}
    if n <= least:
        raise DataError(
            "{name}: {n} positions for {least} parameters leave none to test on; give {test}",
            name=readings.name,
            n=n,
            least=least,
            test=Option("test", "FILE.csv", "READINGS"),
        )
    train, held = random_splits(n, ways.share, ways.splits, rng)
    if train.shape[1] >= least:
        splits = validate_splits(readings, train, held, model, estimator, unit)
        figures |= {
            "splits_r_squared": float(np.median(splits.r_squared)),
            f"splits_{ways.rms}": float(np.median(splits.rms)),
            "splits_failed": float(splits.failed),
        }
    folds = take_folds(n, ways.folds, rng)
    if n - max(len(fold) for fold in folds) >= least:
        pooled = validate_folds(readings, folds, model, estimator, unit)
        figures |= {"folds_r_squared": float(pooled.r_squared), f"folds_{ways.rms}": float(pooled.rms)}
    left_out = validate_folds(readings, take_folds(n, n, rng), model, estimator, unit)
    figures |= {"leave_one_out_r_squared": float(left_out.r_squared), f"leave_one_out_{ways.rms}": float(left_out.rms)}
    compared = compare_programs(calibration, ways.programs, ways.criterion, estimator, rng, turns=ways.turns)
    return ValidatedSensor(name, n, figures, left_out, compared)
