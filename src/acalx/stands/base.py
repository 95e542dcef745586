"""The interface of a stand: what turns the sensor, and within which limits."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from acalx.arrays import Array
from acalx.errors import ArgumentError, CompatibilityError
from acalx.stands.grid import Grid, grid_over
from acalx.stands.setting import Setting
from acalx.stimulus import Stimulus

__all__ = ["Setting", "Stand"]


class Stand(ABC):
    """What turns the sensor: settings in, stimulus out.

    A new stand gives `settings` and `stimulus`; the derivative is then numerical until it is
    given exactly. Concrete stands are frozen dataclasses.
    """

    @property
    @abstractmethod
    def settings(self) -> tuple[Setting, ...]:
        """The d angles that set a position, with their limits."""

    @abstractmethod
    def stimulus(self, settings: Array) -> Stimulus:
        """What the sensor feels: settings (..., n, d) in rad to arrays (..., n, 3)."""

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

    def aim(self, directions: Array) -> Array:
        """Settings (..., n, d) that bring the vertical to these directions (..., n, 3) of the sensor.

        Raises
        ------
        CompatibilityError
            Where the stand does not say how; the default.
        """
        raise CompatibilityError(f"{type(self).__name__} can't be aimed at directions: give its angles instead")

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the settings."""
        return tuple(setting.name for setting in self.settings)

    @property
    def bounds(self) -> Array:
        """Lower and upper limits of the settings, (d, 2) in rad."""
        return np.array([(setting.lower, setting.upper) for setting in self.settings])

    @property
    def free_bounds(self) -> Array:
        """The limits (d, 2), infinite where every angle can be set."""
        open_ = np.array([setting.full_turn for setting in self.settings])[:, None]
        return np.where(open_, np.array([-np.inf, np.inf]), self.bounds)

    @property
    def frequencies(self) -> tuple[int, ...] | None:
        """Degree of the stimulus as a trigonometric polynomial in each setting; None if unknown."""
        return None

    @property
    def stepped(self) -> bool:
        """Whether any of the settings stops at steps only."""
        return any(setting.step is not None for setting in self.settings)

    def wrap(self, settings: Array) -> Array:
        """The same positions with whole turns taken off."""
        return np.stack([s.wrap(settings[..., k]) for k, s in enumerate(self.settings)], axis=-1)

    def allows(self, settings: Array, tolerance: float = 1e-9) -> np.ndarray:
        """Which positions (..., n) the stand can take, within a tolerance in rad."""
        each = [s.allows(settings[..., k], tolerance) for k, s in enumerate(self.settings)]
        return np.asarray(np.logical_and.reduce(each))

    def candidates(self, size: int, kind: str, rng: np.random.Generator) -> Array | Grid:
        """About so many positions, indexed like an array (N, d) in rad.

        Parameters
        ----------
        size : int
        kind : str
            ``structured``: a grid over the limits, which is computed where it is read;
            ``random``: as `random` gives them.
        rng : numpy Generator
        """
        if kind == "structured":
            return grid_over(self.settings, size)
        if kind != "random":
            raise ArgumentError(f"kind={kind}: candidates are structured or random")
        return self.random(rng, (size,))

    def random(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        """Random positions, each setting uniform over its limits or stops: (*shape, d) in rad."""
        columns = [
            rng.uniform(s.lower, s.upper, shape) if s.step is None else rng.choice(s.stops(), shape)
            for s in self.settings
        ]
        return np.stack(columns, axis=-1)
