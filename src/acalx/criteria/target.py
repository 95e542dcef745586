"""Wanted standard errors of groups of parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.criteria.base import Ceiling
from acalx.criteria.concave import Concave
from acalx.errors import ArgumentError
from acalx.numerics.arrays import Array
from acalx.options import is_number, keep
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter, parameter_groups

__all__ = ["Target"]

# Power of the norm that stands for the maximum in bounds: as large as Newton's method takes it.
_POWER = 300.0


@final
@dataclass(frozen=True)
class Target(Ceiling, Concave):
    """log of the largest variance over the square of what is wanted of it.

    1 or less means that every parameter of the groups is as precise as wanted, or more. With
    the variances K_ii and the wanted standard errors s_i,

        t = max_i K_ii / s_i^2.

    Parameters
    ----------
    standard_errors : mapping of str to float
        Largest standard error of each group, in units of its parameters, with the noise that
        the model has. Groups that are not named may be as they will.

    Raises
    ------
    ArgumentError
        No groups, a standard error that is not a positive number; at `check`, a group that the
        model does not have.

    Source: Elfving, Ann. Math. Statist. 23 (1952) 255, for single parameters; Dette, J. R. Statist.
    Soc. B 59 (1997) 97, for the standardized maximum.
    """

    standard_errors: Mapping[str, float] | None = None

    def __post_init__(self) -> None:
        given = self.standard_errors
        if not isinstance(given, Mapping) or not given:
            rule, example = "give the largest standard error of each group", {"bias": 0.5, "scale": 0.8}
            raise ArgumentError.of("target", given, rule, example)
        for group, value in given.items():
            if not is_number(value) or value <= 0.0:
                raise ArgumentError.of("target", {group: value}, "a standard error is a positive number")
        keep(self, "standard_errors")

    def __hash__(self) -> int:
        return hash(tuple(sorted(self.wanted.items())))

    @property
    def wanted(self) -> Mapping[str, float]:
        """The standard errors that are wanted, by group."""
        assert self.standard_errors is not None  # refused at construction
        return self.standard_errors

    def check(self, parameters: tuple[Parameter, ...]) -> None:
        """Raise ArgumentError where the model has no such group."""
        groups = parameter_groups(parameters)
        for group in self.wanted:
            if group not in groups:
                raise ArgumentError(
                    f"target: the model has no parameter group {group!r}; its groups are {', '.join(groups)}"
                )

    def degree(self, p: int) -> float:
        """1: variances fall as the information grows."""
        return 1.0

    def loss(self, information: Information) -> Array:
        """Logarithm of t, (...): negative where every standard error is smaller than wanted."""
        return np.asarray(self._logs(information).max(axis=-1))

    def gradient(self, information: Information) -> Array:
        """-K e e' K / K_ii, with e the unit vector of the worst parameter."""
        indices, _ = self._members(information.parameters)
        worst = np.array(indices)[self._logs(information).argmax(axis=-1)]
        column = np.take_along_axis(information.covariance, worst[..., None, None], axis=-1)
        variance = np.take_along_axis(column, worst[..., None, None], axis=-2)
        return np.asarray(-column @ column.swapaxes(-1, -2) / variance)

    def smoothed(self) -> Concave:
        """A norm in the place of the maximum."""
        return _Norm(self)

    def support(self, information: Information, multiplier: Array | None) -> Array:
        """The multiplier: where several parameters are equally far from what is wanted the gradient takes one."""
        return -self.gradient(information) if multiplier is None else multiplier

    def least_loss(self, support: Array, at: Information) -> Array:
        """log (tr (W^1/2 S W^1/2)^1/2)^2 with W = diag(w_i / s_i^2) of weights w that sum to 1.

        A mean of K_ii / s_i^2 is no larger than the largest; that is its least value for
        trace(S M) <= 1. The weights are those with which S would be the support at `at`.
        """
        indices, logs = self._members(at.parameters)
        shown = (at.matrix @ support @ at.matrix).diagonal()[indices]
        shares = np.maximum(shown, 0.0) * np.exp(logs)
        root = np.zeros(len(support))
        root[indices] = np.sqrt(shares / shares.sum() / np.exp(logs))
        values = np.linalg.eigvalsh(root[:, None] * support * root)
        return np.asarray(2.0 * np.log(np.sqrt(np.maximum(values, 0.0)).sum()))

    @property
    def log_floor(self) -> float:
        """No floor, minus infinity: a variance can be as small as it will."""
        return -np.inf

    def start(self, parameters: tuple[Parameter, ...], stack: tuple[int, ...]) -> Array:
        """Multipliers (*stack, q), one for each of the q parameters with a target."""
        return np.zeros((*stack, len(self._members(parameters)[0])))

    def hold(
        self, information: Information, log_t: Array, multiplier: Array, penalty: Array
    ) -> tuple[Array, Array, Array, Array]:
        """Augmented Lagrangian of log K_ii - 2 log s_i - log t <= 0 for all i."""
        indices, _ = self._members(information.parameters)
        excess = self._logs(information) - log_t[..., None]
        following = np.maximum(multiplier + penalty[..., None] * excess, 0.0)
        value = ((following**2).sum(axis=-1) - (multiplier**2).sum(axis=-1)) / (2 * penalty)
        columns = information.covariance[..., indices]
        weights = following / information.variances[..., indices]
        gradient = -(columns * weights[..., None, :]) @ columns.swapaxes(-1, -2)
        return value, gradient, -following.sum(axis=-1), following

    def _members(self, parameters: tuple[Parameter, ...]) -> tuple[Sequence[int], Array]:
        """Indices of the parameters with a target, and 2 log s of each."""
        groups = parameter_groups(parameters)
        indices = [index for group in self.wanted for index in groups[group]]
        logs = [2.0 * math.log(value) for group, value in self.wanted.items() for _ in groups[group]]
        return indices, np.array(logs)

    def _logs(self, information: Information) -> Array:
        """log K_ii / s_i^2 of each of the parameters, (..., q)."""
        indices, logs = self._members(information.parameters)
        return np.asarray(np.log(information.variances[..., indices]) - logs)


@final
@dataclass(frozen=True)
class _Norm(Concave):
    """log (sum (K_ii / s_i^2)^q)^(1/q): above the maximum by a factor m^(1/q) of m parameters at most."""

    target: Target

    def degree(self, p: int) -> float:
        """1: variances fall as the information grows."""
        return 1.0

    def loss(self, information: Information) -> Array:
        logs = self.target._logs(information)
        most = logs.max(axis=-1)
        return np.asarray(most + np.log(np.exp(_POWER * (logs - most[..., None])).sum(axis=-1)) / _POWER)

    def gradient(self, information: Information) -> Array:
        """-sum l_i K e_i e_i' K / K_ii, with l_i the share of a parameter in the sum."""
        columns, shares = self._shares(information)
        weights = shares / information.variances[..., self._indices(information)]
        return np.asarray(-(columns * weights[..., None, :]) @ columns.swapaxes(-1, -2))

    def curvature(self, information: Information, directions: Array) -> Array:
        columns, shares = self._shares(information)
        variances = information.variances[self._indices(information)]
        moved = directions @ columns  # D K e_i, (..., p, m)
        slopes = -np.einsum("pm,dpm->dm", columns, moved) / variances
        bend = 2.0 * np.einsum(
            "dpm,pr,erm,m->de", moved, information.covariance, moved, shares / variances, optimize=True
        )
        mean = slopes @ shares
        spread = (slopes * shares) @ slopes.T
        return np.asarray(bend - spread + _POWER * (spread - np.outer(mean, mean)))

    def _indices(self, information: Information) -> Sequence[int]:
        return self.target._members(information.parameters)[0]

    def _shares(self, information: Information) -> tuple[Array, Array]:
        """Columns of the covariance (..., p, m) and shares of the parameters (..., m)."""
        logs = self.target._logs(information)
        powers = np.exp(_POWER * (logs - logs.max(axis=-1, keepdims=True)))
        return information.covariance[..., self._indices(information)], powers / powers.sum(axis=-1, keepdims=True)
