"""The vectors that follow from the readings of a sensor, and the readings along them."""

from __future__ import annotations

import numpy as np

from acalx.errors import CompatibilityError, Option
from acalx.models.table import Entry
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import UNITS_OF, conversion
from acalx.sensors.base import Sensor

__all__ = ["along", "of_sensor", "unit_length"]


def of_sensor(sensor: Sensor, quantity: str | None, what: str = "") -> str:
    """The vector that is compared: the one that is named, or the only one that a sensor senses.

    Raises
    ------
    CompatibilityError
        One that does not follow from its readings; several where none is named.
    """
    components = sum(map(sensor.width, sensor.senses))
    if components == len(sensor.channels) and quantity is None and len(sensor.senses) == 1:
        return sensor.senses[0]
    if quantity in sensor.senses and sensor.width(quantity) == 1:
        raise CompatibilityError(
            "{given}: {sensor} takes the {quantity} as one number; a sensor says which quantities of its own are "
            f"vectors, as in vectors = ({quantity!r},)",
            given=Option("quantity", quantity),
            sensor=type(sensor).__name__,
            quantity=_words(quantity),
        )
    if components != len(sensor.channels) or quantity not in sensor.senses:
        whole = sensor.senses and components == len(sensor.channels)
        raise CompatibilityError(
            "{given}: {sensor} has no {what} of the {quantity} to compare; its readings give {senses}: "
            + ("name one of them, as in {one}, or compare" if whole else "compare")
            + " the readings themselves, by Outputs",
            given=Option("quantity", quantity),
            sensor=type(sensor).__name__,
            what=what or "vector",
            quantity=_words(quantity or "one vector"),
            senses=", ".join(map(_words, sensor.senses)) or "no vector by themselves",
            one=Option("quantity", sensor.senses[0] if whole else None),
        )
    assert quantity is not None  # which is none of them
    return quantity


def unit_length(sensor: Sensor, quantity: str) -> float:
    """1 in the unit that stands give a quantity in, gravity or the strength of the field, in the sensor's unit.

    Of a quantity that only the sensor knows, 1 in its unit.

    Raises
    ------
    CompatibilityError
        Where the sensor takes it in a unit in which nobody knows how long it is.
    """
    usual, own = UNITS_OF.get(quantity, sensor.needs[quantity]), sensor.needs[quantity]
    length = conversion(usual, own)
    if length is None:
        raise CompatibilityError(
            f"{type(sensor).__name__} takes the {_words(quantity)} in {own}, in which its length is not known: take it "
            f"in {usual}, in which it is 1, compare lengths that are given, by Magnitude with varies=true, or the "
            "readings, by Outputs"
        )
    return length


def along(sensor: Sensor, quantity: str, noise: Array) -> list[Entry] | None:
    """u' G for a vector u of length 1 that the channels read, component by component, with the same noise.

    None for a sensor of any other form, whose rows are no such products.
    """
    ideal = {channel: (factor, product) for channel, factor, product in sensor.ideal}
    factor = sensor.ideal[0][1] if sensor.ideal else 0.0
    plain = ideal == {k: (factor, ((quantity, k),)) for k in range(3)} and len(sensor.ideal) == 3
    of_length_one = unit_length(sensor, quantity) == 1.0 and quantity != "angular_rate"
    if sensor.table is None or not plain or not of_length_one or np.ptp(noise) > 0.0:
        return None
    return [
        (0, number, each / noise[0], ((quantity, channel), *product)) for channel, number, each, product in sensor.table
    ]


def _words(quantity: str) -> str:
    return quantity.replace("_", " ")
