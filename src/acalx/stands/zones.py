"""Forbidden zones: settings that a stand could take but must not."""

from __future__ import annotations

import importlib
import inspect
import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from acalx.errors import ArgumentError, Option, PluginError
from acalx.numerics.arrays import Array
from acalx.stands.setting import Setting

__all__ = ["Box", "Custom", "Zone", "read_zones"]

_TURN = 2.0 * math.pi
# The edge of a box is allowed, also after angles went through degrees and back.
_SLACK = 1e-9
# A cell counts as covered by a function's zone where so many points a side all are in it.
_SAMPLES = 5
# Searches stay so far from the edge of a function's zone, in rad: angles are written with finite digits.
_CLEARANCE = 1e-7
# Half the width of a box over the edge that two boxes share, and how far one reaches beyond the limits, in rad.
_SEAM = 1e-6


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
        """Inside every interval."""
        inside = np.ones(settings.shape[:-1], dtype=bool)
        for k in self._bounded:
            past = self._past(settings[..., k], k)
            inside &= (past > _SLACK) & (past < self.upper[k] - self.lower[k] - _SLACK)
        return inside

    def covers(self, centers: Array, half: Array) -> np.ndarray:
        """Inside every interval with all of their width."""
        inside = np.ones(len(centers), dtype=bool)
        for k in self._bounded:
            past = self._past(centers[:, k] - half[:, k] + _SLACK, k) - _SLACK
            inside &= (past >= -_SLACK) & (past + 2.0 * half[:, k] <= self.upper[k] - self.lower[k] + _SLACK)
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
                after = settings[..., k] >= self.upper[k] - _SLACK
                low, high = np.where(after, low, -np.inf), np.where(after, np.inf, high)
            lower[..., k] = np.where(cut, np.maximum(lower[..., k], low), lower[..., k])
            upper[..., k] = np.where(cut, np.minimum(upper[..., k], high), upper[..., k])

    @property
    def _bounded(self) -> list[int]:
        return [k for k, low in enumerate(self.lower) if math.isfinite(low)]

    def _past(self, angles: Array, k: int) -> Array:
        """How far angles are past the beginning of the interval, within a turn where they are periodic."""
        past = angles - self.lower[k]
        return np.mod(past, _TURN) if self.periodic[k] else past

    def _gaps(self, angles: Array, k: int) -> Array:
        """Way back to the end of the interval and on to its next beginning, (..., 2); 0 at least."""
        width = self.upper[k] - self.lower[k]
        past = angles - self.lower[k]
        if self.periodic[k]:
            past = np.mod(past, _TURN)
            past = np.where(past < _SLACK, past + _TURN, past)  # at the beginning: it lies ahead
            return np.maximum(np.stack([past - width, _TURN - past], axis=-1), 0.0)
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
        """Ask the function."""
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


def read_zones(settings: Sequence[Setting], forbidden: object, forbidden_if: object) -> tuple[Zone, ...]:
    """Zones from what a configuration says.

    Parameters
    ----------
    settings : sequence of Setting
    forbidden : sequence of mappings from columns, ``alpha1_deg``, to (lower, upper) in their unit, or None
        Boxes; a setting that is left out may have any angle.
    forbidden_if : str, callable or None
        A function, or where it is, ``module.function``.

    Raises
    ------
    ArgumentError
        What is not understood, with an example.
    """
    zones: list[Zone] = []
    if forbidden is not None:
        if not isinstance(forbidden, Sequence) or isinstance(forbidden, str):
            raise ArgumentError(
                "{given}: give a list of boxes, as in {example}",
                given=f"forbidden={forbidden!r}",
                example=_example(settings),
            )
        boxes = [_box(box, settings) for box in forbidden]
        zones += [*boxes, *_seams(boxes)]
    if forbidden_if is not None:
        columns = [setting.column for setting in settings]
        zones.append(Custom(_function(forbidden_if, columns), tuple(settings), _label(forbidden_if)))
    return tuple(zones)


def _box(box: object, settings: Sequence[Setting]) -> Box:
    columns = [setting.column for setting in settings]
    if not isinstance(box, Mapping) or not box:
        raise ArgumentError(
            "forbidden: {box!r} is not a box; give one as in {example}", box=box, example=_example(settings)
        )
    lower, upper = [-math.inf] * len(settings), [math.inf] * len(settings)
    for name, interval in box.items():
        if name not in columns:
            raise ArgumentError(f"forbidden: the stand has no {name}; it has {', '.join(columns)}")
        k = columns.index(name)
        unit, periodic = settings[k].unit, settings[k].periodic
        if not (isinstance(interval, Sequence) and len(interval) == 2 and all(map(_is_number, interval))):
            raise ArgumentError(f"forbidden: {name}={interval!r}: give a lower and an upper end in {unit.plural}")
        low, high = (float(unit.read(end)) for end in interval)
        if low >= high:
            raise ArgumentError(
                f"forbidden: {name}=[{interval[0]:g},{interval[1]:g}]: the lower end must be below the upper one"
                + ("; across 0 degrees write it as [350,370]" if periodic else "")
            )
        if not (periodic and high - low >= _TURN):  # all of a turn does not matter
            lower[k], upper[k] = _past_limits(settings[k], low, high)
    return Box(tuple(lower), tuple(upper), tuple(setting.periodic for setting in settings))


def _past_limits(setting: Setting, low: float, high: float) -> tuple[float, float]:
    """An interval that ends at a limit ends beyond it: else the limit alone would be allowed."""
    if setting.full_turn:
        return low, high
    turns = _TURN * np.arange(-2, 3) if setting.periodic else np.zeros(1)
    if (np.abs(low + turns - setting.lower) < _SLACK).any():
        low -= _SEAM
    if (np.abs(high + turns - setting.upper) < _SLACK).any():
        high += _SEAM
    return low, high


def _seams(boxes: Sequence[Box]) -> list[Box]:
    """Thin boxes over the edges that two boxes share: else the edge between them would be allowed."""
    seams = []
    for one, other in itertools.permutations(boxes, 2):
        for k in range(len(one.lower)):
            turns = _TURN * np.arange(-2, 3) if one.periodic[k] else np.zeros(1)
            if not (np.abs(one.upper[k] - other.lower[k] + turns) < _SLACK).any():
                continue
            # shared by both in the other settings, a turn apart perhaps
            low, high = list(np.maximum(one.lower, other.lower)), list(np.minimum(one.upper, other.upper))
            low[k], high[k] = one.upper[k] - _SEAM, one.upper[k] + _SEAM
            if all(a < b for a, b in zip(low, high, strict=True)):
                seams.append(Box(tuple(map(float, low)), tuple(map(float, high)), one.periodic))
    return seams


def _signs(d: int) -> tuple[Array, Array]:
    return np.eye(d), -np.eye(d)


def _function(given: object, names: Sequence[str]) -> Callable[..., Any]:
    label = _label(given)
    if isinstance(given, str):
        module, _, attribute = given.rpartition(".")
        try:
            given = getattr(importlib.import_module(module), attribute)
        except (ImportError, AttributeError, ValueError) as error:
            raise ArgumentError(
                f"forbidden_if={given}: can't be imported ({error}); give module.function of a module on your path"
            ) from error
    if not callable(given):
        raise ArgumentError(f"forbidden_if={given!r}: give a function, or module.function of a module on your path")
    try:
        inspect.signature(given).bind(**dict.fromkeys(names))
    except TypeError as error:
        raise ArgumentError(f"forbidden_if={label}: must take {', '.join(names)} ({error})") from error
    return given


def _label(function: object) -> str:
    return function if isinstance(function, str) else getattr(function, "__name__", repr(function))


def _example(settings: Sequence[Setting]) -> Option:
    box = dict(zip((setting.column for setting in settings), ([80, 100], [170, 190]), strict=False))
    return Option("forbidden", [box], str([{column: tuple(interval) for column, interval in box.items()}]))


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
