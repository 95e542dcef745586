"""A two-axis table in a climatic chamber."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import ClassVar, final

import numpy as np

from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus
from acalx.quantities.units import CELSIUS
from acalx.stands.base import Setting
from acalx.stands.fields import limits, number, step
from acalx.stands.rotary import Rotary
from acalx.stands.turns import UP, Vector

__all__ = ["Chamber"]


@final
@dataclass(frozen=True)
class Chamber(Rotary):
    """A table with two axes, as `TwoAxis`, in a chamber whose temperature is a setting of each position.

    Parameters
    ----------
    alpha1_deg, alpha2_deg : pair of float, degrees
        Limits of the angles.
    temperature_degC : pair of float, degrees Celsius
        Limits of the temperature.
    temperature_step_degC : float, degrees Celsius, optional
        The temperature is a whole multiple of it. None: any.
    temperature_speed_degC_min : float, degrees Celsius per minute
        How fast it changes, soaking included; for the order of visit.
    step_deg, periodic
        As of `Rotary`.
    forbidden, forbidden_if, speed_deg_s
        As of `Stand`; ``temperature_degC`` is a setting too.

    Raises
    ------
    ArgumentError
        Limits the wrong way round or not finite, a step or a speed that is not positive.

    Source: IEEE Std 1293-2018, temperature tests.
    """

    turns: ClassVar[Mapping[str, str]] = {"alpha1": "-y", "alpha2": "x"}
    surroundings: ClassVar[Mapping[str, Vector]] = {"specific_force": UP}
    frequencies: ClassVar[tuple[int, ...]] = (1, 1, 1)
    alpha1_deg: Sequence[float] = limits(0.0, 360.0)
    alpha2_deg: Sequence[float] = limits(0.0, 360.0)
    temperature_degC: Sequence[float] = limits(-20.0, 60.0, CELSIUS)  # noqa: N815 - as it is written
    _: KW_ONLY
    temperature_step_degC: float | None = step(CELSIUS)  # noqa: N815
    temperature_speed_degC_min: float = number(1.0, 1e-3, 1e3, CELSIUS)  # noqa: N815

    @cached_property
    def settings(self) -> tuple[Setting, ...]:
        """The two angles, and the temperature."""
        given, speed = (self.temperature_degC, self.temperature_step_degC), self.temperature_speed_degC_min / 60.0
        return (*self.angles, Setting.in_unit("temperature", *given, False, CELSIUS, speed))

    def stimulus(self, settings: Array) -> Stimulus:
        """The vertical in sensor axes, (..., n, 3), and the temperature, (..., n, 1): settings (..., n, 3)."""
        return Stimulus({**super().stimulus(settings), "temperature": settings[..., 2:]})

    def derivative(self, settings: Array) -> Stimulus:
        """Its exact derivatives, (..., n, 3, 3) and (..., n, 1, 3)."""
        by_force = np.insert(self.by_angles(settings)["specific_force"], 2, 0.0, axis=-1)
        by_temperature = np.broadcast_to([0.0, 0.0, 1.0], (*settings.shape[:-1], 1, 3))
        return Stimulus(specific_force=by_force, temperature=by_temperature)
