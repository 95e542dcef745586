"""The contract of a criterion, and of a ceiling."""

from __future__ import annotations

import numpy as np

from acalx.criteria import Ceiling, Concave, Criterion
from acalx.options import is_number
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter
from acalx.testing.rules import STACKS, TOLERANCE, require, require_close, require_shape, require_stacked

__all__ = ["check_criterion"]


def check_criterion(
    criterion: Criterion, parameters: tuple[Parameter, ...], *, monotone: bool = True, seed: int = 0
) -> None:
    """Check a criterion: loss, gradient, that information never hurts, and its terms.

    Parameters
    ----------
    criterion : Criterion
    parameters : tuple of Parameter
        Those of a model that the criterion fits.
    monotone : bool
        Whether one more position never makes the loss larger. An inequality is not like that.
    seed : int
        Of the random matrices; another one helps where a kink spoils the numerical gradient.
    """
    criterion.check(parameters)
    p = len(parameters)
    rng = np.random.default_rng(seed)
    for stack in STACKS:
        rows = rng.standard_normal((*stack, 3 * p, p)) * np.exp(rng.uniform(-1.0, 1.0, p))
        matrix = rows.swapaxes(-1, -2) @ rows
        information = Information(matrix.copy(), parameters)
        loss = np.asarray(criterion.loss(information))
        require_shape(criterion, "loss", loss, stack)
        require_stacked(criterion, "loss", lambda x: [criterion.loss(Information(x, parameters))], matrix)
        _require_gradient(criterion, information)
        require_close(criterion, "leaves the matrix as it is", information.matrix, matrix, 0.0)
        if isinstance(criterion, Concave):
            _check_degree(criterion, information)
        if monotone:
            more = Information(matrix + rows[..., :1, :].swapaxes(-1, -2) @ rows[..., :1, :], parameters)
            require(bool((criterion.loss(more) <= loss + 1e-9).all()), criterion, "more information never hurts")
        terms = criterion.terms()
        parts = (*terms.smooth, *terms.ceilings)
        total = np.asarray(sum(weight * part.loss(information) for weight, part in parts))
        require_close(criterion, "the terms add up to the loss", total, loss, 1e-9)
        for _, ceiling in terms.ceilings:
            _check_ceiling(ceiling, information)


def _check_degree(criterion: Concave, information: Information) -> None:
    """So much more information takes so much off the loss; less than its share at the mean of two matrices."""
    degree = criterion.degree(len(information.parameters))
    require(is_number(degree) and degree > 0, criterion, f"degree is a positive number, got {degree!r}")
    loss, matrix = np.asarray(criterion.loss(information)), information.matrix
    more = np.asarray(criterion.loss(Information(4.0 * matrix, information.parameters)))
    rule = f"four times the information takes degree {degree:g} times log 4 off the loss"
    require_close(criterion, rule, loss - more, np.full(loss.shape, degree * np.log(4.0)), 1e-6)
    other = matrix * (1.0 + np.eye(matrix.shape[-1]))
    first, middle, last = (
        np.exp(-np.asarray(criterion.loss(Information(between, information.parameters))) / degree)
        for between in (matrix, 0.5 * (matrix + other), other)
    )
    concave = middle >= 0.5 * (first + last) * (1.0 - 1e-9)
    require(bool(concave.all()), criterion, "exp(-loss / degree) is concave in the information")


def _check_ceiling(ceiling: Ceiling, information: Information) -> None:
    """The Lagrangian of a ceiling: nothing where log t is above the loss, and its derivatives."""
    matrix, loss, rng = information.matrix, ceiling.loss(information), np.random.default_rng(0)
    stack, penalty = loss.shape, np.full(loss.shape, 10.0)
    require(bool((loss >= ceiling.log_floor - 1e-9).all()), ceiling, "the loss is never below log_floor")
    multiplier = ceiling.start(information.parameters, stack)
    require(multiplier.shape[: len(stack)] == stack and not multiplier.any(), ceiling, "start is zeros (*stack, ...)")
    value = ceiling.hold(information, loss + 1e-6, multiplier, penalty)[0]
    require_close(ceiling, "hold is zero where log t is above the loss", value, np.zeros(stack), 1e-9)
    log_t, factor, step = loss - 0.1, np.linalg.cholesky(matrix), 1e-5
    for _ in range(2):  # the second time with multipliers that are not zero
        value, gradient, slope, following = ceiling.hold(information, log_t, multiplier, penalty)
        require_shape(ceiling, "the value of hold", value, stack)
        require(bool((value > 0).all()), ceiling, "hold is positive where log t is below the loss")
        for part, like in ((gradient, matrix), (slope, loss), (following, multiplier)):
            require_shape(ceiling, "what hold gives", part, like.shape)
        for rise in (0.0, 0.0, 0.0, 1.0):  # along random directions, the last time of log t too
            noise = rng.standard_normal(matrix.shape)
            along = factor @ (noise + noise.swapaxes(-1, -2)) @ factor.swapaxes(-1, -2)
            got = (gradient * along).sum(axis=(-2, -1)) + slope * rise
            expected = np.zeros(stack)
            for move in (step, -step):
                moved = Information(matrix + move * along, information.parameters)
                expected += ceiling.hold(moved, log_t + move * rise, multiplier, penalty)[0] / (2 * move)
            require_close(ceiling, "the gradient and slope of hold are right", got, expected, 100 * TOLERANCE)
        multiplier = following


def _require_gradient(criterion: Criterion, information: Information) -> None:
    gradient, numerical = criterion.gradient(information), Criterion.gradient(criterion, information)
    require_shape(criterion, "gradient", gradient, information.matrix.shape)
    factor = np.linalg.cholesky(information.matrix)
    got, expected = (factor.swapaxes(-1, -2) @ g @ factor for g in (gradient, numerical))
    require_close(criterion, "gradient is symmetric", got, got.swapaxes(-1, -2), 1e-9)
    require_close(criterion, "gradient agrees with the numerical one", got, expected, TOLERANCE)
