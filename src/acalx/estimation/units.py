"""The unit of readings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from acalx.errors import ArgumentError, Option
from acalx.numerics.arrays import Array
from acalx.options import is_number, keep
from acalx.sensors import Channel

__all__ = ["Unit"]


@final
@dataclass(frozen=True)
class Unit:
    """What a sensor's numbers mean.

    Parameters
    ----------
    name : str, optional
        As it is shown, e.g. ``m/s^2``; those of the sensor's channels where there is none.
    per_g : float, mapping or None
        So many units are the local gravity: 1 for g, 9.8 for m/s^2, the nominal sensitivity for
        the counts of a converter; of another sensor so many are one of its own unit, the strength of the field or
        1 deg/s. Of a sensor with channels in several units a number for each, ``{g: 2048, deg/s: 16.4}``. None:
        unknown, found from the readings; scale errors are then relative to the mean sensitivity.
    offset : float
        What a perfect sensor reads at zero, e.g. 32768 for the counts of an unsigned converter.

    Raises
    ------
    ArgumentError
        Numbers that are not finite, a `per_g` that is not positive.
    """

    name: str | None = "g"
    per_g: float | Mapping[str, float] | None = 1.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        if self.name is not None and (not self.name or not isinstance(self.name, str)):
            raise ArgumentError.of("name", self.name, "a unit has a name, such as counts")
        several = isinstance(self.per_g, Mapping)
        numbers = list(self.per_g.values()) if isinstance(self.per_g, Mapping) else [self.per_g]
        if (several and not numbers) or not all(
            (number is None and not several) or (is_number(number) and number > 0) for number in numbers
        ):
            raise ArgumentError(
                "{given}: give the number of {unit} that are 1 g, such as 9.80665 or 4096, "
                "or {unknown} where it is to be found from the readings",
                given=Option("per_g", self.per_g),
                unit=self.name or "the readings' unit",
                unknown=Option("per_g", None),
            )
        if not is_number(self.offset):
            raise ArgumentError.of("offset", self.offset, "give the reading of a perfect sensor at zero, such as 32768")
        keep(self, "per_g")

    def named_for(self, channels: Sequence[Channel]) -> Unit:
        """The same with a name, where it has none that of the channels."""
        return self if self.name else replace(self, name=", ".join(dict.fromkeys(channel.unit for channel in channels)))

    def per_channel(self, channels: Sequence[Channel]) -> Array:
        """How many units are one of each channel's own, (k,).

        Raises
        ------
        ArgumentError
            A number for a unit that no channel has, or none for one that they have.
        """
        if not isinstance(self.per_g, Mapping):
            assert self.per_g is not None  # found, where it was not given
            several = list(dict.fromkeys(channel.unit for channel in channels))
            if self.per_g != 1.0 and len(several) > 1:
                raise ArgumentError(
                    "{given}: the sensor's channels are in {units}: give a number for each, as in {each}",
                    given=Option("per_g", self.per_g),
                    units=" and ".join(several),
                    each=Option("per_g", {several[0]: self.per_g, **dict.fromkeys(several[1:], 1.0)}),
                )
            return np.full(len(channels), float(self.per_g))
        units = dict.fromkeys(channel.unit for channel in channels)
        if set(units) != set(self.per_g):
            raise ArgumentError(
                "{given}: give a number for each unit of the sensor's channels, {units}",
                given=Option("per_g", dict(self.per_g)),
                units=", ".join(units),
            )
        return np.array([float(self.per_g[channel.unit]) for channel in channels])
