"""Everything that goes wrong in a simulated calibration, and how much."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeGuard, final

import numpy as np

from acalx.errors import ArgumentError, CompatibilityError, Option
from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.options import is_number, keep, require_switch
from acalx.quantities.parameter import parameter_groups
from acalx.stands import Stand

__all__ = ["ErrorSources"]

_ARCSEC = math.pi / 180.0 / 3600.0
# Directions of axes have 1e-4 each; a non-orthogonality is a difference of two.
_PAPER = {"bias": 1e-4, "scale": 1e-4, "nonorthogonality": 1.4142e-4}


@final
@dataclass(frozen=True)
class ErrorSources:
    """Standard deviations of all that is drawn in a trial; independent, normal, zero mean.

    Parameters
    ----------
    parameters : mapping
        From a group of parameters to the standard deviation of the true ones, in their unit; or
        to a pair, the least and the largest magnitude, between which they are uniform, with
        either sign. About the nominal values. Of groups that are not here sensors differ by what the model's
        prior says, or by the scatter that its parameters have.
    noise : float
        Of a reading, a multiple of the noise that the channels of the model have: of `ScalarAccel`, 1 g.
    setting_rad : float, rad
        Of the true attitude about the program's, about each axis of the sensor.
    setting_repeats : bool
        Whether the stand sets the same wrong attitudes in every trial. Otherwise each trial has its own.
    knowledge_rad : float, rad, optional
        Of the known attitude about the true one. None: it is not measured, and the program's
        is taken for it.
    gravity : float, relative
        Of the true gravity about the known one.
    installation_arcsec : pair of float
        Mean and standard deviation of the angles by which the axes of the stand are off, on
        stands that have such angles (see `Stand.axis_errors`).
    installation_known : bool
        Whether they are known to those who calibrate.
    drift : float
        Of the bias of each reading at the first position, as the sensor is switched on, in the
        unit of the noise. It decays while it warms up.
    drift_positions : float
        Number of positions in which the drift falls to 1/e.

    Raises
    ------
    ArgumentError
        What is negative or no number.

    Source: the defaults are those of Egorov, Kiryachenko, Popov (2021), Table 6.
    """

    parameters: Mapping[str, float | Sequence[float]] = field(default_factory=lambda: dict(_PAPER))
    noise: float = 1e-5
    setting_rad: float = 1e-4
    setting_repeats: bool = False
    knowledge_rad: float | None = None
    gravity: float = 1e-7
    installation_arcsec: Sequence[float] = (0.0, 0.0)
    installation_known: bool = True
    drift: float = 0.0
    drift_positions: float = 20.0

    def __post_init__(self) -> None:
        for name in ("noise", "setting_rad", "gravity", "drift"):
            _require_deviation(name, getattr(self, name))
        if self.noise == 0.0:
            raise ArgumentError("noise=0: the noise must be positive, since all results are in units of it")
        if self.knowledge_rad is not None:
            _require_deviation("knowledge_rad", self.knowledge_rad)
        if not is_number(self.drift_positions) or self.drift_positions <= 0:
            raise ArgumentError.of("drift_positions", self.drift_positions, "give a positive number of positions")
        for name in ("setting_repeats", "installation_known"):
            require_switch(name, getattr(self, name))
        pair = self.installation_arcsec
        if not _is_pair(pair) or pair[1] < 0:
            rule = "give the mean and the standard deviation, which is not negative, as in {example}"
            example = Option("installation_arcsec", [10, 1])
            raise ArgumentError("{given}: " + rule, given=Option("installation_arcsec", pair), example=example)
        if not isinstance(self.parameters, Mapping):
            raise ArgumentError(
                "{given}: give magnitudes by group, as in {right}",
                given=Option("parameters", self.parameters),
                right=Option("errors.parameters", "{bias: 1e-4}", '{"bias": 1e-4}'),
            )
        for group, magnitude in self.parameters.items():
            _require_magnitude(group, magnitude)
        keep(self, "parameters", "installation_arcsec")

    def check(self, model: Model, stand: Stand) -> None:
        """Raise CompatibilityError for groups that the model lacks, or has and are not given."""
        groups, name = parameter_groups(model.parameters), model.called
        for group, magnitude in self.parameters.items():
            if group not in groups and magnitude != 0.0:
                raise CompatibilityError(
                    "errors.parameters has a group {group} that model {model} lacks; it has {groups}: "
                    "choose errors for this model, by {errors}, or give {none}",
                    group=group,
                    model=name,
                    groups=", ".join(groups),
                    errors=Option("errors", "NAME", "ErrorSources(...)"),
                    none=Option(f"errors.parameters.{group}", 0, repr({group: 0}), argument="parameters"),
                )
        known = model.prior_information > 0.0
        for group, members in groups.items():
            told = all(known[k] or model.parameters[k].scatter is not None for k in members)
            if group not in self.parameters and not told:
                raise CompatibilityError(
                    "how large are the true {group} of model {model}? Give {size}, "
                    "a standard deviation, or [1e-5,1e-4], the least and the largest magnitude",
                    group=group,
                    model=name,
                    size=Option(f"+errors.parameters.{group}", 1e-4, repr({group: 1e-4}), argument="parameters"),
                )
        if any(self.installation_arcsec) and not stand.axis_errors:
            raise CompatibilityError(
                "{given}: stand {stand} does not say what its axes can be off by; give {none}",
                given=Option("errors.installation_arcsec", list(self.installation_arcsec)),
                stand=type(stand).__name__,
                none=Option("errors.installation_arcsec", [0, 0]),
            )

    def true_parameters(self, model: Model, normal: Array, uniform: Array) -> Array:
        """True parameters (T, p) from standard normal and uniform numbers (T, p)."""
        out = np.empty_like(normal)
        for k, (parameter, information) in enumerate(zip(model.parameters, model.prior_information, strict=True)):
            usual = parameter.scatter if information == 0.0 else float(information**-0.5)
            magnitude = self.parameters.get(parameter.group, usual)
            if isinstance(magnitude, Sequence):
                low, high = magnitude
                out[:, k] = np.copysign(low + (high - low) * uniform[:, k], normal[:, k])
            else:
                assert magnitude is not None  # `check` has seen to that
                out[:, k] = magnitude * normal[:, k]
            if parameter.nominal:
                out[:, k] += parameter.nominal
        return out

    def installation(self, normal: Array) -> Array:
        """Angles in rad from standard normal numbers, any shape."""
        mean, deviation = self.installation_arcsec
        return _ARCSEC * (mean + deviation * normal)


def _require_deviation(name: str, value: object) -> None:
    if not is_number(value) or value < 0:
        raise ArgumentError.of(name, value, "a standard deviation is a number, 0 or more")


def _require_magnitude(group: str, magnitude: object) -> None:
    if _is_pair(magnitude):
        if not 0 <= magnitude[0] <= magnitude[1]:
            rule = "give the least and the largest magnitude, 0 or more"
            raise ArgumentError.of("parameters", {group: list(magnitude)}, rule)
    elif not is_number(magnitude) or magnitude < 0:
        raise ArgumentError.of("parameters", {group: magnitude}, "a standard deviation is a number, 0 or more")


def _is_pair(value: object) -> TypeGuard[Sequence[float]]:
    return isinstance(value, Sequence) and not isinstance(value, str) and len(value) == 2 and all(map(is_number, value))
