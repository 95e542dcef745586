"""The two-axis table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import ClassVar, final

from acalx.errors import Option
from acalx.stands.fields import limits, number
from acalx.stands.rotary import Rotary
from acalx.stands.turns import UP, Vector

__all__ = ["TwoAxis"]


@final
@dataclass(frozen=True)
class TwoAxis(Rotary):
    """A table with two axes, which brings the vertical to any direction of the sensor.

    The unit vector of the vertical in sensor axes is
    (sin a1, cos a1 sin a2, cos a1 cos a2). Every direction is reached by two pairs of
    angles, (a1, a2) and (180 - a1, a2 + 180).

    Parameters
    ----------
    alpha1_deg, alpha2_deg : pair of float, degrees
        Lower and upper limit of each angle.
    dip_deg : float, degrees, optional
        How far the magnetic field points below the horizon. None: the field plays no part.
    field_azimuth_deg : float, degrees
        Of the field's horizontal part, from the table's x axis at zero angles towards y, the
        axis of alpha1.
    step_deg, periodic
        As of `Rotary`.
    forbidden, forbidden_if, speed_deg_s
        As of `Stand`.

    Raises
    ------
    ArgumentError
        Limits the wrong way round or not finite, a step that is not positive, zones that are
        not understood.

    Source: Egorov, Kiryachenko, Popov (2021); the mapping reproduces their printed programs.
    """

    turns: ClassVar[Mapping[str, str]] = {"alpha1": "-y", "alpha2": "x"}
    alpha1_deg: Sequence[float] = limits(0.0, 360.0)
    alpha2_deg: Sequence[float] = limits(0.0, 360.0)
    _: KW_ONLY
    dip_deg: float | None = number(None, -90.0, 90.0)
    field_azimuth_deg: float = number(0.0, -360.0, 360.0)

    @cached_property
    def surroundings(self) -> Mapping[str, Vector]:
        """Gravity, and the magnetic field where its dip is given."""
        if self.dip_deg is None:
            return {"specific_force": UP}
        dip, azimuth = math.radians(self.dip_deg), math.radians(self.field_azimuth_deg)
        field = (math.cos(dip) * math.cos(azimuth), math.cos(dip) * math.sin(azimuth), -math.sin(dip))
        return {"specific_force": UP, "magnetic_field": field}

    @property
    def circumstances(self) -> list[Option]:
        """Where the field points, where it plays a part."""
        if self.dip_deg is None:
            return []
        return [Option("dip_deg", self.dip_deg), Option("field_azimuth_deg", self.field_azimuth_deg)]

    def advice(self, quantity: str) -> tuple[str, Mapping[str, Option]]:
        """The field is there where its dip is given."""
        missing = quantity == "magnetic_field"
        return (" unless its dip is given, as in {dip}", {"dip": Option("stand.dip_deg", 65)}) if missing else ("", {})
