"""The error parameters of a sensor."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

__all__ = ["Parameter", "parameter_groups"]


@dataclass(frozen=True)
class Parameter:
    """An error parameter of a sensor.

    Parameters
    ----------
    name : str
        Unique within the model, e.g. ``bias_x``.
    group : str
        Parameters of the same kind, compared with each other, e.g. ``bias``.
    unit : str
        Unit of the parameter, e.g. ``g``.
    """

    name: str
    group: str
    unit: str


def parameter_groups(parameters: Iterable[Parameter]) -> dict[str, list[int]]:
    """Indices of the parameters of each group, groups in the order of appearance."""
    groups: dict[str, list[int]] = {}
    for index, parameter in enumerate(parameters):
        groups.setdefault(parameter.group, []).append(index)
    return groups
