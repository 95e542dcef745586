"""The interface of a stand: what turns the sensor, and within which limits."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from functools import cached_property

import numpy as np

from acalx.errors import CompatibilityError
from acalx.numerics.arrays import Array
from acalx.quantities.stimulus import Stimulus
from acalx.stands.axes import Axes
from acalx.stands.setting import Setting
from acalx.stands.zones import Zone

__all__ = ["Setting", "Stand"]


class Stand(ABC):
    """What turns the sensor: settings in, stimulus out.

    A new stand gives `settings` and `stimulus`; the derivative is then numerical until it is
    given exactly. Concrete stands are frozen dataclasses.
    """

    @property
    @abstractmethod
    def settings(self) -> tuple[Setting, ...]:
        """The d angles, or other settings, of a position, with their limits."""

    @abstractmethod
    def stimulus(self, settings: Array) -> Stimulus:
        """What the sensor feels: settings (..., n, d), in rad where they are angles, to arrays (..., n, 3)."""

    @cached_property
    def axes(self) -> Axes:
        """The range of the settings: limits, steps and zones, and what follows from them."""
        return Axes(self.settings, self.zones)

    def pull(self, settings: Array, gradient: Stimulus) -> Array:
        """From a gradient with respect to the stimulus, (..., n, 3), to the settings, (..., n, d)."""
        derivative = dict(self.derivative(settings).quantities())
        total = np.zeros(settings.shape)
        for name, feels in gradient.quantities():
            total += (feels[..., None, :] @ derivative[name])[..., 0, :]
        return total

    def derivative(self, settings: Array) -> Stimulus:
        """Derivatives of the stimulus with respect to the settings, arrays (..., n, 3, d).

        The default differentiates `stimulus` numerically, by central differences.
        """
        step = 1e-5
        columns: dict[str, list[Array]] = {}
        for k in range(settings.shape[-1]):
            shift = np.zeros(settings.shape[-1])
            shift[k] = step
            above, below = self.stimulus(settings + shift), self.stimulus(settings - shift)
            for (name, plus), (_, minus) in zip(above.quantities(), below.quantities(), strict=True):
                columns.setdefault(name, []).append((plus - minus) / (2 * step))
        return Stimulus(**{name: np.stack(arrays, axis=-1) for name, arrays in columns.items()})

    @property
    def speeds(self) -> Array:
        """How fast each setting changes, (d,), in its unit per second, infinite where that takes no time.

        The default is 10 degrees per second.
        """
        return np.full(len(self.settings), math.radians(10.0))

    def equivalents(self, settings: Array) -> Array:
        """Settings for the same stimulus that the stand can take, (k, n, d), those given (n, d) first.

        Where there are fewer for a position, the given ones again. The default knows no others.
        """
        return settings[None]

    @property
    def axis_errors(self) -> tuple[str, ...]:
        """Names of the e small angles by which the stand's axes may be off; none."""
        return ()

    def misaligned(self, settings: Array, errors: Array) -> Stimulus:
        """What the sensor feels where the axes are off by angles (..., n, e) in rad; a new stand may say how."""
        return self.stimulus(settings)

    def aim(self, directions: Array) -> Array:
        """Settings (..., n, d) that bring the vertical to these directions (..., n, 3) of the sensor.

        Raises
        ------
        CompatibilityError
            Where the stand does not say how; the default.
        """
        raise CompatibilityError(f"{type(self).__name__} can't be aimed at directions: give its angles instead")

    def either(self, first: Array, second: Array, *, free: np.ndarray) -> Array:
        """Of two settings (..., n, 2) for the same direction, angles both, the first that the limits allow.

        Parameters
        ----------
        first, second : array (..., n, 2), in rad
        free : array (..., n) of bool
            Where the second angle does not matter.
        """
        inner = self.settings[1]
        any_angle = min(max(0.0, inner.lower), inner.upper) if inner.step is None else inner.stops()[0]
        for angles in (first, second):
            for k, setting in enumerate(self.settings):
                angles[..., k] = setting.reach(angles[..., k])
            angles[..., 1] = np.where(free & ~inner.allows(angles[..., 1]), any_angle, angles[..., 1])
        use_second = self.axes.allows(second) & ~self.axes.allows(first)
        return np.where(use_second[..., None], second, first)

    @property
    def zones(self) -> tuple[Zone, ...]:
        """Forbidden zones; none."""
        return ()

    @property
    def frequencies(self) -> tuple[int, ...] | None:
        """Degree of the stimulus as a trigonometric polynomial in each setting; None if unknown."""
        return None

    def advice(self, quantity: str) -> str:
        """What to add to the message that the stand does not provide a quantity of the stimulus."""
        return ""

    @property
    def circumstances(self) -> str:
        """Options other than limits and steps on which it depends what can be estimated, for messages."""
        return ""
