"""Stands that turn the sensor about one axis after another."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from acalx.numerics.arrays import Array, sin_cos
from acalx.options import require_steps
from acalx.quantities.stimulus import Stimulus
from acalx.stands.base import Setting, Stand
from acalx.stands.fields import switch
from acalx.stands.turns import PLANES, Turn, Vector, derivatives, differentiated, turned, vectors

__all__ = ["Rotary"]

# Angles so close to 0 are 0, not a turn less a rounding error.
_ZERO = 1e-15
# The vertical counts as along the last axis where so much of it is across.
_ALONG = 1e-12


@dataclass(frozen=True, eq=False)
class Rotary(Stand):
    """A stand that turns the sensor about the axes that are told, the outer one first.

    At zero angles z is up. A turn about an axis takes the components u and v of what is felt, in
    sensor axes, to c u + s v and c v - s u, with the sine s and the cosine c of its angle and u, v
    = y, z about x, z, x about y, and x, y about z; about ``-y`` the other way. A new stand gives

    - `turns`, the names of its angles with the axes of the sensor that they turn about;
    - for each a field with its limits in degrees, ``alpha1_deg`` for ``alpha1``;
    - `surroundings`, the vectors that are felt at zero angles;
    - `installed`, where it is known what its axes may be off by.

    Settings, stimulus, its exact derivative, aiming and all the rest follow. One that has further settings behind the
    angles, or feels more, gives `settings` and `stimulus`; then its derivative is numerical and no bound is proved,
    until it gives `derivative` and `frequencies` too.

    Parameters
    ----------
    step_deg : float or sequence of float, degrees, optional
        Resolution, of all angles or of each: they stop at whole multiples of it. None: anywhere.
    periodic : bool
        Whether 360 degrees more is the same setting. Without it, angles are not wrapped, and
        limits may span more than a turn.

    Raises
    ------
    ArgumentError
        Limits the wrong way round or not finite, a step that is not positive, zones or speeds
        that are not understood.
    """

    turns: ClassVar[Mapping[str, str]]
    # the turns of a stand whose axes are off, those about its axes among them; by default none are known
    installed: ClassVar[Mapping[str, str]] = MappingProxyType({})
    _: KW_ONLY
    step_deg: float | Sequence[float | None] | None = None
    periodic: bool = switch(True)

    @property
    @abstractmethod
    def surroundings(self) -> Mapping[str, Vector]:
        """Vectors at zero angles, along x, y and up, None for zero, by the name of their quantity in the stimulus."""

    @cached_property
    def angles(self) -> tuple[Setting, ...]:
        """The angle about each axis."""
        steps = require_steps("step_deg", self.step_deg, len(self.turns))
        return tuple(
            Setting.in_unit(name, getattr(self, f"{name}_deg"), step, self.periodic)
            for name, step in zip(self.turns, steps, strict=True)
        )

    @property
    def settings(self) -> tuple[Setting, ...]:
        """The angles; a stand with further settings has them behind these."""
        return self.angles

    def turns_at(self, settings: Array) -> list[Turn]:
        """The turn about each axis, for settings (..., n, d)."""
        sin, cos = sin_cos(settings if settings.shape[-1] == len(self._planes) else settings[..., : len(self._planes)])
        return [(u, v, sin[..., k], cos[..., k]) for k, u, v in self._numbered]

    def stimulus(self, settings: Array) -> Stimulus:
        """The surroundings in sensor axes: settings (..., n, d) in rad to arrays (..., n, 3)."""
        turns, shape = self.turns_at(settings), settings.shape[:-1]
        return Stimulus({name: vectors(turned(felt, turns), shape) for name, felt in self.surroundings.items()})

    def derivative(self, settings: Array) -> Stimulus:
        """Its exact derivatives, arrays (..., n, 3, d); numerical of a stand that feels more than its surroundings."""
        return self.by_angles(settings) if self._plain else super().derivative(settings)

    def by_angles(self, settings: Array) -> Stimulus:
        """Exact derivatives of the surroundings in sensor axes by the angles, arrays (..., n, 3, angles)."""
        turns, shape = self.turns_at(settings), settings.shape[:-1]
        return Stimulus(
            {name: derivatives(differentiated(felt, turns)[1], shape) for name, felt in self.surroundings.items()}
        )

    @property
    def frequencies(self) -> tuple[int, ...] | None:
        """One in each angle; None, unknown, of a stand that feels more than its surroundings, unless it says more."""
        return (1,) * len(self.turns) if self._plain else None

    def aim(self, directions: Array) -> Array:
        """Settings for directions of the vertical in sensor axes, (..., n, 3) to (..., n, d), at rest.

        Two pairs of angles show the same vertical; it is the first that the limits allow. Settings
        that are no angles are at 0, or as near to it as they can be.

        Raises
        ------
        CompatibilityError
            Where it is not two axes that turn the sensor, the outer one level.
        """
        if not self._aimable:
            return super().aim(directions)
        (_, outer), (u, v) = self._planes
        kept = 3 - u - v  # the component that the inner turn leaves alone
        sign = 1.0 if outer == 2 else -1.0  # of the sine in the other one that the outer turn gives the vertical
        first, second = directions[..., u], directions[..., v]
        along, across = directions[..., kept], np.hypot(first, second)
        outer_angle = np.arctan2(sign * across, along) if kept == 2 else np.arctan2(sign * along, across)
        inner_angle = np.arctan2(-second, first) if v == self._outer_axis else np.arctan2(first, second)
        angles = np.stack([outer_angle, inner_angle], axis=-1)
        angles = np.where(np.abs(angles) < _ZERO, 0.0, angles)
        return self._either(angles, self._other(angles), free=across < _ALONG)

    def equivalents(self, settings: Array) -> Array:
        """The two pairs of angles that show the same vertical, where nothing else is felt; those given first."""
        if not self._aimable or any(x is not None or y is not None for x, y, _ in self.surroundings.values()):
            return settings[None]
        other = self._reached(np.concatenate([self._other(settings[..., :2]), settings[..., 2:]], axis=-1))
        return np.stack([settings, np.where(self.axes.allows(other)[..., None], other, settings)])

    @property
    def axis_errors(self) -> tuple[str, ...]:
        """The turns of `installed` that are about no axis of the stand."""
        return tuple(name for name in self.installed if name not in self.turns)

    def misaligned(self, settings: Array, errors: Array) -> Stimulus:
        """The surroundings after all the turns of `installed`, by errors (..., n, e) in rad and the angles."""
        if not self.installed:
            return self.stimulus(settings)
        names = (*self.turns, *self.axis_errors)
        sines = [sin_cos(part) for part in (settings[..., : len(self.turns)], errors)]
        known = dict(zip(names, ((s[..., k], c[..., k]) for s, c in sines for k in range(s.shape[-1])), strict=True))
        turns = [(*PLANES[axis], *known[name]) for name, axis in self.installed.items()]
        shape = np.broadcast_shapes(settings.shape[:-1], errors.shape[:-1])
        return Stimulus({name: vectors(turned(felt, turns), shape) for name, felt in self.surroundings.items()})

    @cached_property
    def _plain(self) -> bool:
        """Whether its angles are all that there is, and its surroundings all that is felt."""
        return type(self).stimulus is Rotary.stimulus and len(self.settings) == len(self.turns)

    @cached_property
    def _planes(self) -> tuple[tuple[int, int], ...]:
        return tuple(PLANES[axis] for axis in self.turns.values())

    @cached_property
    def _numbered(self) -> tuple[tuple[int, int, int], ...]:
        return tuple((k, u, v) for k, (u, v) in enumerate(self._planes))

    @property
    def _outer_axis(self) -> int:
        return 3 - sum(self._planes[0])

    @property
    def _aimable(self) -> bool:
        """Whether two turns bring the vertical to any direction."""
        return len(self._planes) == 2 and 2 in self._planes[0] and set(self._planes[0]) != set(self._planes[1])

    def _other(self, angles: Array) -> Array:
        """The other pair (..., 2) that shows the same vertical."""
        first, second = angles[..., 0], angles[..., 1]
        upright = 2 not in self._planes[1]  # the inner axis is, at zero angles
        return np.stack([-first if upright else math.pi - first, second + math.pi], axis=-1)

    def _reached(self, settings: Array) -> Array:
        """The same with whole turns added so that the angles are within their limits, where some are."""
        reached = settings.copy()
        for k, angle in enumerate(self.angles):
            reached[..., k] = angle.reach(settings[..., k])
        return reached

    def _either(self, first: Array, second: Array, *, free: np.ndarray) -> Array:
        """Of two pairs (..., n, 2) for the same direction the first that the limits allow, at rest: (..., n, d).

        Where `free` (..., n), the inner angle does not matter.
        """
        inner = self.angles[1]
        any_angle = inner.rest if inner.step is None else inner.stops()[0]
        further = [setting.rest for setting in self.settings[2:]]
        rest = np.broadcast_to(further, (*first.shape[:-1], len(further)))
        ways = [self._reached(np.concatenate([angles, rest], axis=-1)) for angles in (first, second)]
        for way in ways:
            way[..., 1] = np.where(free & ~inner.allows(way[..., 1]), any_angle, way[..., 1])
        use_second = self.axes.allows(ways[1]) & ~self.axes.allows(ways[0])
        return np.where(use_second[..., None], ways[1], ways[0])
