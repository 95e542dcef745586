"""Python can do what the command line can: the same program, to the byte, in a few lines."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import numpy as np
import pytest

import acalx
from acalx.errors import ArgumentError, CompatibilityError, PluginError
from acalx.recording import RunDirectory
from command import run

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
# Command lines, each with the Python that does the same.
PAIRS = re.findall(r"```sh\nacalx run ([^\n]*)\n```\n\n```python\n(import acalx\n.*?)```", README, re.DOTALL)


def test_there_is_python_beside_the_command_lines():
    together = " ".join(command for command, _ in PAIRS)
    for option in ("certificate", "orient=", "order=", "n=auto", "optimizer=gradient"):
        assert option in together
    for _, code in PAIRS:
        assert len([line for line in code.splitlines() if line.strip()]) <= 4


@pytest.mark.parametrize(("command", "code"), PAIRS, ids=[command for command, _ in PAIRS])
def test_the_same_program_from_python_as_from_the_shell(tmp_path, monkeypatch, capsys, command, code):
    arguments = [argument.strip("'") for argument in re.findall(r"'[^']*'|\S+", command)]
    outcome = run(tmp_path, *arguments, "figures=false")
    assert outcome.status == 0, outcome.err
    empty = tmp_path / "empty"
    empty.mkdir()
    monkeypatch.chdir(empty)
    names: dict[str, acalx.Designed] = {}
    exec(code, names)
    designed = names["designed"]
    assert list(empty.iterdir()) == []
    assert capsys.readouterr() == ("", "")
    RunDirectory(tmp_path / "python", []).write_program(designed.problem.stand, designed.program)
    assert (tmp_path / "python" / "program.csv").read_bytes() == (outcome.directory / "program.csv").read_bytes()
    assert (designed.certificate is None) == (outcome.result["certificate"] is None)
    if designed.certificate is not None:
        assert designed.certificate.efficiency == pytest.approx(outcome.result["certificate"]["efficiency"], rel=1e-12)


def test_evaluate_gives_what_the_command_gives(tmp_path):
    outcome = run(tmp_path, "program=faces_and_edges_18", "criterion=d", "figures=false", entry="evaluate")
    evaluation = acalx.evaluate("faces_and_edges_18", acalx.TwoAxis(), acalx.ScalarAccel(), acalx.D())
    assert evaluation.loss == outcome.result["loss"]
    assert evaluation.metrics["theta"] == outcome.metrics["theta"]
    assert evaluation.certificate.entries() == outcome.result["certificate"]


def test_a_program_that_is_singular_or_out_of_reach_says_so():
    table = acalx.TwoAxis(alpha1_deg=(-10, 100), alpha2_deg=(-45, 45))
    evaluation = acalx.evaluate(np.zeros((9, 2)), table, acalx.ScalarAccel())
    assert evaluation.status == "singular"
    assert evaluation.inestimable
    assert evaluation.loss == np.inf
    outside = acalx.evaluate("icosahedron_12", table, acalx.ScalarAccel())
    assert outside.outside
    assert outside.certificate is None


def test_errors_speak_of_arguments():
    problem = acalx.Problem(acalx.TwoAxis(step_deg=15), acalx.ScalarAccel(), acalx.D(), n=9)
    with pytest.raises(CompatibilityError, match=r"use optimizer=Exchange\(\)"):
        acalx.design(problem, acalx.Gradient())
    with pytest.raises(ArgumentError, match="seed"):
        acalx.design(problem, seed=-1)
    with pytest.raises(CompatibilityError, match="stops at steps only"):
        acalx.design(problem, orient=acalx.A())


def test_several_objectives_have_a_front_and_no_certificate():
    problem = acalx.Problem(acalx.TwoAxis(), acalx.ScalarAccel(), acalx.Objectives([acalx.D(), acalx.A()]), n=9)
    designed = acalx.design(problem, acalx.Scalarized(points=5, starts=8, seeds=2))
    assert isinstance(designed.result, acalx.Front)
    assert designed.certificate is None
    with pytest.raises(ArgumentError, match="several objectives"):
        acalx.design(problem, certificate=True)


def test_an_order_dependent_model_is_called_what_it_is(tmp_path, monkeypatch):
    """Its loss is another when positions are sorted: no result that contradicts itself."""
    (tmp_path / "drifting.py").write_text(
        "import dataclasses\nimport numpy as np\nfrom acalx.models import Model, ScalarAccel\n\n\n"
        "@dataclasses.dataclass(frozen=True)\nclass Drifting(Model):\n"
        "    parameters = ScalarAccel().parameters\n    needs = ('specific_force',)\n\n"
        "    def regressors(self, stimulus):\n"
        "        rows = ScalarAccel().regressors(stimulus)\n"
        "        n = rows.shape[-3]\n"
        "        return rows / (1.0 + np.arange(n) / n)[:, None, None]\n"
    )
    model = ("model=custom", "model._target_=drifting.Drifting")
    outcome = run(tmp_path, *model, "criterion=d", "optimizer=gradient", "n=12", "figures=false")
    assert outcome.status == 1
    assert outcome.result["status"] == "failed"
    assert "order of the positions" in outcome.result["message"]
    assert "order of the positions" in outcome.err
    assert (outcome.directory / "program.csv").exists()
    monkeypatch.syspath_prepend(tmp_path)
    model = importlib.import_module("drifting").Drifting()
    with pytest.raises(PluginError, match=r"does model Drifting .* depend on the order of the positions"):
        acalx.design(acalx.Problem(acalx.TwoAxis(), model, acalx.D(), 12), acalx.Gradient())


def test_what_can_not_end_well_is_refused_before_the_search():
    """Nothing is searched for that could not be put in order, counted or certified afterwards."""
    seen = []
    problem = acalx.Problem(acalx.TwoAxis(), acalx.ScalarAccel(), acalx.D(), n=501)
    with pytest.raises(ArgumentError, match="order='shortest': 501 positions are too many to sort; 500 are the most"):
        acalx.design(problem, acalx.Gradient(), order="shortest", watch=seen.append)
    several = acalx.Problem(acalx.TwoAxis(), acalx.ScalarAccel(), acalx.Objectives([acalx.D(), acalx.A()]), n=9)
    with pytest.raises(CompatibilityError, match="several objectives have no smallest number of positions"):
        acalx.design(several, target={"bias": 0.5}, watch=seen.append)
    with pytest.raises(ArgumentError, match="scheme=0: must be a Scheme"):
        acalx.design(problem, scheme=0, watch=seen.append)
    with pytest.raises(ArgumentError, match="certificate='no': must be true or false"):
        acalx.evaluate("icosahedron_12", acalx.TwoAxis(), acalx.ScalarAccel(), certificate="no")
    assert not seen


def test_all_programs_that_a_search_gives_are_looked_at_anew(tmp_path, monkeypatch):
    """Not the first alone: the turned one of a pair and the knee of a front may be right where others are not."""
    (tmp_path / "places.py").write_text(
        "import dataclasses\nimport numpy as np\nfrom acalx.models import Model, ScalarAccel\n\n\n"
        "@dataclasses.dataclass(frozen=True)\nclass Places(Model):\n"
        "    parameters = ScalarAccel().parameters\n    needs = ('specific_force',)\n\n"
        "    def regressors(self, stimulus):\n"
        "        rows = ScalarAccel().regressors(stimulus)\n"
        "        return rows * np.where(np.arange(rows.shape[-3]) == 0, 3.0, 1.0)[:, None, None]\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    model = importlib.import_module("places").Places()
    alone = acalx.Problem(acalx.TwoAxis(), model, acalx.D(), 11)
    with pytest.raises(PluginError, match="order of the positions"):
        acalx.design(alone, acalx.Gradient(starts=4), orient=acalx.A())
    several = acalx.Problem(acalx.TwoAxis(), model, acalx.Objectives([acalx.A(), acalx.E()]), 11)
    with pytest.raises(PluginError, match="order of the positions"):
        acalx.design(several, acalx.Scalarized(points=6, starts=8, seeds=3))


def test_what_an_optimizer_gives_is_looked_at():
    class Nothing(acalx.Optimizer):
        def search(self, problem, rng, account):
            return None

    problem = acalx.Problem(acalx.TwoAxis(), acalx.ScalarAccel(), acalx.D(), 9)
    with pytest.raises(PluginError, match="optimizer Nothing gave NoneType; expected a Result"):
        acalx.design(problem, Nothing())


def test_a_run_that_fails_after_it_was_recorded_says_so(tmp_path):
    (tmp_path / "broken.py").write_text(
        "from acalx.criteria import A, Concave\n\n\n"
        "class Broken(Concave):\n"
        "    def loss(self, information):\n        return A().loss(information)\n\n"
        "    def degree(self, p):\n        raise RuntimeError('degree broke')\n"
    )
    own = ("criterion=custom", "criterion._target_=broken.Broken", "optimizer=gradient", "figures=false")
    outcome = run(tmp_path, *own)
    assert outcome.status == 1
    assert outcome.result["status"] == "failed"
    assert "degree broke" in outcome.result["message"]
    assert outcome.result["metrics"]["D"] > 0
    assert len(outcome.rows()) == 9
