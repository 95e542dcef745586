"""Every part that the configuration offers, times every invariant; a new YAML is tested without a new line here."""

from __future__ import annotations

import hashlib
import itertools
import json
import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from acalx.bounds import certify
from acalx.criteria import A, D, Objectives
from acalx.errors import ArgumentError, CompatibilityError, NoProgramError
from acalx.estimation import Estimator
from acalx.models import Model, ScalarAccel, as_model
from acalx.problem import Problem
from acalx.search.result import Front, Result
from acalx.stands import TwoAxis
from acalx.testing import (
    check_criterion,
    check_estimator,
    check_loss,
    check_model,
    check_optimizer,
    check_stand,
)
from configured import names, part, parts_of
from parts import fits

MODEL = ScalarAccel(groups=("bias", "scale"))
FIXED = np.array([[0.3, 0.1], [1.2, 2.0]])
# Each way in which a problem can be other than plain; n is small, so that every optimizer is quick.
PROBLEMS = {
    "plain": Problem(TwoAxis(), MODEL, D(), 7),
    "limits": Problem(TwoAxis(alpha1_deg=(-60, 100), alpha2_deg=(-80, 70)), MODEL, D(), 7),
    "steps": Problem(TwoAxis(step_deg=30), MODEL, D(), 7),
    "a step in one angle": Problem(TwoAxis(step_deg=(30, None)), MODEL, D(), 7),
    "fixed positions": Problem(TwoAxis(), MODEL, D(), 8, FIXED),
    "no replicates": Problem(TwoAxis(step_deg=45), MODEL, D(), 7, replicates=False),
    "a box": Problem(TwoAxis(forbidden=[{"alpha1_deg": (80, 100), "alpha2_deg": (10, 60)}]), MODEL, D(), 7),
    "objectives": Problem(TwoAxis(), MODEL, Objectives([D(), A()]), 7),
}
REFUSED = (CompatibilityError, ArgumentError)
# What optimizers refuse beside one criterion where they take several, and the other way round.
STEPPED = {"steps", "a step in one angle", "no replicates"}
REFUSED_BY = {"gradient": STEPPED}
# Regular sequences that leave these limits and stops.
NOT_REGULAR = {("traversal", "limits"), ("traversal", "steps")}
CONCAVE = {"d", "a", "e", "target"}
# Seeds of random matrices that are not near a kink, where there is no gradient to compare.
SEEDS = {"inequality_bias": 1}
# Criteria that are no maximum of information: one more position may make them worse.
UNEQUAL = tuple(name for name in names("criterion") if "fair" in name or "inequality" in name)


@pytest.mark.parametrize("name", names("stand"))
def test_stands(name):
    check_stand(part("stand", name))


@pytest.mark.parametrize("name", names("model"))
def test_models(name):
    model = as_model(part("model", name))
    stands = [*parts_of("stand").values(), TwoAxis(dip_deg=60)]
    fitting = [stand for stand in stands if fits(model, stand)]
    assert fitting
    check_model(model, fitting[0])


@pytest.mark.parametrize("name", names("criterion"))
def test_criteria(name):
    criterion = part("criterion", name)
    check_criterion(criterion, ScalarAccel().parameters, monotone=name not in UNEQUAL, seed=SEEDS.get(name, 0))


def fitting_model(estimator: Estimator) -> Model:
    """The first model of the configuration whose readings have what an estimator compares, and that a table turns."""
    for model in map(as_model, parts_of("model").values()):
        try:
            estimator.model_for(model)
        except CompatibilityError:
            continue
        if fits(model, TwoAxis()):
            return model
    raise AssertionError(f"no model fits {estimator}")


@pytest.mark.parametrize("name", names("estimator"))
def test_estimators(name):
    estimator = part("estimator", name)
    model = fitting_model(estimator)
    check_loss(estimator.loss)
    check_estimator(estimator, model, TwoAxis())


@pytest.mark.parametrize(("name", "problem"), list(itertools.product(names("optimizer"), PROBLEMS)))
def test_optimizers_solve_or_refuse_before_any_work(name, problem):
    optimizer, asked = part("optimizer", name), PROBLEMS[problem]
    seen = []
    if optimizer.several != (problem == "objectives") or problem in REFUSED_BY.get(name, ()):
        with pytest.raises(REFUSED):
            optimizer.solve(asked, np.random.default_rng(0), seen.append)
        assert not seen, "refused after it had begun"
        return
    if (name, problem) in NOT_REGULAR:
        with pytest.raises(NoProgramError):
            optimizer.solve(asked, np.random.default_rng(0))
        return
    found = optimizer.solve(asked, np.random.default_rng(0), seen.append)
    assert isinstance(found, Front if problem == "objectives" else Result)
    assert replace(asked, n=len(found.program)).restrictions.permits(found.program)  # traversal may take fewer
    assert asked.stand.axes.allows(found.program[asked.held :]).all()
    if asked.fixed is not None:
        np.testing.assert_array_equal(found.program[: asked.held], asked.fixed)


@pytest.mark.parametrize("name", names("optimizer"))
def test_contract_of_optimizers(name):
    optimizer = part("optimizer", name)
    several = "objectives" if optimizer.several else "plain"
    check_optimizer(optimizer, PROBLEMS["steps" if name == "exchange" else several])


@pytest.mark.parametrize(
    ("name", "criterion"),
    [(o, c) for o in names("optimizer") for c in names("criterion") if not part("optimizer", o).several],
)
def test_no_optimizer_gets_below_the_bound(name, criterion):
    """Every optimizer with every criterion ends above its bound, or is refused."""
    model = ScalarAccel()
    problem = Problem(
        TwoAxis(step_deg=45) if name == "exchange" else TwoAxis(), model, part("criterion", criterion), 10
    )
    optimizer = part("optimizer", name)
    if name == "convex" and criterion not in CONCAVE:
        with pytest.raises(REFUSED):
            optimizer.solve(problem, np.random.default_rng(1))
        return
    found = optimizer.solve(problem, np.random.default_rng(1))
    certificate = certify(replace(problem, n=len(found.program)), found.program)  # traversal may take fewer
    assert certificate.bound is not None, certificate.reason
    assert certificate.gap >= -1e-9
    if certificate.efficiency is not None:
        assert certificate.efficiency <= 1.0 + 1e-9


def programs() -> dict[str, str]:
    """A digest of what each optimizer finds, by the seed alone."""
    found = {}
    for name, optimizer in parts_of("optimizer").items():
        problem = PROBLEMS["objectives" if optimizer.several else "steps" if name == "exchange" else "plain"]
        result = optimizer.solve(problem, np.random.default_rng(7))
        found[name] = hashlib.sha256(result.program.tobytes()).hexdigest()
    return found


def test_the_same_seed_gives_the_same_program_in_another_process():
    code = "import json, test_contracts; print(json.dumps(test_contracts.programs()))"
    out = subprocess.run(
        [sys.executable, "-c", code], cwd=Path(__file__).parent, capture_output=True, text=True, check=True
    )
    assert json.loads(out.stdout) == programs()


def built_with_lists() -> list[tuple[str, str, str]]:
    """Groups, options and fields of the parts of the configuration that hold lists or mappings."""
    found = []
    for group in ("stand", "model", "criterion", "optimizer", "scheme", "errors"):
        for name, one in parts_of(group).items():
            for option in fields(one):
                if isinstance(getattr(one, option.name), list | tuple | dict):
                    found.append((group, name, option.name))
    return found


@pytest.mark.parametrize(("group", "name", "option"), built_with_lists())
def test_parts_keep_what_they_are_given(group, name, option):
    """Lists are as tuples, and what is changed later changes no part."""
    one = part(group, name)
    value = getattr(one, option)
    given = dict(value) if isinstance(value, dict) else list(value)
    again = replace(one, **{option: given})
    assert again == one
    assert not isinstance(getattr(again, option), list)
    given.clear()
    assert again == one
