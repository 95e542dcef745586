"""The interface of a stand: what turns the sensor, and within which limits."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acalx.arrays import Array
from acalx.errors import ArgumentError, CompatibilityError
from acalx.stands.zones import Zone
from acalx.stimulus import Stimulus
from acalx.units import DEGREE, Unit

__all__ = ["Setting", "Stand"]

_TURN = 2.0 * math.pi
# Relative slack when comparing angles that went through degrees and back.
_SLACK = 1e-9
# So many random settings are drawn, so many times, before a stand counts as forbidden everywhere.
_DRAWN = 64
_MOST_DRAWS = 200


@dataclass(frozen=True)
class Setting:
    """One adjustable angle of a stand, or a rate or another quantity that it can set.

    Parameters
    ----------
    name : str
        Its name; files and the command line add the unit, ``alpha1`` is ``alpha1_deg`` there.
    lower, upper : float, in rad or the SI unit of what is set
        Limits, both allowed.
    step : float, in the same unit, optional
        Resolution: the setting stops at whole multiples of it only. None: anywhere.
    periodic : bool
        Whether a full turn more is the same position; for angles only.
    unit : Unit
        What people read and write it in; degrees for an angle.
    """

    name: str
    lower: float
    upper: float
    step: float | None = None
    periodic: bool = True
    unit: Unit = DEGREE

    def __post_init__(self) -> None:
        for name, value in (("lower", self.lower), ("upper", self.upper), ("step", self.step or 0.0)):
            if not isinstance(value, (int, float)):
                raise ArgumentError(f"{self.name}: {name}={value!r}: must be a number, in rad")
        if not isinstance(self.periodic, bool):
            raise ArgumentError(f"{self.name}: periodic={self.periodic!r}: must be true or false")
        if self.periodic and self.unit.turn is None:
            raise ArgumentError(f"{self.column}: only an angle is periodic, not what is in {self.unit.plural}")
        if not (math.isfinite(self.lower) and math.isfinite(self.upper)):
            raise ArgumentError(f"{self.limits}: bounds must be finite numbers of {self.unit.plural}")
        if self.lower >= self.upper:
            raise ArgumentError(f"{self.limits}: the lower bound must be below the upper one")
        if self.periodic and self.upper - self.lower > _TURN * (1 + _SLACK):
            raise ArgumentError(f"{self.limits}: a periodic angle spans 360 degrees at most")
        if self.step is not None:
            step = f"{self.step / self.unit.size:g}"
            if not (math.isfinite(self.step) and self.step > 0):
                raise ArgumentError(
                    f"{self.unit.column('step')}={step}: a step must be a positive number of {self.unit.plural}"
                )
            if not self.full_turn and math.floor(self._last) < math.ceil(self._first):
                raise ArgumentError(f"{self.limits} holds no multiple of the step of {step} {self.unit.plural}")

    @property
    def column(self) -> str:
        """Its name with the unit, as in files and on the command line."""
        return self.unit.column(self.name)

    @property
    def limits(self) -> str:
        """Its limits as on the command line."""
        return f"{self.column}=[{self.lower / self.unit.size:g}, {self.upper / self.unit.size:g}]"

    @property
    def full_turn(self) -> bool:
        """Whether every angle can be set, so that the limits are no limits."""
        return self.periodic and self.upper - self.lower >= _TURN * (1 - _SLACK)

    @property
    def _first(self) -> float:
        assert self.step is not None
        return self.lower / self.step * (1 - math.copysign(_SLACK, self.lower))

    @property
    def _last(self) -> float:
        assert self.step is not None
        return self.upper / self.step * (1 + math.copysign(_SLACK, self.upper))

    def stops(self) -> Array:
        """All that a stepped setting can take, in rad or the SI unit, ascending."""
        if self.step is None:
            raise CompatibilityError(f"{self.name} has no steps: it stops anywhere")
        stops = np.arange(math.ceil(self._first), math.floor(self._last) + 1) * self.step
        if self.full_turn and len(stops) > 1:
            stops = stops[stops < stops[0] + _TURN * (1 - _SLACK)]
        return np.clip(stops, self.lower, self.upper)

    def nearest(self, angles: Array) -> Array:
        """The stop of a stepped setting that is nearest to each angle."""
        stops = self.stops()
        middle = 0.5 * (stops[0] + stops[-1])
        if self.periodic:
            angles = angles - _TURN * np.round((angles - middle) / _TURN)
        index = np.clip(np.searchsorted(stops, angles), 1, max(1, len(stops) - 1))
        below, above = stops[index - 1], stops[np.minimum(index, len(stops) - 1)]
        return np.where(angles - below < above - angles, below, above)

    def wrap(self, angles: Array) -> Array:
        """The same positions with whole turns taken off, inside the limits where that is possible."""
        if not self.periodic:
            return angles
        middle = 0.5 * (self.lower + self.upper)
        wrapped = np.where(
            (angles < self.lower) | (angles > self.upper),
            angles - _TURN * np.round((angles - middle) / _TURN),
            angles,
        )
        return np.clip(wrapped, self.lower, self.upper) if self.full_turn else wrapped

    def reach(self, angles: Array) -> Array:
        """The same attitudes with whole turns added so that they are within the limits, where some are."""
        turns = np.ceil((self.lower - angles) / _TURN - _SLACK)
        inside = angles + _TURN * turns
        return np.where(inside <= self.upper * (1 + math.copysign(_SLACK, self.upper)), inside, angles)

    def allows(self, angles: Array, tolerance: float = 1e-9) -> np.ndarray:
        """Whether angles are within the limits and on a step, within a tolerance in rad."""
        wrapped = self.wrap(angles)
        inside = (wrapped >= self.lower - tolerance) & (wrapped <= self.upper + tolerance)
        if self.step is None:
            return inside
        return np.asarray(inside & (np.abs(wrapped - self.step * np.round(wrapped / self.step)) <= tolerance))


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
        use_second = self.allows(second) & ~self.allows(first)
        return np.where(use_second[..., None], second, first)

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

    @property
    def free_bounds(self) -> Array:
        """The limits (d, 2), infinite where every angle can be set."""
        open_ = np.array([setting.full_turn for setting in self.settings])[:, None]
        return np.where(open_, np.array([-np.inf, np.inf]), self.bounds)

    @property
    def zones(self) -> tuple[Zone, ...]:
        """Forbidden zones; none."""
        return ()

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

    def forbids(self, settings: Array) -> np.ndarray:
        """Which positions (..., n) are in a forbidden zone."""
        forbidden = np.zeros(settings.shape[:-1], dtype=bool)
        for zone in self.zones:
            forbidden |= zone.holds(settings)
        return forbidden

    def random(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        """Random positions, each setting uniform over its limits or stops: (*shape, d) in rad.

        Raises
        ------
        CompatibilityError
            Where forbidden zones leave nothing that could be found.
        """
        settings = self._anywhere(rng, shape)
        forbidden = self.forbids(settings) if self.zones else np.zeros(shape, dtype=bool)
        for _ in range(_MOST_DRAWS):
            if not forbidden.any():
                return settings
            drawn = self._anywhere(rng, (int(forbidden.sum()), _DRAWN))
            wrong = self.forbids(drawn)
            first = wrong.argmin(axis=1)  # the first that is allowed
            settings[forbidden] = drawn[range(len(drawn)), first]
            forbidden[forbidden] = wrong[range(len(drawn)), first]
        raise CompatibilityError(
            f"the forbidden zones of stand {type(self).__name__} leave next to nothing of its range: "
            "make them smaller, or the limits of its angles wider"
        )

    def candidates(self, size: int) -> Array:
        """Allowed positions all over the range, (k, d) in rad: all the stops, or a grid.

        A setting without steps is divided so that the grid has about `size` points, zones apart.
        """
        free = [s for s in self.settings if s.step is None]
        stops = math.prod(len(s.stops()) for s in self.settings if s.step is not None)
        spans = math.prod(s.upper - s.lower for s in free)
        density = (size / stops / spans) ** (1.0 / max(1, len(free)))
        axes = [
            np.linspace(s.lower, s.upper, max(2, round((s.upper - s.lower) * density)), endpoint=not s.full_turn)
            if s.step is None
            else s.stops()
            for s in self.settings
        ]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
        return grid[~self.forbids(grid)] if self.zones else grid

    def _anywhere(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        columns = [
            rng.uniform(s.lower, s.upper, shape) if s.step is None else rng.choice(s.stops(), shape)
            for s in self.settings
        ]
        return np.stack(columns, axis=-1)
