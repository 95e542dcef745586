"""Equal accuracy within a group of parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.criteria.base import Ceiling, Criterion, Product
from acalx.errors import ArgumentError, Option
from acalx.numerics.arrays import Array
from acalx.options import is_number
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter

__all__ = ["Inequality", "fair"]


@final
@dataclass(frozen=True)
class Inequality(Ceiling):
    """log of the inequality of a group: (max - min) / max of its standard deviations.

    It says whether the parameters of a kind, such as the three biases, come out equally
    accurate. In a product it is bounded from below: without a floor any program with one
    inequality of zero would have a product of zero, however poor it is otherwise. The default
    5e-4 is far below the scatter of any measured standard deviation (one from 100
    measurements scatters by 7 %); under it equality is good enough and the other factors
    decide.

    Parameters
    ----------
    group : str
        Name of a parameter group of the model, e.g. ``bias``.
    floor : float
        Inequalities below it count as equal to it, 0 < floor < 1.

    Raises
    ------
    ArgumentError
        A floor outside 0 to 1; at `check`, a group that the model does not have.

    Source: Egorov, Kiryachenko, Popov (2021); the floor is acalx's own.
    """

    group: str
    floor: float = 5e-4

    def __post_init__(self) -> None:
        if not is_number(self.floor) or not 0.0 < self.floor < 1.0:
            raise ArgumentError.of("floor", self.floor, "the floor of an inequality is a number between 0 and 1")

    @property
    def label(self) -> str:
        """``Inequality`` and the name of the group."""
        return f"Inequality {self.group}"

    def check(self, parameters: tuple[Parameter, ...]) -> None:
        """Raise ArgumentError where the model has no such group."""
        groups = list(dict.fromkeys(parameter.group for parameter in parameters))
        if self.group not in groups:
            raise ArgumentError(
                "Inequality: the model has no parameter group {group!r}; its groups are {groups}; "
                "name those, or choose a criterion without groups, such as {other}",
                group=self.group,
                groups=", ".join(groups),
                other=Option("criterion", "d", "D()"),
            )

    def loss(self, information: Information) -> Array:
        """Logarithm of the inequality, or of the floor where it is smaller."""
        inequality = information.inequality(self.group)
        return np.asarray(np.log(np.maximum(inequality, self.floor)))

    def gradient(self, information: Information) -> Array:
        """Of the largest and the smallest variance of the group; zero under the floor."""
        indices = np.array(information.group(self.group))
        covariance = information.covariance
        variances = information.variances[..., indices]
        largest, smallest = indices[variances.argmax(axis=-1)], indices[variances.argmin(axis=-1)]
        inequality = information.inequality(self.group)
        ratio = 1.0 - inequality  # of the smallest to the largest standard deviation
        factor = np.where(inequality > self.floor, 0.5 * ratio / np.maximum(inequality, self.floor), 0.0)
        shares = _share(covariance, smallest) - _share(covariance, largest)
        return np.asarray(factor[..., None, None] * shares)

    @property
    def log_floor(self) -> float:
        """Logarithm of the floor, below which inequalities don't count."""
        return math.log(self.floor)

    def start(self, parameters: tuple[Parameter, ...], stack: tuple[int, ...]) -> Array:
        """Multipliers (*stack, q, q), one for each ordered pair of the q parameters of the group."""
        q = sum(parameter.group == self.group for parameter in parameters)
        return np.zeros((*stack, q, q))

    def hold(
        self, information: Information, log_t: Array, multiplier: Array, penalty: Array
    ) -> tuple[Array, Array, Array, Array]:
        """Augmented Lagrangian of log K_ii - log K_jj + 2 log(1 - t) <= 0 for all i, j of the group."""
        indices = information.group(self.group)
        variances = information.variances[..., indices]
        logs = np.log(variances)
        t = np.minimum(np.exp(log_t), 1.0 - 1e-9)
        excess = logs[..., :, None] - logs[..., None, :] + 2.0 * np.log1p(-t)[..., None, None]
        following = np.maximum(multiplier + penalty[..., None, None] * excess, 0.0)
        value = ((following**2).sum(axis=(-2, -1)) - (multiplier**2).sum(axis=(-2, -1))) / (2 * penalty)
        slope = -2.0 * t / (1.0 - t) * following.sum(axis=(-2, -1))
        by_log = following.sum(axis=-1) - following.sum(axis=-2)
        columns = information.covariance[..., indices]
        weights = by_log / variances
        gradient = -(columns * weights[..., None, :]) @ columns.swapaxes(-1, -2)
        return value, gradient, slope, following


def fair(
    criterion: Criterion, groups: Sequence[str] = ("bias", "scale", "nonorthogonality"), exponent: float = 0.1
) -> Product:
    """The fair compromise: a criterion times the inequality of each group to a power.

    Source: Egorov, Kiryachenko, Popov (2021).

    Examples
    --------
    >>> from acalx.criteria import D
    >>> fair(D(), groups=["bias"]).label
    'D * (Inequality bias)^0.1'
    """
    return Product([criterion, *map(Inequality, groups)], [1.0, *[exponent] * len(groups)])


def _share(covariance: Array, index: np.ndarray) -> Array:
    """K e e' K / K_ii with e the unit vector of an index: minus the gradient of log K_ii."""
    column = np.take_along_axis(covariance, index[..., None, None], axis=-1)
    variance = np.take_along_axis(column, index[..., None, None], axis=-2)
    return np.asarray(column @ column.swapaxes(-1, -2) / variance)
