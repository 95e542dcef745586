"""The contract of each kind of part, for whoever writes one: call these from your own tests.

Each function tries a part on random input and raises AssertionError with the name of the part
and the rule that it broke. What a part itself raises comes through as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from itertools import pairwise
from typing import Any

import numpy as np

from acalx.criteria import Ceiling, Criterion
from acalx.errors import CompatibilityError
from acalx.models import Model
from acalx.numerics.arrays import Array
from acalx.optimizers.base import Optimizer
from acalx.problem import Problem
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus
from acalx.search.account import Account
from acalx.search.pareto import nondominated
from acalx.search.result import Found, Front, Result
from acalx.stands import Setting, Stand

__all__ = ["check_criterion", "check_model", "check_optimizer", "check_stand"]

# Leading axes: a few programs, one, and so many on two levels that arithmetic runs along them.
_STACKS: tuple[tuple[int, ...], ...] = ((3,), (), (2, 20))
_N = 5
# How far derivatives may be from numerical ones, relative to the largest entry.
_TOLERANCE = 1e-6


def check_stand(stand: Stand, *, seed: int = 0) -> None:
    """Check a stand: limits, random and wrapped settings, stimulus, derivative, aim, equivalents, axes off, speeds.

    Parameters
    ----------
    stand : Stand
    seed : int
        Of the random settings.
    """
    settings = stand.settings
    _require(len(settings) > 0 and all(isinstance(s, Setting) for s in settings), stand, "settings are one or more")
    _require(
        len(set(stand.axes.names)) == len(settings), stand, f"each setting has its own name, got {stand.axes.names}"
    )
    for stack in _STACKS:
        shape = (*stack, _N)
        angles, again = (stand.axes.random(np.random.default_rng(seed), shape) for _ in range(2))
        _require_shape(stand, "random", angles, (*shape, len(settings)))
        _require_close(stand, "random settings follow from the seed", angles, again, 0.0)
        _require(bool(stand.axes.allows(angles).all()), stand, "random settings are ones that the stand allows")
        stimulus = stand.stimulus(angles)
        _require(any(True for _ in stimulus.quantities()), stand, "stimulus gives one quantity or more")
        for name, value in stimulus.quantities():
            _require_shape(stand, f"stimulus.{name}", value, (*shape, 3))
        _require_stacked(stand, "stimulus", lambda x: _arrays(stand.stimulus(x)), angles)
        turned = angles + 2.0 * np.pi * np.array([s.periodic for s in settings])
        for same in (turned, stand.axes.wrap(turned), stand.axes.wrap(angles)):
            for (name, value), (_, other) in zip(stimulus.quantities(), stand.stimulus(same).quantities(), strict=True):
                _require_close(stand, f"a periodic setting a turn on gives the same {name}", other, value, 1e-9)
        exact, numerical = stand.derivative(angles), Stand.derivative(stand, angles)
        _require_derivative(stand, exact, numerical, (*shape, 3, len(settings)))
        if stimulus.specific_force is not None:
            _check_aim(stand, stimulus.specific_force)
        for program in angles.reshape(-1, _N, len(settings))[:1]:
            _check_equivalents(stand, program)
            _check_misaligned(stand, program)
    speeds = stand.speeds
    _require(np.shape(speeds) == (len(settings),), stand, f"there is a speed for each setting, got {speeds}")
    _require(bool((speeds > 0).all()), stand, "speeds are positive")


def _check_aim(stand: Stand, directions: Array) -> None:
    """Settings for directions (..., n, 3), where the stand can be aimed; those that are no angles are at rest."""
    try:
        aimed = stand.aim(directions)
    except CompatibilityError:
        return
    _require_shape(stand, "aim", aimed, (*directions.shape[:-1], len(stand.settings)))
    force = dict(stand.stimulus(aimed).quantities())["specific_force"]
    _require_close(stand, "aim brings the vertical where it is told", force, directions, 1e-7)
    moving = aimed[..., [not setting.angle for setting in stand.settings]]
    _require(not moving.any(), stand, "aim leaves settings that are no angles at rest")


def _check_equivalents(stand: Stand, program: Array) -> None:
    """Other settings for those of a program (n, d)."""
    ways = stand.equivalents(program)
    _require_shape(stand, "equivalents", ways, (len(ways), *program.shape))
    _require(np.array_equal(ways[0], program), stand, "the given settings come first among the equivalent ones")
    _require(bool(stand.axes.allows(ways).all()), stand, "equivalent settings are ones that the stand allows")
    wanted = dict(stand.stimulus(program).quantities())
    for name, felt in stand.stimulus(ways).quantities():
        expected = np.broadcast_to(wanted[name], felt.shape)
        _require_close(stand, f"equivalent settings give the same {name}", felt, expected, 1e-9)


def _check_misaligned(stand: Stand, program: Array) -> None:
    """What is felt for a program (n, d) where the axes are off, by nothing and by each of the errors alone."""
    wanted, count = dict(stand.stimulus(program).quantities()), len(stand.axis_errors)
    felt = dict(stand.misaligned(program, np.zeros((2, 1, count))).quantities())
    for name, value in wanted.items():
        value = np.broadcast_to(value, (2, *value.shape))
        got = np.broadcast_to(felt[name], value.shape)
        _require_close(stand, f"axes off by nothing change nothing of {name}", got, value, 1e-9)
    if count:
        off = dict(stand.misaligned(program, np.full((2, 1, count), 0.1)).quantities())
        changed = [np.abs(off[name] - value).max() for name, value in wanted.items()]
        _require(max(changed) > 1e-6, stand, "axes that are off change what is felt")


def check_model(model: Model, stand: Stand, *, seed: int = 0) -> None:
    """Check a model on the stimulus of a stand: parameters, regressors, derivative.

    Parameters
    ----------
    model : Model
    stand : Stand
        One that provides what the model needs.
    seed : int
        Of the random settings.
    """
    p, m = len(model.parameters), model.outputs
    names = [parameter.name for parameter in model.parameters]
    _require(p > 0 and m > 0, model, "there are parameters and outputs")
    _require(len(set(names)) == p, model, f"each parameter has its own name, got {names}")
    known = {field.name for field in fields(Stimulus)}
    _require(bool(model.needs) and set(model.needs) <= known, model, f"needs names quantities among {sorted(known)}")
    _require(model.smallest_n * m >= p, model, f"smallest_n={model.smallest_n} gives fewer readings than parameters")
    for stack in _STACKS:
        angles = stand.axes.random(np.random.default_rng(seed), (*stack, _N))
        stimulus = stand.stimulus(angles)
        model.check(stimulus, stand)
        _require_shape(model, "regressors", model.regressors(stimulus), (*stack, _N, m, p))
        _require_stacked(model, "regressors", lambda x: [model.regressors(stand.stimulus(x))], angles)
        exact, numerical = model.derivative(stimulus), Model.derivative(model, stimulus)
        _require_derivative(model, exact, numerical, (*stack, _N, m, p, 3))


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
    for stack in _STACKS:
        rows = rng.standard_normal((*stack, 3 * p, p)) * np.exp(rng.uniform(-1.0, 1.0, p))
        matrix = rows.swapaxes(-1, -2) @ rows
        information = Information(matrix.copy(), parameters)
        loss = np.asarray(criterion.loss(information))
        _require_shape(criterion, "loss", loss, stack)
        _require_stacked(criterion, "loss", lambda x: [criterion.loss(Information(x, parameters))], matrix)
        _require_gradient(criterion, information)
        _require_close(criterion, "leaves the matrix as it is", information.matrix, matrix, 0.0)
        if monotone:
            more = Information(matrix + rows[..., :1, :].swapaxes(-1, -2) @ rows[..., :1, :], parameters)
            _require(bool((criterion.loss(more) <= loss + 1e-9).all()), criterion, "more information never hurts")
        terms = criterion.terms()
        parts = (*terms.smooth, *terms.ceilings)
        total = np.asarray(sum(weight * part.loss(information) for weight, part in parts))
        _require_close(criterion, "the terms add up to the loss", total, loss, 1e-9)
        for _, ceiling in terms.ceilings:
            _check_ceiling(ceiling, information)


def check_optimizer(optimizer: Optimizer[Any], problem: Problem, *, seed: int = 0) -> None:
    """Check an optimizer on a problem that it takes: its result, its account, an interrupt.

    Parameters
    ----------
    optimizer : Optimizer
    problem : Problem
        A small one; it is solved twice, and begun a third time.
    seed : int
        Of the random generator.
    """
    result, again = (optimizer.solve(problem, np.random.default_rng(seed)) for _ in range(2))
    if isinstance(result, Front):
        _check_front(optimizer, problem, result, again)
        halted = optimizer.solve(problem, np.random.default_rng(seed), _interrupt)
        _require(halted.status == "interrupted", optimizer, f"lets an interrupt pass, got status {halted.status!r}")
        _check_front(optimizer, problem, halted, halted)
        return
    losses, progress = [s.loss for s in result.solutions], [loss for _, _, loss in result.history]
    _require(result.status in ("ok", "limit"), optimizer, f"status is ok or limit, got {result.status!r}")
    _require(bool(result.message), optimizer, "the message says why the search ended")
    _require(result.evaluations > 0, optimizer, "evaluations are counted")
    _require(losses == sorted(losses), optimizer, f"solutions come best first, got losses {losses}")
    _require_solutions(optimizer, problem, result)
    falls = all(after < before for before, after in pairwise(progress))
    _require(bool(progress) and falls, optimizer, "the history is of a loss that falls")
    _require_close(optimizer, "the account saw the best program", np.array(progress[-1]), np.array(losses[0]), 1e-6)
    first, second = ([(s.loss, s.settings.tobytes()) for s in r.solutions] for r in (result, again))
    same = first == second and again.evaluations == result.evaluations
    _require(same, optimizer, "the same seed gives the same result, bit for bit")
    halted = optimizer.solve(problem, np.random.default_rng(seed), _interrupt)
    _require(halted.status == "interrupted", optimizer, f"lets an interrupt pass, got status {halted.status!r}")
    _require_solutions(optimizer, problem, halted)


def _check_front(optimizer: Optimizer[Any], problem: Problem, result: Found, again: Found) -> None:
    """The points of a front: allowed, none better than another in all, the same again, the knee one of them."""
    front = isinstance(result, Front) and isinstance(again, Front) and len(result.points) > 0
    _require(front, optimizer, "there is a front")
    assert isinstance(result, Front)
    assert isinstance(again, Front)
    losses, settings = result.losses, np.array([point.settings for point in result.points])
    _require(len(nondominated(losses)) == len(losses), optimizer, "no point of the front is better than another in all")
    _require(bool((np.diff(losses[:, 0]) >= 0).all()), optimizer, "points come by ascending first loss")
    _require(bool(problem.stand.axes.allows(settings).all()), optimizer, "positions are ones the stand allows")
    _require_close(optimizer, "the losses are those of the programs", losses, problem.losses(settings), 1e-9)
    best = result.points[result.knee].settings
    _require(np.array_equal(result.program, best), optimizer, "the program to take is the knee")
    same = [point.settings.tobytes() for point in result.points] == [p.settings.tobytes() for p in again.points]
    _require(same, optimizer, "the same seed gives the same result, bit for bit")


def _interrupt(account: Account) -> None:
    if account.found:
        raise KeyboardInterrupt


def _check_ceiling(ceiling: Ceiling, information: Information) -> None:
    """The Lagrangian of a ceiling: nothing where log t is above the loss, and its derivatives."""
    matrix, loss, rng = information.matrix, ceiling.loss(information), np.random.default_rng(0)
    stack, penalty = loss.shape, np.full(loss.shape, 10.0)
    _require(bool((loss >= ceiling.log_floor - 1e-9).all()), ceiling, "the loss is never below log_floor")
    multiplier = ceiling.start(information.parameters, stack)
    _require(multiplier.shape[: len(stack)] == stack and not multiplier.any(), ceiling, "start is zeros (*stack, ...)")
    value = ceiling.hold(information, loss + 1e-6, multiplier, penalty)[0]
    _require_close(ceiling, "hold is zero where log t is above the loss", value, np.zeros(stack), 1e-9)
    log_t, factor, step = loss - 0.1, np.linalg.cholesky(matrix), 1e-5
    for _ in range(2):  # the second time with multipliers that are not zero
        value, gradient, slope, following = ceiling.hold(information, log_t, multiplier, penalty)
        _require_shape(ceiling, "the value of hold", value, stack)
        _require(bool((value > 0).all()), ceiling, "hold is positive where log t is below the loss")
        for part, like in ((gradient, matrix), (slope, loss), (following, multiplier)):
            _require_shape(ceiling, "what hold gives", part, like.shape)
        for rise in (0.0, 0.0, 0.0, 1.0):  # along random directions, the last time of log t too
            noise = rng.standard_normal(matrix.shape)
            along = factor @ (noise + noise.swapaxes(-1, -2)) @ factor.swapaxes(-1, -2)
            got = (gradient * along).sum(axis=(-2, -1)) + slope * rise
            expected = np.zeros(stack)
            for move in (step, -step):
                moved = Information(matrix + move * along, information.parameters)
                expected += ceiling.hold(moved, log_t + move * rise, multiplier, penalty)[0] / (2 * move)
            _require_close(ceiling, "the gradient and slope of hold are right", got, expected, 100 * _TOLERANCE)
        multiplier = following


def _require(holds: bool, part: object, rule: str) -> None:
    if not holds:
        raise AssertionError(f"{type(part).__name__} breaks a rule: {rule}")


def _require_shape(part: object, what: str, value: Array, shape: tuple[int, ...]) -> None:
    _require(np.shape(value) == shape, part, f"{what} has shape {shape}, got {np.shape(value)}")
    _require(bool(np.isfinite(value).all()), part, f"{what} is finite")


def _require_close(part: object, rule: str, value: Array, expected: Array, tolerance: float) -> None:
    value, expected = np.asarray(value), np.asarray(expected)
    _require(value.shape == expected.shape, part, f"{rule}; shape {expected.shape}, got {value.shape}")
    error = float(np.abs(value - expected).max(initial=0.0))
    _require(error <= tolerance * (1.0 + np.abs(expected).max(initial=0.0)), part, f"{rule}; it is {error:.1e} off")


def _require_stacked(part: object, what: str, function: Callable[[Array], list[Array]], x: Array) -> None:
    """The result for a stack, in both memory orders, is that of its members; x stays as it is."""
    before, stack = x.copy(), x.shape[:-2]
    for ordered in (np.ascontiguousarray(x), np.asfortranarray(x)):
        for whole, *each in zip(function(ordered), *(function(x[k]) for k in np.ndindex(stack)), strict=True):
            one_by_one = np.stack(each).reshape((*stack, *np.shape(each[0])))
            _require_close(part, f"{what} of a stack is that of its members", whole, one_by_one, 1e-9)
        _require(np.array_equal(ordered, before), part, f"{what} leaves its input as it is")


def _require_derivative(part: object, exact: Stimulus, numerical: Stimulus, shape: tuple[int, ...]) -> None:
    got, wanted = dict(exact.quantities()), dict(numerical.quantities())
    _require(sorted(got) == sorted(wanted), part, f"derivative is of {sorted(wanted)}, got {sorted(got)}")
    for name, expected in wanted.items():
        _require_shape(part, f"derivative.{name}", got[name], shape)
        _require_close(part, f"derivative.{name} agrees with the numerical one", got[name], expected, _TOLERANCE)


def _require_gradient(criterion: Criterion, information: Information) -> None:
    gradient, numerical = criterion.gradient(information), Criterion.gradient(criterion, information)
    _require_shape(criterion, "gradient", gradient, information.matrix.shape)
    factor = np.linalg.cholesky(information.matrix)
    got, expected = (factor.swapaxes(-1, -2) @ g @ factor for g in (gradient, numerical))
    _require_close(criterion, "gradient is symmetric", got, got.swapaxes(-1, -2), 1e-9)
    _require_close(criterion, "gradient agrees with the numerical one", got, expected, _TOLERANCE)


def _require_solutions(optimizer: Optimizer[Any], problem: Problem, result: Result) -> None:
    _require(len(result.solutions) > 0, optimizer, "there is one solution or more")
    for solution in result.solutions:
        n = problem.n if result.survey is None else len(solution.settings)  # a survey is of numbers up to n
        _require_shape(optimizer, "a solution", solution.settings, (n, problem.d))
        _require(
            bool(problem.stand.axes.allows(solution.settings).all()), optimizer, "positions are ones the stand allows"
        )
        loss = problem.loss(solution.settings)
        _require_close(optimizer, "the loss is that of the program", np.array(solution.loss), loss, 1e-9)


def _arrays(stimulus: Stimulus) -> list[Array]:
    return [value for _, value in stimulus.quantities()]
