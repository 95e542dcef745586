"""The interface of a stand: what turns the sensor, and within which limits."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from acalx.errors import CompatibilityError, Option
from acalx.numerics.arrays import Array
from acalx.numerics.differences import STEP, differences
from acalx.options import require_speeds
from acalx.quantities.stimulus import Stimulus
from acalx.stands.axes import Axes
from acalx.stands.fields import check_fields
from acalx.stands.motion import Samples
from acalx.stands.setting import Setting
from acalx.stands.zone_options import read_zones
from acalx.stands.zones import Zone

__all__ = ["Setting", "Stand"]


@dataclass(frozen=True, eq=False)
class Stand(ABC):
    """What turns the sensor: settings in, stimulus out, and options that all stands have.

    A new stand gives `settings` and `stimulus`; everything else follows, or may be given where
    more is known. One that turns the sensor about axes is a `Rotary`. Concrete stands are frozen
    dataclasses.

    Parameters
    ----------
    forbidden : sequence of mappings
        Boxes of settings that must not be taken, as ``{"alpha1_deg": (80, 100), "alpha2_deg":
        (170, 190)}``; a setting that is left out may be any. The edge of a box is allowed.
    forbidden_if : str or callable
        Function of arrays by the names of the settings with their units, ``alpha1_deg,
        alpha2_deg``, true where they must not be taken; or where it is, as ``module.function``.
    speed_deg_s : float or sequence of float, degrees per second
        How fast the angles turn, all or each; for the order of visit. Settings that are no angles
        change meanwhile, unless they say how fast.

    Raises
    ------
    ArgumentError
        Zones or speeds that are not understood.
    """

    _: KW_ONLY
    forbidden: Sequence[Mapping[str, Sequence[float]]] = ()
    forbidden_if: str | Callable[..., Any] | None = None
    speed_deg_s: float | Sequence[float] = 10.0

    def __post_init__(self) -> None:
        check_fields(self)
        # built once here so that bad ones are refused at construction
        _ = self.settings, self.zones, self.speeds, self.samples

    # ---- what a stand gives

    @property
    @abstractmethod
    def settings(self) -> tuple[Setting, ...]:
        """The d angles, or other settings, of a position, with their limits."""

    @abstractmethod
    def stimulus(self, settings: Array) -> Stimulus:
        """What the sensor feels: settings (..., n, d), in rad or the SI unit, to arrays (..., n, width)."""

    # ---- what follows for all

    @cached_property
    def zones(self) -> tuple[Zone, ...]:
        """The forbidden boxes, then what the function says."""
        return read_zones(self.settings, self.forbidden, self.forbidden_if)

    @cached_property
    def axes(self) -> Axes:
        """The range of the settings: limits, steps and zones, and what follows from them."""
        return Axes(self.settings, self.zones, type(self).__name__)

    @property
    def samples(self) -> Samples | None:
        """Of the motion within a position, where there is one; None, the default: what is felt does not change."""
        return None

    def starts(self, settings: Array) -> Array:
        """Settings (..., n, d) at the beginning of each position; by default those that it has throughout."""
        return settings

    def ends(self, settings: Array) -> Array:
        """The same at its end."""
        return settings

    def derivative(self, settings: Array) -> Stimulus:
        """Derivatives of the stimulus with respect to the settings, arrays (..., n, width, d).

        The default differentiates `stimulus` numerically, by differences of fourth order.
        """
        felt = self.stimulus(settings)
        ends = np.cumsum([value.shape[-1] for value in felt.values()])
        ranges = np.array([setting.upper - setting.lower for setting in self.settings])
        angles = np.array([setting.angle for setting in self.settings])

        def side_by_side(shift: Array) -> Array:
            moved = self.stimulus(settings + shift)
            return np.concatenate([moved[name] for name in felt], axis=-1)

        by_setting = differences(side_by_side, STEP * np.where(angles, np.minimum(ranges, 1.0), ranges))
        return felt.made(dict(zip(felt, np.split(by_setting, ends[:-1], axis=-2), strict=True)))

    def pull(self, settings: Array, gradient: Stimulus) -> Array:
        """From a gradient with respect to the stimulus, (..., n, width), to the settings, (..., n, d)."""
        derivative = self.derivative(settings)
        total = np.zeros(settings.shape)
        for name, feels in gradient.items():
            if name not in derivative:  # of the program itself, as the time
                continue
            pulled = (feels[..., None, :] @ derivative[name])[..., 0, :]
            total += pulled if gradient.weights is None else pulled.sum(axis=-2)
        return total

    # ---- what only the bound asks

    @property
    def frequencies(self) -> tuple[int, ...] | None:
        """Degree of the stimulus in each setting; None if unknown, the default.

        As a trigonometric polynomial in an angle, as a polynomial in a setting that is none.
        """
        return None

    # ---- what only programs that give directions ask

    def aim(self, directions: Array) -> Array:
        """Settings (..., n, d) that bring the vertical to these directions (..., n, 3) of the sensor.

        Settings that are no angles are at rest: 0, or as near to it as they can be.

        Raises
        ------
        CompatibilityError
            Where the stand does not say how; the default.
        """
        raise CompatibilityError(f"{type(self).__name__} can't be aimed at directions: give its angles instead")

    # ---- what only the order of visit asks

    @cached_property
    def speeds(self) -> Array:
        """How fast each setting changes, (d,), in the SI unit; infinite where that takes no time of its own."""
        angles = np.array([setting.angle for setting in self.settings])
        speeds = np.array([setting.speed for setting in self.settings])
        speeds[angles] = require_speeds("speed_deg_s", self.speed_deg_s, int(angles.sum()))
        return speeds

    def equivalents(self, settings: Array) -> Array:
        """Settings for the same stimulus that the stand can take, (k, n, d), those given (n, d) first.

        Where there are fewer for a position, the given ones again. The default knows no others.
        """
        return settings[None]

    # ---- what only the simulation asks

    @property
    def axis_errors(self) -> tuple[str, ...]:
        """Names of the e small angles by which the stand's axes may be off; none by default."""
        return ()

    def misaligned(self, settings: Array, errors: Array) -> Stimulus:
        """What the sensor feels where the axes are off by angles (..., n, e) in rad; by default as if they were not."""
        return self.stimulus(settings)

    # ---- what only messages ask

    def advice(self, quantity: str) -> tuple[str, Mapping[str, Option]]:
        """What to add to the message that a quantity of the stimulus is not provided, and the options in it by name."""
        return "", {}

    @property
    def circumstances(self) -> list[Option]:
        """Options other than limits and steps on which it depends what can be estimated, for messages."""
        return []
