"""The range of a stand's settings: limits, steps, forbidden zones; the same for all stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from acalx.errors import ArgumentError, CompatibilityError
from acalx.numerics.arrays import Array
from acalx.stands.grid import Grid, grid_over
from acalx.stands.setting import Setting
from acalx.stands.zones import Zone

__all__ = ["Axes"]

# So many random settings are drawn, so many times, before a stand counts as forbidden everywhere.
_DRAWN = 64
_MOST_DRAWS = 200
# Ranges of settings that are no angles, in SI units, beside which a radian is neither much nor little.
_SMALL, _LARGE = 0.05, 500.0


@dataclass(frozen=True)
class Axes:
    """All that a stand can be set to.

    Parameters
    ----------
    settings : tuple of Setting, length d
    zones : tuple of Zone
        What of it must not be taken.
    stand : str
        What the stand is called in messages.
    """

    settings: tuple[Setting, ...]
    zones: tuple[Zone, ...] = ()
    stand: str = ""

    def __len__(self) -> int:
        return len(self.settings)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the settings."""
        return tuple(setting.name for setting in self.settings)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the settings with their units, as in files."""
        return tuple(setting.column for setting in self.settings)

    def written(self, settings: Array) -> Array:
        """Settings (..., d) in the units that people read."""
        return np.stack([s.unit.write(settings[..., k]) for k, s in enumerate(self.settings)], axis=-1)

    def read(self, values: Array) -> Array:
        """Settings (..., d) from the units that people write."""
        return np.stack([s.unit.read(values[..., k]) for k, s in enumerate(self.settings)], axis=-1)

    @property
    def bounds(self) -> Array:
        """Lower and upper limits of the settings, (d, 2)."""
        return np.array([(setting.lower, setting.upper) for setting in self.settings])

    @cached_property
    def sizes(self) -> Array:
        """What is about as much of each setting, (d,), a power of two: 1 unless its range is far from that."""
        ranges = np.array([1.0 if setting.angle else setting.upper - setting.lower for setting in self.settings])
        far = (ranges > 0.0) & ((ranges < _SMALL) | (ranges > _LARGE))
        return np.where(far, 2.0 ** np.round(np.log2(np.where(far, ranges, 1.0))), 1.0)

    @property
    def free_bounds(self) -> Array:
        """The limits (d, 2), infinite where every angle can be set."""
        open_ = np.array([setting.full_turn for setting in self.settings])[:, None]
        return np.where(open_, np.array([-np.inf, np.inf]), self.bounds)

    def divided(self, axis: int, count: int) -> Array:
        """So many values of a setting from limit to limit, and where boxes of forbidden zones begin and end between."""
        setting = self.settings[axis]
        regular = np.linspace(setting.lower, setting.upper, count)
        if not self.zones:
            return regular
        ends = np.array([end for zone in self.zones for end in zone.edges(axis)])
        if setting.periodic:
            ends = (ends[:, None] + 2.0 * np.pi * np.arange(-3, 4)).ravel()
        return np.union1d(regular, ends[(ends > setting.lower) & (ends < setting.upper)])

    def limits_around(self, settings: Array, hold: Sequence[bool] | None = None) -> tuple[Array, Array]:
        """Limits (..., d) around settings (..., d) between which every angle is allowed, in rad.

        Infinite where every angle can be set. Zones that are known as a function only are not
        left out.

        Parameters
        ----------
        settings : array (..., d), in rad
        hold : sequence of bool, length d, optional
            Settings that stay where they are; those with steps unless it is given.
        """
        lower, upper = (np.broadcast_to(bound, settings.shape).copy() for bound in self.free_bounds.T)
        for zone in self.zones:
            zone.narrow(settings, lower, upper)
        held = [setting.step is not None for setting in self.settings] if hold is None else hold
        return np.where(held, settings, lower), np.where(held, settings, upper)

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
        return np.asarray(np.logical_and.reduce([*each, ~self.forbids(settings)]))

    def forbids(self, settings: Array, clearance: bool = False) -> np.ndarray:
        """Which positions (..., n) are in a forbidden zone, or with a clearance so close that rounding may do it."""
        forbidden = np.zeros(settings.shape[:-1], dtype=bool)
        for zone in self.zones:
            forbidden |= zone.near(settings) if clearance else zone.holds(settings)
        return forbidden

    def random(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        """Random positions, each setting uniform over its limits or stops: (*shape, d) in rad.

        Raises
        ------
        CompatibilityError
            Where forbidden zones leave nothing that could be found.
        """
        settings = self._anywhere(rng, shape)
        forbidden = self.forbids(settings, clearance=True) if self.zones else np.zeros(shape, dtype=bool)
        for _ in range(_MOST_DRAWS):
            if not forbidden.any():
                return settings
            drawn = self._anywhere(rng, (int(forbidden.sum()), _DRAWN))
            wrong = self.forbids(drawn, clearance=True)
            first = wrong.argmin(axis=1)  # the first that is allowed
            settings[forbidden] = drawn[range(len(drawn)), first]
            forbidden[forbidden] = wrong[range(len(drawn)), first]
        raise CompatibilityError(
            f"the forbidden zones of stand {self.stand} leave next to nothing of its range: "
            "make them smaller, or the limits wider"
        )

    def candidates(self, size: int, kind: str, rng: np.random.Generator) -> Array | Grid:
        """About so many positions, indexed like an array (N, d) in rad.

        Some of a grid may be in forbidden zones.

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
            raise ArgumentError.of("kind", kind, "candidates are structured or random")
        return self.random(rng, (size,))

    def _anywhere(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        columns = [
            rng.uniform(s.lower, s.upper, shape) if s.step is None else rng.choice(s.stops(), shape)
            for s in self.settings
        ]
        return np.stack(columns, axis=-1)
