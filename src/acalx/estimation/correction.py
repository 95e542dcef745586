"""What a calibration is for: readings made right."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, final

import numpy as np

from acalx.errors import DataError, Option
from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus

__all__ = ["Correction", "Correctly", "ModelCorrection", "correction_of", "read_correction"]

_FORMULA = "specific force in g = matrix (reading - offset)"
# How far from a matrix and an offset corrected readings may be, relative to them, to be called that.
_AFFINE = 1e-10


@final
@dataclass(frozen=True, eq=False)
class Correction:
    """Corrected readings = matrix (reading - offset): of a triad of accelerometers the specific force in g.

    Parameters
    ----------
    matrix : array (k, k), the sensor's own unit per unit of the readings
    offset : array (k,), in the unit of the readings
    unit : str
        Name of that unit.
    units : tuple of str, length k, optional
        Of what comes out; g where it is not told.
    """

    matrix: Array
    offset: Array
    unit: str
    units: tuple[str, ...] = ()

    @property
    def needs(self) -> tuple[str, ...]:
        """Nothing but the readings."""
        return ()

    def apply(self, readings: Array, known: Stimulus | None = None) -> Array:
        """Corrected readings, array (..., k), from readings (..., k) in the unit of the sensor.

        Any number of them at a time: a file larger than memory is corrected block by block.
        """
        return np.asarray((readings - self.offset) @ self.matrix.T)

    @property
    def formula(self) -> str:
        """What is done, in words."""
        if set(self.units) <= {"g"}:
            return _FORMULA
        return f"corrected readings in {', '.join(dict.fromkeys(self.units))} = matrix (reading - offset)"

    def entries(self) -> dict[str, Any]:
        """Formula, matrix, offset and unit, as `read_correction` takes them from a file."""
        entries = {
            "formula": self.formula,
            "matrix": self.matrix.tolist(),
            "offset": self.offset.tolist(),
            "unit": self.unit,
        }
        return entries if set(self.units) <= {"g"} else {**entries, "units": list(self.units)}


@final
@dataclass(frozen=True, eq=False)
class ModelCorrection:
    """Corrected readings by the model itself, where no matrix and offset make them.

    Parameters
    ----------
    model : Model
    parameters : array (p,)
    per : array (k,)
        How many units of the readings are one of each channel's own.
    offset : float
        What a perfect sensor reads at zero.
    unit : str
        Of the readings.
    """

    model: Model
    parameters: Array
    per: Array
    offset: float
    unit: str
    units: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "units", tuple(channel.unit for channel in self.model.channels))

    @property
    def needs(self) -> tuple[str, ...]:
        """What must be known of a reading beside itself."""
        return self.model.corrects_with

    def apply(self, readings: Array, known: Stimulus | None = None) -> Array:
        """Readings as a sensor without errors would have given them, (n, k) in its own units, from readings (n, k)."""
        return self.model.corrected(self.parameters, (readings - self.offset) / self.per, known)

    @property
    def formula(self) -> str:
        """What is done, in words."""
        units = ", ".join(dict.fromkeys(self.units))
        return f"corrected readings in {units}: those that {self.model.called} would have given without errors"

    def entries(self) -> dict[str, Any]:
        """What is to be known of it; the parameters are in the same file."""
        return {
            "formula": self.formula,
            "needs": list(self.needs),
            "per": self.per.tolist(),
            "offset": self.offset,
            "unit": self.unit,
            "units": list(self.units),
        }


Correctly = Correction | ModelCorrection


def correction_of(model: Model, parameters: Array, per: Array, offset: float, unit: str) -> Correctly:
    """A matrix and an offset where these correct the readings of a model, else the model itself.

    Parameters
    ----------
    model : Model
    parameters : array (p,)
    per : array (k,)
        How many units of the readings are one of each channel's own.
    offset, unit
        As of `acalx.estimation.Unit`.
    """
    by_model = ModelCorrection(model, parameters, per, offset, unit)
    k = len(per)
    if by_model.needs or not np.isfinite(parameters).all():
        return by_model
    probes = np.concatenate([np.zeros((1, k)), np.eye(k), np.tile([[0.7], [-1.3]], k), 0.5 - np.eye(k)])
    felt = model.corrected(parameters, probes, None)
    matrix = (felt[1 : k + 1] - felt[0]).T
    wrong = np.abs(felt - (probes @ matrix.T + felt[0])).max()
    if not wrong <= _AFFINE * np.abs(felt).max() or np.linalg.matrix_rank(matrix) < k:
        return by_model
    at_zero = -np.linalg.solve(matrix, felt[0])
    return Correction(matrix / per, offset + per * at_zero, unit, by_model.units)


def read_correction(path: str | os.PathLike[str], model: Model | None = None) -> Correctly:
    """Read the correction from a calibration.json.

    Parameters
    ----------
    path : str or path
    model : Model, optional
        The one that was calibrated, for corrections that are no matrix and offset.

    Raises
    ------
    DataError
        Where there is none, or something else in it, or it is of another model.
    """
    path = Path(path).expanduser()
    if path.is_dir():
        path = path / "calibration.json"
    try:
        whole = json.loads(path.read_text(encoding="utf-8"))
        entries = whole["correction"]
        unit, units = str(entries["unit"]), tuple(map(str, entries.get("units", ())))
        if "matrix" not in entries:
            return _by_model(path, whole, model)
        matrix, offset = np.array(entries["matrix"], dtype=float), np.array(entries["offset"], dtype=float)
    except OSError as error:
        raise DataError(f"{path}: can't be read: {error.strerror}; give the calibration.json of a run") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        if isinstance(error, DataError):
            raise
        raise DataError(f"{path}: not a calibration.json with a correction: matrix, offset, unit") from error
    k = len(offset) if offset.ndim == 1 else 0
    if not k or matrix.shape != (k, k) or not (np.isfinite(matrix).all() and np.isfinite(offset).all()):
        raise DataError(f"{path}: the correction must be a square matrix, and an offset as long, of finite numbers")
    return Correction(matrix, offset, unit, units)


def _by_model(path: Path, whole: dict[str, Any], model: Model | None) -> ModelCorrection:
    """The correction by parameters that stand in the same file, under the names that the model has for them."""
    entries, given = whole["correction"], whole["parameters"]
    names: Sequence[str] = [] if model is None else [parameter.name for parameter in model.parameters]
    if model is None or set(names) != set(given):
        raise DataError(
            "{path}: these are the parameters of another model ({some}, ...); give {model}, with its options as they "
            "were when it was calibrated",
            path=path,
            some=", ".join(list(given)[:3]),
            model=Option("model", "NAME", "..."),
        )
    parameters = np.array([float(given[name]["estimate"]) for name in names])
    per = np.array(entries["per"], dtype=float)
    return ModelCorrection(model, parameters, per, float(entries["offset"]), str(entries["unit"]))
