"""Forbidden zones as options give them: boxes by the names of settings, and functions of the user's."""

from __future__ import annotations

import importlib
import inspect
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from acalx.errors import ArgumentError, Option
from acalx.options import is_number
from acalx.stands.setting import Setting
from acalx.stands.zones import SLACK, TURN, Box, Custom, Zone

__all__ = ["read_zones"]

# Half the width of a box over the edge that two boxes share, and how far one reaches beyond the limits, in rad.
_SEAM = 1e-6


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
                given=Option("forbidden", forbidden),
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
            "{given}: not a box; give one as in {example}", given=Option("forbidden", [box]), example=_example(settings)
        )
    lower, upper = [-math.inf] * len(settings), [math.inf] * len(settings)
    for name, interval in box.items():
        if name not in columns:
            raise ArgumentError.of("forbidden", [box], f"the stand has no {name}; it has {', '.join(columns)}")
        k = columns.index(name)
        unit, periodic = settings[k].unit, settings[k].periodic
        if not (isinstance(interval, Sequence) and len(interval) == 2 and all(map(is_number, interval))):
            raise ArgumentError.of("forbidden", [box], f"give a lower and an upper end of {name} in {unit.plural}")
        low, high = (float(unit.read(end)) for end in interval)
        if low >= high:
            across = "; across 0 degrees write it as [350,370]" if periodic else ""
            raise ArgumentError.of("forbidden", [box], f"the lower end of {name} must be below the upper one{across}")
        if not (periodic and high - low >= TURN):  # all of a turn does not matter
            lower[k], upper[k] = _past_limits(settings[k], low, high)
    return Box(tuple(lower), tuple(upper), tuple(setting.periodic for setting in settings))


def _past_limits(setting: Setting, low: float, high: float) -> tuple[float, float]:
    """An interval that ends at a limit ends beyond it: else the limit alone would be allowed."""
    if setting.full_turn:
        return low, high
    turns = TURN * np.arange(-2, 3) if setting.periodic else np.zeros(1)
    if (np.abs(low + turns - setting.lower) < SLACK).any():
        low -= _SEAM
    if (np.abs(high + turns - setting.upper) < SLACK).any():
        high += _SEAM
    return low, high


def _seams(boxes: Sequence[Box]) -> list[Box]:
    """Thin boxes over the edges that two boxes share: else the edge between them would be allowed."""
    seams = []
    for one, other in itertools.permutations(boxes, 2):
        for k in range(len(one.lower)):
            turns = TURN * np.arange(-2, 3) if one.periodic[k] else np.zeros(1)
            if not (np.abs(one.upper[k] - other.lower[k] + turns) < SLACK).any():
                continue
            # shared by both in the other settings, a turn apart perhaps
            low, high = list(np.maximum(one.lower, other.lower)), list(np.minimum(one.upper, other.upper))
            low[k], high[k] = one.upper[k] - _SEAM, one.upper[k] + _SEAM
            if all(a < b for a, b in zip(low, high, strict=True)):
                seams.append(Box(tuple(map(float, low)), tuple(map(float, high)), one.periodic))
    return seams


def _function(given: object, names: Sequence[str]) -> Callable[..., Any]:
    label = _label(given)
    if isinstance(given, str):
        module, _, attribute = given.rpartition(".")
        try:
            given = getattr(importlib.import_module(module), attribute)
        except (ImportError, AttributeError, ValueError) as error:
            raise ArgumentError.of(
                "forbidden_if", given, f"can't be imported ({error}); give module.function of a module on your path"
            ) from error
    if not callable(given):
        raise ArgumentError.of("forbidden_if", given, "give a function, or module.function of a module on your path")
    try:
        inspect.signature(given).bind(**dict.fromkeys(names))
    except TypeError as error:
        raise ArgumentError.of("forbidden_if", label, f"must take {', '.join(names)} ({error})") from error
    return given


def _label(function: object) -> str:
    return function if isinstance(function, str) else getattr(function, "__name__", repr(function))


def _example(settings: Sequence[Setting]) -> Option:
    box = dict(zip((setting.column for setting in settings), ([80, 100], [170, 190]), strict=False))
    return Option("forbidden", [box], str([{column: tuple(interval) for column, interval in box.items()}]))
