"""Whether readings can be what they are said to be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from acalx.errors import DataError, Option
from acalx.estimation.readings import Readings
from acalx.estimation.units import Unit
from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.quantities.parameter import parameter_groups
from acalx.quantities.stimulus import UNITS_OF, Stimulus, conversion, same_kind

__all__ = ["OF_LENGTH_ONE", "check_positions", "question_unit"]

# Units in which what is felt has a size that everybody knows: gravity, and the strength of the field.
OF_LENGTH_ONE = ("g", "field")
# Vectors that are never so small that a bias could be as large.
_STRONG = ("specific_force", "magnetic_field")
_LEAST, _MOST = 0.7, 1.4
# Scale errors are far smaller than one half; other units are further off.
_HALF, _NEAR = 0.5, 0.2
# Positions in which what is felt is a good part of the most that is, and that most in standard deviations.
_MOVED, _BEYOND = 0.3, 100.0
# Where a sensor of a vector of one length is turned its readings differ by more than this share of their level.
_ALIKE = 1e-3


def check_positions(readings: Readings, model: Model, unit: Unit) -> None:
    """Raise DataError for a single position, one that reads nothing at all, or positions that read the same.

    Those of a sensor that is turned in a vector of one length must differ as much as that does; others may read nearly
    the same, as a gyro of some drift does.
    """
    if readings.n == 1:
        raise DataError(f"{readings.name}: a single position; a calibration needs several, turned differently")
    nothing = np.flatnonzero((readings.means == 0.0).all(axis=1))
    if len(nothing):
        zeros = ", ".join("0" * readings.means.shape[1])
        raise DataError(f"{readings.name}: position {nothing[0] + 1} reads {zeros}; is it missing?")
    means = readings.means - unit.offset
    alike = _ALIKE * np.abs(means).max() if model.by_length else 0.0
    if np.ptp(means, axis=0).max() <= alike:
        raise DataError(f"{readings.name}: all {readings.n} positions read the same; turn the sensor between them")


def question_unit(readings: Readings, model: Model, unit: Unit) -> None:
    """Raise DataError for readings that can't be in the unit that they are said to be in, by what is known of them."""
    for one, own in model.singles:
        _question_magnitude(replace(readings, means=readings.means[:, own], deviations=None), one, unit)
    _question_scale(readings, model, unit)


def _question_magnitude(readings: Readings, model: Model, unit: Unit) -> None:
    """Refuse readings of triads that can't be in the unit that they are said to be in, by lengths that are known."""
    if unit.per_g is None or not isinstance(model.needs, Mapping):  # found from the readings, or in no unit
        return
    per = unit.per_channel(model.channels)
    for name in _STRONG:
        wanted = model.needs.get(name)
        own = [k for k, channel in enumerate(model.channels) if channel.unit == wanted]
        expected = _expected(model, name, own, readings.stimulus) if len(own) == 3 else None
        if wanted is None or expected is None:
            continue
        lengths, one = np.linalg.norm(readings.means[:, own] - unit.offset, axis=1), float(per[own[0]])
        # a gross error in some positions is no wrong unit
        if all(not _LEAST < one_of / (one * expected) < _MOST for one_of in (lengths.mean(), np.median(lengths))):
            _refuse(readings, model, unit, wanted, float(lengths.mean()), expected, one)


def _question_scale(readings: Readings, model: Model, unit: Unit) -> None:
    """Refuse readings that follow what was felt, where that is known, by another factor than their unit says.

    Signs are not looked at: an axis may be reversed. A unit of channels counts where what is felt moves their readings
    far beyond their noise.
    """
    known = readings.stimulus
    if unit.per_g is None or known is None or not all(name in known for name in model.needs):
        return
    expected = model.readings(model.nominal, known)
    means = (readings.means - unit.offset) / unit.per_channel(model.channels)
    deviations = np.broadcast_to(model.deviations(known), expected.shape)
    for own in dict.fromkeys(channel.unit for channel in model.channels):
        which = [k for k, channel in enumerate(model.channels) if channel.unit == own]
        felt, read = ((each - np.median(each, axis=0))[:, which] for each in (expected, means))
        moved = np.abs(felt) > _MOVED * np.abs(felt).max()
        told = all(model.channels[k].noise != 1.0 for k in which)
        if told and not np.abs(felt).max() > _BEYOND * deviations[:, which].max():
            continue
        factor = float(np.median(np.abs(read[moved] / felt[moved]))) if moved.any() else 1.0
        if not _HALF < factor < 1.0 / _HALF:
            _refuse_scale(readings, unit, own, factor)


def _refuse_scale(readings: Readings, unit: Unit, own: str, factor: float) -> None:
    guesses = [name for name in same_kind(own) if abs(np.log(factor / (conversion(own, name) or np.inf))) < _NEAR]
    raise DataError(
        "{name}: channels in {own} follow what was felt by a factor of {factor:.4g}; is their unit right?{looks} "
        "Nothing is scaled silently: say what they are, {given}",
        name=readings.name,
        own=own,
        factor=factor,
        looks=f" They look like {guesses[0]}." if guesses else "",
        given=Option("unit.per_g", {own: float(f"{factor:.4g}")}),
    )


def _expected(model: Model, quantity: str, own: list[int], known: Stimulus | None) -> float | None:
    """Mean length of what three channels of a sensor without errors read; None where nothing tells it.

    It is told by what is known of the positions, or by a comparison that takes the length for one.
    """
    assert isinstance(model.needs, Mapping)  # in which it is looked for
    one = conversion(UNITS_OF[quantity], model.needs[quantity]) or 1.0
    if known is not None and all(name in known for name in model.needs):
        read: Array = model.readings(model.nominal, known)[..., own]
        mean = float(np.linalg.norm(read, axis=-1).mean())
        return mean if mean > 0.5 * one else None  # a bias may be as large as the others
    return model.lengths.get(quantity)


def _refuse(readings: Readings, model: Model, unit: Unit, name: str, mean: float, expected: float, one: float) -> None:
    meters, g = Option("unit", "m_s2", 'Unit("m/s^2", 9.80665)'), Option("unit", "g", "Unit()")
    each, found = mean / expected, model.by_length and "scale" in parameter_groups(model.parameters)
    if name == "g":
        guess = (
            "m/s^2 ({meters})"
            if 7.0 < each < 13.0
            else "g ({g})"
            if _LEAST < each < _MOST
            else "counts, {each:.4g} a g"
        )
    else:
        guess = "{each:.4g} a field strength" if name == "field" else "{each:.4g} for 1 {of}"
    raise DataError(
        "{name}: the mean magnitude is {mean:.5g}, but {length:.5g} {of} should read {expected:.6g} {unit}; "
        f"is the unit right? This looks like {guess}. Nothing is scaled silently: give the right unit"
        + (", or {counts} {unknown} to have the scale found" if found else ""),
        name=readings.name,
        of=name,
        mean=mean,
        each=each,
        length=expected,
        expected=one * expected,
        unit=unit.name,
        meters=meters,
        g=g,
        counts=Option("unit", "counts", 'Unit("counts", None),'),
        unknown=Option("unit.per_g", None),
    )
