"""Any models read at the same positions, as one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

from acalx.errors import ArgumentError, Option
from acalx.models.base import Model
from acalx.models.compared import as_model
from acalx.models.composite import Composite
from acalx.options import keep
from acalx.sensors import PlatformAccel, PlatformGyro
from acalx.sensors.base import Sensor

__all__ = ["Joined"]


@final
@dataclass(frozen=True)
class Joined(Composite):
    """Any models read at the same positions.

    Parameters
    ----------
    parts : sequence of Model or Sensor, or mapping from names to these; None: a gyro and an accelerometer of a platform
        Of a mapping the names stand before those of the parameters, so that models with the same parameters join:
        ``{accel: ..., mag: ...}`` gives ``accel_bias_x`` and ``mag_bias_x``.
    common : sequence of str
        Parameters that several parts have and that are one and the same, as the misalignment of a board; they get
        no prefix.

    Raises
    ------
    ArgumentError
        No models, a parameter that two of them have, a common one that fewer than two have.
    """

    parts: Sequence[Model | Sensor] | Mapping[str, Model | Sensor] | None = None
    common: Sequence[str] = ()

    def __post_init__(self) -> None:
        given, parts = self.parts, self._parts
        if not isinstance(parts, Sequence) or not parts or not all(isinstance(p, Model | Sensor) for p in parts):
            rule = "give a list of one or more models, or a mapping from names to them"
            raise ArgumentError.of("parts", given, rule, {"accel": {"_target_": "acalx.models.ScalarAccel"}})
        if isinstance(self.common, str) or not isinstance(self.common, Sequence):
            raise ArgumentError.of("common", self.common, "give a list of names of parameters", ["misalignment_x"])
        keep(self, "parts", "common")
        for which in ("parameters", "channels"):
            self._check_names(which)

    def _check_names(self, which: str) -> None:
        each = [[one.name for one in getattr(model, which)] for model in self.models]
        if which == "parameters":
            for name in self.common:
                if (count := sum(name in names for names in each)) < 2:
                    have = f"{count or 'none'} of the parts has a parameter {name}"
                    raise ArgumentError.of("common", list(self.common), f"{have}; two or more must")
                self._check_alike(name)
        names = [
            prefix + name
            for prefix, part in zip(self.prefixes, each, strict=True)
            for name in part
            if which != "parameters" or name not in self.common
        ]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ArgumentError(
                f"joined models have the same {which}: {', '.join(twice)}; "
                + "each needs its own: give names, as in {named}",
                named=Option("parts", "{first: MODEL, second: MODEL}", '{"first": ..., "second": ...}'),
            )

    def _check_alike(self, name: str) -> None:
        """Raise ArgumentError for a common parameter that is not the same in all parts that have it."""
        found = [one for model in self.models for one in model.parameters if one.name == name]
        for what, values in (
            ("units", [one.unit for one in found]),
            ("groups", [one.group for one in found]),
            ("nominal values", [one.nominal for one in found]),
        ):
            if len(set(values)) > 1:
                told = ", ".join(map(str, dict.fromkeys(values)))
                raise ArgumentError.of(
                    "common", list(self.common), f"{name} has different {what} in the parts: {told}; they must be one"
                )

    @cached_property
    def models(self) -> tuple[Model, ...]:
        """The joined models, one for each sensor, in the order in which their parameters come."""
        return tuple(as_model(part) for part in self._parts)

    @property
    def _parts(self) -> Sequence[Model | Sensor]:
        """The parts without their names."""
        if self.parts is None:
            return (PlatformGyro("x"), PlatformAccel("x"))
        return list(self.parts.values()) if isinstance(self.parts, Mapping) else self.parts

    @cached_property
    def prefixes(self) -> tuple[str, ...]:
        """The names of the parts, with an underscore; none of a list."""
        return tuple(f"{name}_" for name in self.parts) if isinstance(self.parts, Mapping) else ("",) * len(self.models)

    @property
    def shared(self) -> tuple[str, ...]:
        """What was given as common."""
        return tuple(self.common)
