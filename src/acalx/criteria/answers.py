"""What a criterion answers, looked at before anyone counts on it: it may be a user's.

Singular information is not shown to criteria: its loss is +inf, its gradient zero.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from acalx.criteria.base import Criterion
from acalx.errors import PluginError, asked
from acalx.numerics.arrays import Array
from acalx.quantities.information import Information

__all__ = ["gradient_of", "loss_of"]


def loss_of(criterion: Criterion, information: Information) -> Array:
    """Loss of given information, +inf where singular, (...).

    Raises
    ------
    PluginError
        Where the criterion raises, or returns something other than one number a program.
    """
    return _of_regular(f"{type(criterion).__name__}.loss", criterion.loss, information, (), np.inf)


def gradient_of(criterion: Criterion, information: Information) -> Array:
    """Gradient with respect to the information matrix, (..., p, p), zero where singular.

    Raises
    ------
    PluginError
        Where the criterion raises, or returns something other than one matrix a program.
    """
    p = len(information.parameters)
    return _of_regular(f"{type(criterion).__name__}.gradient", criterion.gradient, information, (p, p), 0.0)


def _of_regular(
    name: str,
    method: Callable[[Information], Array],
    information: Information,
    each: tuple[int, ...],
    otherwise: float,
) -> Array:
    """What a method says of regular information, arrays of the shape `each`, and another number where singular."""
    regular = ~information.singular
    if regular.all():
        return _answer(name, method, information, (*regular.shape, *each))
    answers = np.full((*regular.shape, *each), otherwise)
    if regular.any():
        rest = information.select(regular)
        answers[regular] = _answer(name, method, rest, (*rest.singular.shape, *each))
    return answers


def _answer(
    name: str,
    method: Callable[[Information], Array],
    information: Information,
    shape: tuple[int, ...],
) -> Array:
    """What a method says of regular information, if it is numbers of this shape."""
    given = asked(name, method, information)
    try:
        values = np.asarray(given, dtype=float)
    except (TypeError, ValueError) as error:
        raise PluginError(f"{name} returned {given!r}; expected numbers of shape {shape}") from error
    if values.shape != shape:
        raise PluginError(
            f"{name} returned shape {values.shape} for matrices of shape {information.matrix.shape}; expected {shape}"
        )
    if np.isnan(values).any():
        raise PluginError(f"{name} returned nan for an information matrix that is not singular")
    return values
