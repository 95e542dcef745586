"""The error parameters of a sensor, and combinations of them in words."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from acalx.numerics.arrays import Array

__all__ = ["Parameter", "as_sum", "parameter_groups", "parameter_sensors"]


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
    sensor : str
        Where a model has several sensors, which of them the parameter is of. Sensors may be as differently precise
        as they will; what is next to nothing is so beside parameters of the same one.
    """

    name: str
    group: str
    unit: str
    sensor: str = ""
    nominal: float = 0.0
    scatter: float | None = None


def parameter_sensors(parameters: Iterable[Parameter]) -> dict[str, list[int]]:
    """Indices of the parameters of each sensor, sensors in the order of appearance."""
    sensors: dict[str, list[int]] = {}
    for index, parameter in enumerate(parameters):
        sensors.setdefault(parameter.sensor, []).append(index)
    return sensors


def parameter_groups(parameters: Iterable[Parameter]) -> dict[str, list[int]]:
    """Indices of the parameters of each group, groups in the order of appearance."""
    groups: dict[str, list[int]] = {}
    for index, parameter in enumerate(parameters):
        groups.setdefault(parameter.group, []).append(index)
    return groups


def as_sum(coefficients: Sequence[float] | Array, parameters: Sequence[Parameter], smallest: float = 1e-6) -> str:
    """A combination of parameters as a readable sum; coefficients (p,) below the smallest are left out.

    Examples
    --------
    >>> as_sum([1.0, -0.5, 0.0], [Parameter(f"scale_{axis}", "scale", "1") for axis in "xyz"])
    'scale_x - 0.5 scale_y'
    """
    terms = []
    for coefficient, parameter in zip(coefficients, parameters, strict=True):
        size = abs(coefficient)
        if size >= smallest:
            factor = "" if abs(size - 1) < 1e-6 else f"{size:.4g} "
            terms.append((" - " if coefficient < 0 else " + ", f"{factor}{parameter.name}"))
    text = "".join(sign + term for sign, term in terms)
    return text.removeprefix(" + ") if text.startswith(" + ") else text.replace(" - ", "-", 1)
