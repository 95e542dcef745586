"""Forbidden zones: settings that a stand could take but must not."""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from acalx.errors import PluginError
from acalx.numerics.arrays import Array
from acalx.stands.setting import Setting

__all__ = ["SLACK", "TURN", "Box", "Custom", "Zone"]

TURN = 2.0 * math.pi
# The edge of a box is allowed, also after angles went through degrees and back.
SLACK = 1e-9
# A cell counts as covered by a function's zone where so many points a side all are in it.
_SAMPLES = 5
# Searches stay so far from the edge of a function's zone, in rad: angles are written with finite digits.
_CLEARANCE = 1e-7


class Zone(ABC):
    """Part of the range of a stand's settings that is forbidden."""

    @property
    def exact(self) -> bool:
        """Whether `covers` is certain, not only sampled."""
        return True

    @abstractmethod
    def holds(self, settings: Array) -> np.ndarray:
        """Whether settings (..., d) in rad are in the zone, (...)."""

    def near(self, settings: Array) -> np.ndarray:
        """Whether settings (..., d) are in the zone or so close that rounding may put them there."""
        return self.holds(settings)

    @abstractmethod
    def covers(self, centers: Array, half: Array) -> np.ndarray:
        """Whether whole cells are in the zone: centers and half widths (k, d) in rad to (k,)."""

    def edges(self, axis: int) -> list[float]:
        """Angles in rad at which the zone begins or ends along one setting, where it is a box."""
        return []

    def narrow(self, settings: Array, lower: Array, upper: Array) -> None:  # noqa: B027 - not every zone can be
        """Move limits (..., d) in towards settings (..., d), in place, so that they leave the zone out.

        Where the zone can't be left out by limits they stay as they are.
        """


@final
@dataclass(frozen=True)
class Box(Zone):
    """All settings inside an interval of each of some settings; the edge itself is allowed.

    Parameters
    ----------
    lower, upper : tuple of float, length d, in rad
        Infinite for a setting that does not matter.
    periodic : tuple of bool, length d
        Whether a full turn more is the same setting.
    """

    lower: tuple[float, ...]
    upper: tuple[float, ...]
    periodic: tuple[bool, ...]

    def holds(self, settings: Array) -> np.ndarray:
        """Whether settings (..., d) are inside every interval, (...)."""
        inside = np.ones(settings.shape[:-1], dtype=bool)
        for k in self._bounded:
            past = self._past(settings[..., k], k)
            inside &= (past > SLACK) & (past < self.upper[k] - self.lower[k] - SLACK)
        return inside

    def covers(self, centers: Array, half: Array) -> np.ndarray:
        """Inside every interval with all of their width."""
        inside = np.ones(len(centers), dtype=bool)
        for k in self._bounded:
            past = self._past(centers[:, k] - half[:, k] + SLACK, k) - SLACK
            inside &= (past >= -SLACK) & (past + 2.0 * half[:, k] <= self.upper[k] - self.lower[k] + SLACK)
        return inside

    def edges(self, axis: int) -> list[float]:
        """Both ends of the interval."""
        return [self.lower[axis], self.upper[axis]] if axis in self._bounded else []

    def narrow(self, settings: Array, lower: Array, upper: Array) -> None:
        """Cut along the setting in which the zone is farthest away."""
        if not self._bounded:
            return
        gaps = np.stack([self._gaps(settings[..., k], k) for k in self._bounded], axis=-1)  # (..., 2, bounded)
        apart = gaps.min(axis=-2).argmax(axis=-1)
        for j, k in enumerate(self._bounded):
            cut = apart == j
            below, above = gaps[..., 0, j], gaps[..., 1, j]
            low, high = settings[..., k] - below, settings[..., k] + above
            if not self.periodic[k]:  # the zone lies on one side only
                after = settings[..., k] >= self.upper[k] - SLACK
                low, high = np.where(after, low, -np.inf), np.where(after, np.inf, high)
            lower[..., k] = np.where(cut, np.maximum(lower[..., k], low), lower[..., k])
            upper[..., k] = np.where(cut, np.minimum(upper[..., k], high), upper[..., k])

    @property
    def _bounded(self) -> list[int]:
        return [k for k, low in enumerate(self.lower) if math.isfinite(low)]

    def _past(self, angles: Array, k: int) -> Array:
        """How far angles are past the beginning of the interval, within a turn where they are periodic."""
        past = angles - self.lower[k]
        return np.mod(past, TURN) if self.periodic[k] else past

    def _gaps(self, angles: Array, k: int) -> Array:
        """Way back to the end of the interval and on to its next beginning, (..., 2); 0 at least."""
        width = self.upper[k] - self.lower[k]
        past = angles - self.lower[k]
        if self.periodic[k]:
            past = np.mod(past, TURN)
            past = np.where(past < SLACK, past + TURN, past)  # at the beginning: it lies ahead
            return np.maximum(np.stack([past - width, TURN - past], axis=-1), 0.0)
        ahead, behind = np.maximum(-past, 0.0), np.maximum(past - width, 0.0)
        gap = np.maximum(ahead, behind)
        return np.stack([gap, gap], axis=-1)


@final
@dataclass(frozen=True)
class Custom(Zone):
    """Wherever a function of the user's says so.

    Parameters
    ----------
    function : callable
        Takes one array for each setting in its unit, by the name that its column of a program
        has (``alpha1_deg=...``), all of one shape; returns booleans of that shape.
    settings : tuple of Setting
    label : str
        What the user calls it.
    """

    function: Callable[..., Any]
    settings: tuple[Setting, ...]
    label: str

    @property
    def exact(self) -> bool:
        """No: it is known only where it was asked."""
        return False

    def holds(self, settings: Array) -> np.ndarray:
        """What the function says of settings (..., d), within their limits, (...)."""
        # within the limits, as a program has them
        given = {s.column: s.unit.write(s.wrap(settings[..., k])) for k, s in enumerate(self.settings)}
        try:
            answer = np.asarray(self.function(**given))
        except Exception as error:
            raise PluginError(f"forbidden_if={self.label} raised {type(error).__name__}: {error}") from error
        if answer.dtype != bool or answer.shape != settings.shape[:-1]:
            raise PluginError(
                f"forbidden_if={self.label} returned {answer.dtype} of shape {answer.shape} for angles of shape "
                f"{settings.shape[:-1]}; expected as many booleans, true where a position is forbidden"
            )
        return answer

    def near(self, settings: Array) -> np.ndarray:
        """Where the function says so a little to any side."""
        shifts = _CLEARANCE * np.concatenate([np.zeros((1, len(self.settings))), *_signs(len(self.settings))])
        return np.asarray(self.holds(settings[..., None, :] + shifts).any(axis=-1))

    def covers(self, centers: Array, half: Array) -> np.ndarray:
        """Where the function says so at the corners of a cell and at points between."""
        offsets = np.array(list(itertools.product(np.linspace(-1.0, 1.0, _SAMPLES), repeat=centers.shape[-1])))
        return np.asarray(self.holds(centers[:, None, :] + offsets * half[:, None, :]).all(axis=-1))


def _signs(d: int) -> tuple[Array, Array]:
    return np.eye(d), -np.eye(d)
