"""What a calibration is for: readings made right."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np

from acalx.errors import DataError
from acalx.numerics.arrays import Array

__all__ = ["Correction", "read_correction"]


@final
@dataclass(frozen=True, eq=False)
class Correction:
    """Specific force in g = matrix (reading - offset).

    Parameters
    ----------
    matrix : array (3, 3), g per unit of the readings
    offset : array (3,), in the unit of the readings
    unit : str
        Name of that unit.
    """

    matrix: Array
    offset: Array
    unit: str

    def apply(self, readings: Array) -> Array:
        """Specific force in g, array (..., 3), from readings (..., 3) in the unit of the sensor.

        Any number of them at a time: a file larger than memory is corrected block by block.
        """
        return np.asarray((readings - self.offset) @ self.matrix.T)

    def entries(self) -> dict[str, Any]:
        """Formula, matrix, offset and unit, as `read_correction` takes them from a file."""
        return {
            "formula": "specific force in g = matrix (reading - offset)",
            "matrix": self.matrix.tolist(),
            "offset": self.offset.tolist(),
            "unit": self.unit,
        }


def read_correction(path: str | os.PathLike[str]) -> Correction:
    """Read the correction from a calibration.json.

    Raises
    ------
    DataError
        Where there is none, or something else in it.
    """
    path = Path(path).expanduser()
    if path.is_dir():
        path = path / "calibration.json"
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))["correction"]
        matrix, offset = np.array(entries["matrix"], dtype=float), np.array(entries["offset"], dtype=float)
        unit = str(entries["unit"])
    except OSError as error:
        raise DataError(f"{path}: can't be read: {error.strerror}; give the calibration.json of a run") from error
    except (ValueError, KeyError, TypeError) as error:
        raise DataError(f"{path}: not a calibration.json with a correction: matrix, offset, unit") from error
    if matrix.shape != (3, 3) or offset.shape != (3,) or not (np.isfinite(matrix).all() and np.isfinite(offset).all()):
        raise DataError(f"{path}: the correction must be a 3 x 3 matrix and an offset of three finite numbers")
    return Correction(matrix, offset, unit)
