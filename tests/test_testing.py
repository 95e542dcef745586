"""The checks for plug-in authors find what is wrong with a part."""

from __future__ import annotations

import ast
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import pytest

import parts
import random_search
from acalx.criteria import A, Ceiling, Criterion, D, Inequality, Objectives
from acalx.errors import CompatibilityError, PluginError
from acalx.estimation import Bisquare, Estimator, Huber, Iterated, Loss, Squares
from acalx.models import Comparison, Magnitude, Model, Platform, Residual, ScalarAccel
from acalx.numerics.arrays import Array
from acalx.optimizers import DifferentialEvolution, Exchange, Gradient, Optimizer, Scalarized
from acalx.problem import Problem
from acalx.quantities.information import Information
from acalx.quantities.parameter import Parameter
from acalx.quantities.stimulus import Stimulus
from acalx.schemes import Joint, Parallel, Scheme, Serial
from acalx.search.account import Account
from acalx.search.result import Result
from acalx.sensors import AccelTriad, Polynomial, Sensor
from acalx.stands import PlatformGimbals, Setting, Stand, TwoAxis
from acalx.stands.axes import Axes
from acalx.testing import (
    check_comparison,
    check_criterion,
    check_estimator,
    check_loss,
    check_model,
    check_optimizer,
    check_scheme,
    check_sensor,
    check_stand,
)
from command import run

PARAMETERS = ScalarAccel().parameters


@dataclass(frozen=True)
class Table(Stand):
    """A right stand, to be broken."""

    settings = TwoAxis().settings

    def stimulus(self, settings: Array) -> Stimulus:
        return TwoAxis().stimulus(settings)


class Slow(Table):
    def derivative(self, settings: Array) -> Stimulus:
        right = TwoAxis().derivative(settings)["specific_force"]
        assert right is not None
        return Stimulus(specific_force=1.001 * right)


class Flat(Table):
    def stimulus(self, settings: Array) -> Stimulus:
        return Stimulus(specific_force=settings)


class Mixed(Table):
    def stimulus(self, settings: Array) -> Stimulus:
        force = TwoAxis().stimulus(settings)["specific_force"]
        assert force is not None
        return Stimulus(specific_force=force - force.mean(axis=tuple(range(force.ndim - 2)), keepdims=True))


class Doubled(Table):
    settings = (Setting("roll", 0.0, 1.0), Setting("roll", 0.0, 1.0))


class HalfTurn(Table):
    def stimulus(self, settings: Array) -> Stimulus:
        return TwoAxis().stimulus(settings / 2)


class Nowhere(Axes):
    def random(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        return np.full((*shape, 2), np.nan)


class Strayed(Table):
    @cached_property
    def axes(self) -> Axes:
        return Nowhere(self.settings)


class Mirrored(Table):
    def aim(self, directions: Array) -> Array:
        return TwoAxis().aim(-directions)


class Lost(Table):
    def aim(self, directions: Array) -> Array:
        return TwoAxis().aim(directions)[..., :1]


class Unlike(Table):
    def equivalents(self, settings: Array) -> Array:
        return np.stack([settings, settings + 0.1])


class Swapped(Table):
    def equivalents(self, settings: Array) -> Array:
        return TwoAxis().equivalents(settings)[::-1]


class Outside(Table):
    settings = TwoAxis(alpha1_deg=(-90, 90)).settings

    def equivalents(self, settings: Array) -> Array:
        return TwoAxis().equivalents(settings)


class Bent(Table):
    axis_errors = ("tilt",)

    def misaligned(self, settings: Array, errors: Array) -> Stimulus:
        return TwoAxis().stimulus(settings + errors + 0.01)


class Stiff(Table):
    axis_errors = ("tilt",)


class Tireless(Table):
    speeds = np.array([1.0, 0.0])


@pytest.mark.parametrize(
    ("stand", "message"),
    [
        (Slow(), "Slow breaks a rule: derivative.specific_force agrees with the numerical one"),
        (Flat(), r"Flat breaks a rule: stimulus.specific_force has shape \(3, 5, 3\), got \(3, 5, 2\)"),
        (Mixed(), "Mixed breaks a rule: stimulus of a stack is that of its members"),
        (Doubled(), "Doubled breaks a rule: each setting has its own name"),
        (HalfTurn(), "HalfTurn breaks a rule: a periodic setting a turn on gives the same specific_force"),
        (Strayed(), "Strayed breaks a rule: random is finite"),
        (Mirrored(), "Mirrored breaks a rule: aim brings the vertical where it is told"),
        (Lost(), r"Lost breaks a rule: aim has shape \(3, 5, 2\), got \(3, 5, 1\)"),
        (Unlike(), "Unlike breaks a rule: equivalent settings give the same specific_force"),
        (Swapped(), "Swapped breaks a rule: the given settings come first among the equivalent ones"),
        (Outside(), "Outside breaks a rule: equivalent settings are ones that the stand allows"),
        (Bent(), "Bent breaks a rule: axes off by nothing change nothing of specific_force"),
        (Stiff(), "Stiff breaks a rule: axes that are off change what is felt"),
        (Tireless(), "Tireless breaks a rule: speeds are positive"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_broken_stands(stand: Stand, message: str) -> None:
    check_stand(Table())
    with pytest.raises(AssertionError, match=message):
        check_stand(stand)


class Rows(Model):
    """A right model, to be broken."""

    parameters = PARAMETERS
    needs = ("specific_force",)

    def regressors(self, stimulus: Stimulus) -> Array:
        return ScalarAccel().regressors(stimulus)


class NoOutputs(Rows):
    def regressors(self, stimulus: Stimulus) -> Array:
        return super().regressors(stimulus)[..., 0, :]


class Namesakes(Rows):
    parameters = PARAMETERS[:8] + PARAMETERS[:1]


class Unknown(Rows):
    needs = ("temperature",)


class TooFew(Rows):
    smallest_n = 3


class Careless(Rows):
    def regressors(self, stimulus: Stimulus) -> Array:
        right = super().regressors(stimulus)
        assert "specific_force" in stimulus
        return right + (0.1 if stimulus["specific_force"].ndim > 3 else 0.0)


class Sloppy(Rows):
    def derivative(self, stimulus: Stimulus) -> Stimulus:
        right = ScalarAccel().derivative(stimulus)["specific_force"]
        assert right is not None
        return Stimulus(specific_force=right[..., ::-1])


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (NoOutputs(), r"NoOutputs breaks a rule: regressors has shape \(3, 5, 1, 9\), got \(3, 5, 9\)"),
        (Namesakes(), "Namesakes breaks a rule: each parameter has its own name"),
        (Unknown(), "model Unknown needs the temperature, which stand TwoAxis does not provide"),
        (TooFew(), "TooFew breaks a rule: smallest_n gives as many readings as parameters"),
        (Careless(), "Careless breaks a rule: regressors of a stack is that of its members"),
        (Sloppy(), "Sloppy breaks a rule: derivative.specific_force agrees"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_broken_models(model: Model, message: str) -> None:
    check_model(Rows(), parts.FULL)
    with pytest.raises((AssertionError, CompatibilityError), match=message):
        check_model(model, parts.FULL)


class Upside(Criterion):
    def loss(self, information: Information) -> Array:
        return information.log_det


class Summed(Criterion):
    def loss(self, information: Information) -> Array:
        return np.asarray(-information.log_det.sum())


class Tampering(Criterion):
    def loss(self, information: Information) -> Array:
        loss = -Information(information.matrix.copy(), information.parameters).log_det
        information.matrix[...] *= 1.5
        return loss


class Lopsided(Criterion):
    def loss(self, information: Information) -> Array:
        return -information.log_det

    def gradient(self, information: Information) -> Array:
        return -np.triu(information.covariance)


class Halved(Criterion):
    def loss(self, information: Information) -> Array:
        return -information.log_det

    def gradient(self, information: Information) -> Array:
        return -0.999 * information.covariance


class Forgetful(Criterion):
    def loss(self, information: Information) -> Array:
        return -2 * information.log_det

    def terms(self):  # type: ignore[no-untyped-def]
        return D().terms()


class Leaning(Ceiling):
    """An inequality whose Lagrangian has a wrong slope, gradient or start."""

    right = Inequality("bias")
    log_floor = right.log_floor

    def __init__(self, wrong: str) -> None:
        self.wrong = wrong

    def loss(self, information: Information) -> Array:
        return self.right.loss(information)

    def start(self, parameters, stack):  # type: ignore[no-untyped-def]
        return self.right.start(parameters, stack) + (self.wrong == "start")

    def hold(self, information, log_t, multiplier, penalty):  # type: ignore[no-untyped-def]
        shift = 1.0 if self.wrong == "level" else 0.0
        value, gradient, slope, following = self.right.hold(information, log_t - shift, multiplier, penalty)
        slope = slope * (1.01 if self.wrong == "slope" else 1.0)
        return value, gradient * (1.01 if self.wrong == "gradient" else 1.0), slope, following


@pytest.mark.parametrize(
    ("criterion", "monotone", "message"),
    [
        (Upside(), True, "Upside breaks a rule: more information never hurts"),
        (Summed(), True, r"Summed breaks a rule: loss has shape \(3,\), got \(\)"),
        (Tampering(), True, "Tampering breaks a rule: loss of a stack"),
        (Lopsided(), True, "Lopsided breaks a rule: gradient is symmetric"),
        (Halved(), True, "Halved breaks a rule: gradient agrees with the numerical one"),
        (Forgetful(), True, "Forgetful breaks a rule: the terms add up to the loss"),
        (Leaning("start"), False, "Leaning breaks a rule: start is zeros"),
        (Leaning("level"), False, "Leaning breaks a rule: hold is zero where log t is above the loss"),
        (Leaning("slope"), False, "Leaning breaks a rule: the gradient and slope of hold are right"),
        (Leaning("gradient"), False, "Leaning breaks a rule: the gradient and slope of hold are right"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_broken_criteria(criterion: Criterion, monotone: bool, message: str) -> None:
    check_criterion(Leaning(""), PARAMETERS, monotone=False)
    with pytest.raises(AssertionError, match=message):
        check_criterion(criterion, PARAMETERS, monotone=monotone)


@dataclass
class Spoiled(Optimizer):
    """Gradient descent with one mistake in what it gives back."""

    mistake: str
    count: int = 0

    def search(self, problem: Problem, rng: np.random.Generator, account: Account) -> Result:
        self.count += 1
        if self.mistake == "deaf":
            try:
                return Gradient(starts=8).search(problem, rng, account)
            except KeyboardInterrupt:
                return Gradient(starts=8).search(problem, rng, Account())
        result = Gradient(starts=8).search(problem, rng, account)
        best = result.best
        changed = {
            "loss": replace(best, loss=best.loss - 1e-3),
            "outside": replace(best, settings=best.settings + np.pi),
            "shape": replace(best, settings=best.settings.T),
            "fickle": replace(best, settings=best.settings[:: (-1) ** self.count]),
        }
        if self.mistake in changed:
            return replace(result, solutions=(changed[self.mistake],))
        return {
            "silent": replace(result, message=""),
            "status": replace(result, status="success"),  # type: ignore[arg-type]
            "unsorted": replace(result, solutions=(replace(best, loss=best.loss + 1e-10), best)),
            "unseen": replace(result, history=[]),
        }[self.mistake]


@pytest.mark.parametrize(
    ("mistake", "message"),
    [
        ("loss", "the loss is that of the program"),
        ("outside", "gave positions that the stand can't take: 1, 2"),
        ("shape", r"gave settings of shape \(2, 9\); expected up to \(9, 2\)"),
        ("fickle", "the same seed gives the same result, bit for bit"),
        ("silent", "the message says why"),
        ("status", "gave 2 programs with status 'success'"),
        ("unsorted", "solutions come best first"),
        ("unseen", "the history is of a loss that falls"),
        ("deaf", "lets an interrupt pass, got status 'ok'"),
    ],
)
def test_broken_optimizers(mistake: str, message: str) -> None:
    with pytest.raises((AssertionError, PluginError), match=f"Spoiled (breaks a rule: )?{message}"):
        check_optimizer(Spoiled(mistake), parts.problem(stand=parts.BAND))


class Loosened(Optimizer[Result]):
    """Does not mind what is fixed, or what may not be there twice."""

    def __init__(self, mistake: str) -> None:
        self.mistake = mistake

    def search(self, problem: Problem, rng: np.random.Generator, account: Account) -> Result:
        if self.mistake == "replicates" and not problem.replicates:
            problem = replace(problem, replicates=True)
        found = Gradient(starts=16).search(problem, rng, account)
        settings = found.best.settings
        if self.mistake == "fixed" and problem.held:
            settings = settings[::-1]
        if self.mistake == "replicates" and problem.held:
            settings = np.concatenate([settings[:-1], settings[-2:-1]])
        return found.with_program(settings)


@pytest.mark.parametrize(
    ("mistake", "message"),
    [("fixed", "the fixed positions come first"), ("replicates", "no position occurs again where none may")],
)
def test_optimizers_that_break_restrictions(mistake: str, message: str) -> None:
    check_optimizer(Loosened(""), parts.problem())
    with pytest.raises(AssertionError, match=f"Loosened breaks a rule: {message}"):
        check_optimizer(Loosened(mistake), parts.problem(), restricted=True)


@pytest.mark.parametrize(
    "optimizer",
    [
        Gradient(starts=16),
        DifferentialEvolution(restarts=1, maxiter=40, companions=3),
        Exchange(chains=1, starts=10, patience=2),
    ],
    ids=lambda optimizer: type(optimizer).__name__,
)
def test_optimizers_heed_restrictions(optimizer: Optimizer) -> None:
    stand = TwoAxis(step_deg=30) if isinstance(optimizer, Exchange) else parts.FULL
    check_optimizer(optimizer, parts.problem(n=10, stand=stand), restricted=True)


def test_fronts_heed_restrictions() -> None:
    asked = Problem(parts.FULL, ScalarAccel(), Objectives([D(), A()], ["d", "a"]), 9)
    check_optimizer(Scalarized(points=5, seeds=2, starts=16), asked, restricted=True)


# --- an optimizer of somebody's own ---


def code_lines(path: Path) -> int:
    """Lines without docstrings, imports, comments and blanks."""
    text = path.read_text(encoding="utf-8")
    left_out: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        docstring = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if isinstance(node, ast.Import | ast.ImportFrom) or docstring:
            assert node.end_lineno is not None
            left_out |= set(range(node.lineno, node.end_lineno + 1))
    lines = dict(enumerate(text.splitlines(), 1))
    return sum(bool(lines[k].partition("#")[0].strip()) for k in lines.keys() - left_out)


@pytest.mark.parametrize("stand", [parts.BAND, parts.TABLE_15], ids=repr)
def test_a_new_optimizer_takes_thirty_lines(stand: Stand) -> None:
    assert code_lines(Path(random_search.__file__)) <= 30
    check_optimizer(random_search.RandomSearch(draws=40, polished=3), parts.problem(n=10, stand=stand), restricted=True)


def test_a_new_optimizer_on_the_command_line(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(Path(random_search.__file__).read_text(encoding="utf-8"), encoding="utf-8")
    own = ("optimizer=custom", "optimizer._target_=mine.RandomSearch", "+optimizer.draws=50", "figures=false")
    outcome = run(tmp_path, *own, "criterion=d")
    assert outcome.status == 0, outcome.err
    assert "of 50 random programs polished" in outcome.result["message"]


# --- schemes ---


@dataclass(frozen=True)
class Amiss(Scheme):
    """The joint design with one mistake."""

    mistake: str

    def smallest_n(self, problem: Problem) -> int:
        return 0 if self.mistake == "least" else problem.model.smallest_n

    def solve(self, problem, optimizer, rng, watch=None):  # type: ignore[no-untyped-def]
        found = Joint().solve(problem, optimizer, rng, watch)
        if self.mistake == "fickle":
            seed = np.random.default_rng()
            return replace(found, result=found.result.with_program(seed.permutation(found.result.program)))
        if self.mistake == "long":
            settings = found.result.program
            return replace(found, result=found.result.with_program(np.concatenate([settings, settings])))
        if self.mistake == "deaf" and found.result.status == "interrupted":
            return replace(found, result=found.result.ended("ok", "done"))
        return found


@pytest.mark.parametrize("scheme", [Joint(), Parallel(), Serial()], ids=repr)
def test_schemes(scheme: Scheme) -> None:
    check_scheme(scheme, Problem(PlatformGimbals(), Platform(), D(), 32), Gradient(starts=8))


@pytest.mark.parametrize(
    ("mistake", "message"),
    [
        ("least", "smallest_n is a whole number"),
        ("fickle", "the same seed gives the same program"),
        ("long", "the program has n=9 positions at most, got 18"),
        ("deaf", "lets an interrupt pass, got status 'ok'"),
    ],
)
def test_broken_schemes(mistake: str, message: str) -> None:
    with pytest.raises(AssertionError, match=f"Amiss breaks a rule: {message}"):
        check_scheme(Amiss(mistake), parts.problem(stand=parts.BAND), Gradient(starts=8))


# --- sensors, comparisons, estimators, losses ---


@dataclass(frozen=True)
class Crooked(Polynomial):
    """A triad with one mistake."""

    mistake: str
    channels = AccelTriad().channels
    terms = AccelTriad().terms
    senses = ("specific_force",)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        right = tuple(term.parameter for term in self.terms if term.parameter)
        return right[:8] + right[:1] if self.mistake == "names" else right

    def readings(self, parameters: Array, stimulus: Stimulus) -> Array:
        right = AccelTriad().readings(parameters, stimulus)
        wrong = {
            "order": right + 1e-3 * np.arange(right.shape[-2])[:, None],
            "shape": right[..., :2],
            "stack": right + (1e-3 if right.ndim > 2 else 0.0),
            "nan": right * np.nan,
        }
        return np.asarray(wrong.get(self.mistake, right))

    def by_parameters(self, parameters: Array, stimulus: Stimulus) -> Array:
        right = AccelTriad().by_parameters(parameters, stimulus)
        return 1.01 * right if self.mistake == "by_parameters" else right

    def by_stimulus(self, parameters: Array, stimulus: Stimulus) -> dict[str, Array]:
        right = AccelTriad().by_stimulus(parameters, stimulus)
        return {name: slope + (self.mistake == "by_stimulus") for name, slope in right.items()}


@pytest.mark.parametrize(
    ("mistake", "message"),
    [
        ("names", "each parameter has its own name"),
        ("order", "a position's readings depend on it alone"),
        ("shape", r"readings has shape \(3, 5, 3\), got \(3, 5, 2\)"),
        ("stack", "readings of a stack are those of its members"),
        ("nan", "readings is finite"),
        ("by_parameters", "by_parameters agrees with the numerical derivatives"),
        ("by_stimulus", "by_stimulus agrees with the numerical derivative by specific_force"),
    ],
)
def test_broken_sensors(mistake: str, message: str) -> None:
    check_sensor(Crooked(""), parts.FULL)
    with pytest.raises(
        (AssertionError, PluginError), match=f"Crooked.*{message}|Crooked.parameters: bias_x is there twice"
    ):
        check_sensor(Crooked(mistake), parts.FULL)


@dataclass(frozen=True)
class Astray(Comparison):
    """The magnitude with one mistake."""

    mistake: str

    def check(self, sensor: Sensor) -> None:
        Magnitude().check(sensor)

    def count(self, sensor: Sensor) -> int:
        return 1

    def residual(self, sensor: Sensor, parameters: Array, readings: Array, known: Stimulus | None) -> Residual:
        value, rows, by_readings = Magnitude().residual(sensor, parameters, readings, known)
        assert by_readings is not None
        return Residual(
            value + (1e-3 if self.mistake == "shift" else 0.0),
            rows * (1.01 if self.mistake == "rows" else 1.0),
            by_readings * (1.01 if self.mistake == "noise" else 1.0),
        )


@pytest.mark.parametrize(
    ("mistake", "message"),
    [
        ("shift", "the right parameters leave nothing"),
        ("rows", "rows say how much of it a parameter takes off"),
        ("noise", "by_readings are its derivatives by the readings"),
    ],
)
def test_broken_comparisons(mistake: str, message: str) -> None:
    check_comparison(Astray(""), AccelTriad(), parts.FULL)
    with pytest.raises(AssertionError, match=f"Astray breaks a rule: {message}"):
        check_comparison(Astray(mistake), AccelTriad(), parts.FULL)


@dataclass(frozen=True)
class Weighed(Loss):
    """Huber's loss with one mistake."""

    mistake: str

    def weight(self, u: Array) -> Array:
        scale = {"large": 2.0, "slope": 1.0}.get(self.mistake, 1.0)
        return scale * Huber().weight(u)

    def slope(self, u: Array) -> Array:
        return Huber().slope(u) * (0.9 if self.mistake == "slope" else 1.0)

    @property
    def first(self) -> Loss | None:
        return Bisquare() if self.mistake == "first" else None


@pytest.mark.parametrize(
    ("mistake", "message"),
    [
        ("large", "the weight of a residual of zero is 1"),
        ("slope", "slope is the derivative of u times the weight"),
        ("first", "what it starts from has a single minimum"),
    ],
)
def test_broken_losses(mistake: str, message: str) -> None:
    check_loss(Weighed(""))
    with pytest.raises(AssertionError, match=f"Weighed breaks a rule: {message}"):
        check_loss(Weighed(mistake))


@dataclass(frozen=True)
class Biased(Estimator):
    """Iterated least squares with one mistake."""

    mistake: str
    comparison: Comparison | None = None
    loss: Loss = field(default_factory=Squares)
    tolerance: float = 1e-10
    iterations: int = 50

    def linearization(self, model, measurement, stimulus):  # type: ignore[no-untyped-def]
        right = Iterated().linearization(model, measurement, stimulus)
        if self.mistake == "stack" and len(measurement) > 1:
            measurement = measurement + 1e-6 * np.arange(len(measurement))[:, None, None]
            right = Iterated().linearization(model, measurement, stimulus)

        def linearize(parameters: Array) -> tuple[Array, Array]:
            left, rows = right(parameters)
            if self.mistake == "slow":
                return left, 10.0 * rows  # a tenth of each step
            if self.mistake == "proud":
                return 2.0 * left, 2.0 * rows
            return (left + 1e-4 if self.mistake == "shift" else left), rows

        return linearize


@pytest.mark.parametrize(
    ("mistake", "message"),
    [
        ("shift", "parameters are right to first order"),
        ("slow", "steps become small where there is no noise"),
        ("proud", "standard errors are the scatter of the estimates"),
        ("stack", "parameters are right to first order|the parameters of a stack are as of its members"),
    ],
)
def test_broken_estimators(mistake: str, message: str) -> None:
    check_estimator(Biased(""), ScalarAccel(), parts.FULL)
    with pytest.raises(AssertionError, match=f"Biased breaks a rule: ({message})"):
        check_estimator(Biased(mistake), ScalarAccel(), parts.FULL)
