"""Whether readings can be what they are said to be."""

from __future__ import annotations

import numpy as np

from acalx.errors import DataError, Option
from acalx.estimation.readings import Readings
from acalx.estimation.units import Unit
from acalx.models import Model

__all__ = ["OF_LENGTH_ONE", "check_positions", "question_magnitude"]

# Units in which what is felt has a size that everybody knows: gravity, and the strength of the field.
OF_LENGTH_ONE = ("g", "field")
_LEAST, _MOST = 0.7, 1.4


def check_positions(readings: Readings) -> None:
    """Raise DataError for a single position, one that reads nothing at all, or positions that read the same."""
    if readings.n == 1:
        raise DataError(f"{readings.name}: a single position; a calibration needs several, turned differently")
    nothing = np.flatnonzero((readings.means == 0.0).all(axis=1))
    if len(nothing):
        zeros = ", ".join("0" * readings.means.shape[1])
        raise DataError(f"{readings.name}: position {nothing[0] + 1} reads {zeros}; is it missing?")
    spread = np.ptp(readings.means, axis=0).max()
    if spread <= 1e-3 * np.abs(readings.means).max():
        raise DataError(f"{readings.name}: all {readings.n} positions read the same; turn the sensor between them")


def question_magnitude(readings: Readings, model: Model, unit: Unit) -> None:
    """Refuse readings of triads that can't be in the unit that they are said to be in."""
    if unit.per_g is None:  # found from the readings themselves
        return
    per = unit.per_channel(model.channels)
    for name in OF_LENGTH_ONE:
        own = [k for k, channel in enumerate(model.channels) if channel.unit == name]
        if len(own) != 3:
            continue
        lengths = np.linalg.norm(readings.means[:, own] - unit.offset, axis=1)
        mean, one = float(lengths.mean()), float(per[own[0]])
        if not _LEAST < mean / one < _MOST:
            _refuse(readings, unit, name, mean, one)


def _refuse(readings: Readings, unit: Unit, name: str, mean: float, one: float) -> None:
    meters, g = Option("unit", "m_s2", 'Unit("m/s^2", 9.80665)'), Option("unit", "g", "Unit()")
    if name == "g":
        guess = (
            "m/s^2 ({meters})"
            if 7.0 < mean < 13.0
            else "g ({g})"
            if _LEAST < mean < _MOST
            else "counts, {mean:.4g} a g"
        )
    else:
        guess = "{mean:.4g} a field strength"
    raise DataError(
        "{name}: the mean magnitude is {mean:.5g}, but 1 {of} should read {one:.6g} {unit}; "
        f"is the unit right? This looks like {guess}. Nothing is scaled silently: give the right unit, "
        "or {counts} {unknown} to have the scale found",
        name=readings.name,
        of=name,
        mean=mean,
        one=one,
        unit=unit.name,
        meters=meters,
        g=g,
        counts=Option("unit", "counts", 'Unit("counts", None),'),
        unknown=Option("unit.per_g", None),
    )
