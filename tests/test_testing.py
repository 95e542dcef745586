"""The checks for plug-in authors find what is wrong with a part."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

import parts
from acalx.criteria import Ceiling, Criterion, D, Inequality
from acalx.models import Model, ScalarAccel
from acalx.numerics.arrays import Array
from acalx.optimizers import Gradient, Optimizer
from acalx.problem import Problem
from acalx.quantities.information import Information
from acalx.quantities.stimulus import Stimulus
from acalx.search.account import Account
from acalx.search.result import Result
from acalx.stands import Setting, Stand, TwoAxis
from acalx.stands.axes import Axes
from acalx.testing import check_criterion, check_model, check_optimizer, check_stand

PARAMETERS = ScalarAccel().parameters


@dataclass(frozen=True)
class Table(Stand):
    """A right stand, to be broken."""

    settings = TwoAxis().settings

    def stimulus(self, settings: Array) -> Stimulus:
        return TwoAxis().stimulus(settings)


class Slow(Table):
    def derivative(self, settings: Array) -> Stimulus:
        right = TwoAxis().derivative(settings).specific_force
        assert right is not None
        return Stimulus(specific_force=1.001 * right)


class Flat(Table):
    def stimulus(self, settings: Array) -> Stimulus:
        return Stimulus(specific_force=settings)


class Mixed(Table):
    def stimulus(self, settings: Array) -> Stimulus:
        force = TwoAxis().stimulus(settings).specific_force
        assert force is not None
        return Stimulus(specific_force=force - force.mean(axis=tuple(range(force.ndim - 2)), keepdims=True))


class Doubled(Table):
    settings = (Setting("roll", 0.0, 1.0), Setting("roll", 0.0, 1.0))


class HalfTurn(Table):
    def stimulus(self, settings: Array) -> Stimulus:
        return TwoAxis().stimulus(settings / 2)


class AstrayAxes(Axes):
    def random(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        return np.full((*shape, 2), np.nan)


class Strayed(Table):
    axes = AstrayAxes(Table.settings)


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
        assert stimulus.specific_force is not None
        return right + (0.1 if stimulus.specific_force.ndim > 3 else 0.0)


class Sloppy(Rows):
    def derivative(self, stimulus: Stimulus) -> Stimulus:
        right = ScalarAccel().derivative(stimulus).specific_force
        assert right is not None
        return Stimulus(specific_force=right[..., ::-1])


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (NoOutputs(), r"NoOutputs breaks a rule: regressors has shape \(3, 5, 1, 9\), got \(3, 5, 9\)"),
        (Namesakes(), "Namesakes breaks a rule: each parameter has its own name"),
        (Unknown(), "Unknown breaks a rule: needs names quantities among"),
        (TooFew(), "TooFew breaks a rule: smallest_n=3 gives fewer readings"),
        (Careless(), "Careless breaks a rule: regressors of a stack is that of its members"),
        (Sloppy(), "Sloppy breaks a rule: derivative.specific_force agrees"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_broken_models(model: Model, message: str) -> None:
    check_model(Rows(), parts.FULL)
    with pytest.raises(AssertionError, match=message):
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
        ("outside", "positions are ones the stand allows"),
        ("shape", r"a solution has shape \(9, 2\), got \(2, 9\)"),
        ("fickle", "the same seed gives the same result, bit for bit"),
        ("silent", "the message says why"),
        ("status", "status is ok or limit, got 'success'"),
        ("unsorted", "solutions come best first"),
        ("unseen", "the history is of a loss that falls"),
        ("deaf", "lets an interrupt pass, got status 'ok'"),
    ],
)
def test_broken_optimizers(mistake: str, message: str) -> None:
    with pytest.raises(AssertionError, match=f"Spoiled breaks a rule: {message}"):
        check_optimizer(Spoiled(mistake), parts.problem(stand=parts.BAND))
