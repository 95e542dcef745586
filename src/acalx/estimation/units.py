"""The unit of readings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from acalx.errors import ArgumentError, Option
from acalx.options import is_number

__all__ = ["Unit"]


@final
@dataclass(frozen=True)
class Unit:
    """What a sensor's numbers mean.

    Parameters
    ----------
    name : str
        As it is shown, e.g. ``m/s^2``.
    per_g : float, optional
        So many units are the local gravity: 1 for g, 9.8 for m/s^2, the nominal sensitivity for
        the counts of a converter. None: unknown, found from the readings; scale errors are
        then relative to the mean sensitivity.
    offset : float
        What a perfect sensor reads at zero, e.g. 32768 for the counts of an unsigned converter.

    Raises
    ------
    ArgumentError
        Numbers that are not finite, a `per_g` that is not positive.
    """

    name: str = "g"
    per_g: float | None = 1.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        if not self.name or not isinstance(self.name, str):
            raise ArgumentError.of("name", self.name, "a unit has a name, such as counts")
        if self.per_g is not None and not (is_number(self.per_g) and self.per_g > 0):
            raise ArgumentError(
                "{given}: give the number of {unit} that are 1 g, such as 9.80665 or 4096, "
                "or {unknown} where it is to be found from the readings",
                given=Option("per_g", self.per_g),
                unit=self.name,
                unknown=Option("per_g", None),
            )
        if not is_number(self.offset):
            raise ArgumentError.of("offset", self.offset, "give the reading of a perfect sensor at zero, such as 32768")
