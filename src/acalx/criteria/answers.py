"""What a criterion answers, looked at before anyone counts on it: it may be a user's.

Singular information is not shown to criteria: its loss is +inf, its gradient zero.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable

import numpy as np

from acalx.criteria.base import Criterion
from acalx.errors import AcalxError, PluginError
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
    if not information.singular.any():
        return _answer(criterion.loss, information, information.singular.shape)
    regular = ~information.singular
    losses = np.full(regular.shape, np.inf)
    if regular.any():
        rest = information.select(regular)
        losses[regular] = _answer(criterion.loss, rest, rest.singular.shape)
    return losses


def gradient_of(criterion: Criterion, information: Information) -> Array:
    """Gradient with respect to the information matrix, (..., p, p), zero where singular; PluginError as `loss_of`."""
    regular = ~information.singular
    if regular.all():
        return _answer(criterion.gradient, information, information.matrix.shape)
    gradients = np.zeros(information.matrix.shape)
    if regular.any():
        rest = information.select(regular)
        gradients[regular] = _answer(criterion.gradient, rest, rest.matrix.shape)
    return gradients


def _answer(method: Callable[[Information], Array], information: Information, shape: tuple[int, ...]) -> Array:
    """Loss or gradient of regular information, of the shape that it must have."""
    owner = type(getattr(method, "__self__", method)).__name__
    name, p = f"{owner}.{getattr(method, '__name__', 'call')}", len(information.parameters)
    try:
        given = method(information)
    except AcalxError:
        raise
    except Exception as error:
        frame = traceback.extract_tb(error.__traceback__)[-1]
        raise PluginError(
            f"{name} raised {type(error).__name__}: {error} ({frame.filename}, line {frame.lineno})"
        ) from error
    try:
        values = np.asarray(given, dtype=float)
    except (TypeError, ValueError) as error:
        raise PluginError(f"{name} returned {given!r}; expected numbers of shape {shape}") from error
    if values.shape != shape:
        raise PluginError(
            f"{name} returned shape {values.shape} for matrices of shape "
            f"{(*information.singular.shape, p, p)}; expected {shape}"
        )
    if np.isnan(values).any():
        raise PluginError(f"{name} returned nan for an information matrix that is not singular")
    return values
