"""Sweeps, refused command lines, the console script, completion, and that every YAML builds."""

import json
import math
import os
import re
import shutil
from dataclasses import MISSING, asdict, fields, is_dataclass
from functools import partial
from importlib import resources
from pathlib import Path

import hydra
import pytest
from omegaconf import OmegaConf

import acalx
from acalx.criteria import Criterion, D
from acalx.estimation import Estimator, StaticIntervals, Unit
from acalx.models import Model
from acalx.optimizers import Optimizer
from acalx.schemes import Scheme
from acalx.sensors import Sensor
from acalx.simulation import ErrorSources
from acalx.stands import Stand
from command import SCRIPT, Outcome, assert_refused, execute, finish, run, start, together

QUICK = ("optimizer=gradient", "figures=false")
RUN = ("python", "-m", "acalx.run")
BASH = shutil.which("bash")


# ---------------------------------------------------------------- sweeps

SWEEPS = {
    "all": ("criterion=d,d_fair", "optimizer=de,gradient", "n=9,12", "figures=false"),
    "bad n": ("n=9,abc", *QUICK),
    "bad option": ("criterion=d,bogus", *QUICK),
    "option of one": ("optimizer=de,gradient", "optimizer.popsize=4", "criterion=d", "figures=false"),
    "bad first": ("stand.alpha1_deg=[45,-45],[-45,45]", "criterion=d", "seed=0,1", *QUICK),
    "none": ("nn=9,10", *QUICK),
}


@pytest.fixture(scope="module")
def sweeps(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweeps")
    calls = [partial(execute, folder / name, *RUN, "-m", *arguments) for name, arguments in SWEEPS.items()]
    for name in SWEEPS:
        (folder / name).mkdir()
    return dict(zip(SWEEPS, together(calls), strict=True))


def results_of(sweep: Outcome) -> dict[str, dict]:
    (directory,) = (sweep.directory / "multirun").iterdir()
    return {path.parent.name: json.loads(path.read_text()) for path in sorted(directory.glob("*/result.json"))}


def table_of(sweep: Outcome) -> list[list[str]]:
    """Number and status of each job, as the table at the end says."""
    body = sweep.out.partition("job  status")[2].splitlines()[1:-1]
    assert sweep.out.splitlines()[-1].startswith(f"{len(body)} jobs in multirun")
    return [line.split()[:2] for line in body]


def test_a_sweep_records_each_job(sweeps):
    sweep = sweeps["all"]
    assert sweep.status == 0, sweep.err
    results = results_of(sweep)
    assert sorted(results) == [str(k) for k in range(8)]
    expected = [
        [f"criterion={criterion}", f"optimizer={optimizer}", f"n={n}"]
        for criterion in ("d", "d_fair")
        for optimizer in ("de", "gradient")
        for n in (9, 12)
    ]
    assert [results[str(k)]["overrides"][:3] for k in range(8)] == expected
    assert {result["status"] for result in results.values()} == {"ok"}
    assert table_of(sweep) == [[str(k), "ok"] for k in range(8)]
    for first in ("0", "1", "4", "5"):  # both optimizers reach the same
        second = str(int(first) + 2)
        assert results[first]["loss"] == pytest.approx(results[second]["loss"], abs=1e-5)


@pytest.mark.parametrize(
    ("name", "statuses", "phrases"),
    [
        ("bad n", ["ok", "failed"], ("n=abc", "whole number")),
        ("bad option", ["ok", "failed"], ("criterion=bogus", "d_fair")),
        ("option of one", ["ok", "failed"], ("optimizer.popsize", "agreement, batch, iterations, starts, tolerance")),
        ("bad first", ["failed", "failed", "ok", "ok"], ("stand.alpha1_deg=[45,-45]", "lower bound")),
        ("none", ["failed", "failed"], ("nn: there is no such option; did you mean n?",)),
    ],
)
def test_a_failing_job_does_not_hide_the_others(sweeps, name, statuses, phrases):
    sweep = sweeps[name]
    assert sweep.status == 1
    assert "Traceback" not in sweep.err
    results = results_of(sweep)
    assert [result["status"] for result in results.values()] == statuses
    assert table_of(sweep) == [[str(k), status] for k, status in enumerate(statuses)]
    messages = [result["message"] for result in results.values() if result["status"] == "failed"]
    assert sweep.complaints == "".join(f"acalx: {message}\n" for message in messages)
    for message in messages:
        for phrase in phrases:
            assert phrase in message


def test_simultaneous_sweeps_never_share_a_directory(tmp_path):
    processes = [start(tmp_path, *RUN, "-m", "n=9,10", "criterion=d", *QUICK) for _ in range(3)]
    outcomes = [finish(process, tmp_path) for process in processes]
    assert [outcome.status for outcome in outcomes] == [0, 0, 0]
    assert len(list((tmp_path / "multirun").glob("*/*/result.json"))) == 6
    assert len(list((tmp_path / "multirun").iterdir())) == 3


# ---------------------------------------------------------------- refused command lines

MINE = """
import numpy as np

from acalx.criteria import Criterion

class Shape(Criterion):
    def loss(self, information): return np.zeros(3)

class Raises(Criterion):
    def loss(self, information): raise RuntimeError("no luck today")

class Nan(Criterion):
    def loss(self, information): return np.full(information.matrix.shape[:-2], np.nan)

class NoCriterion:
    pass

class Begins(Criterion):
    def __init__(self): raise RuntimeError("can't begin")
    def loss(self, information): return 0.0
"""


def custom(name: str, *rest: str) -> tuple[str, ...]:
    return ("criterion=custom", f"criterion._target_={name}", *rest)


# arguments, then what the message must hold: what was given, and what would be right
REFUSED: list[tuple[tuple[str, ...], tuple[str, ...]]] = [
    (("n=8",), ("n=8", "9 positions or more")),
    (("n=0",), ("n=0", "9 positions or more")),
    (("objectives=[d,custom]",), ("objectives.custom._target_ is missing", "FOLDER/criterion/NAME.yaml")),
    (("objectives=[d,custom]", "objectives.custom._target_=mine.D"), ("Index 'custom'",)),
    (("orient=custom", "criterion=d"), ("orient._target_ is missing", "--config-dir=FOLDER")),
    (("objectives=[d,a,e]", "optimizer=scalarized", "optimizer.points=2"), ("optimizer.points=2: a front of 3",)),
    (("n=-3",), ("n=-3", "9 positions or more")),
    (("n=abc",), ("n=abc", "whole number")),
    (("n=9.5",), ("n=9.5", "whole number")),
    (("n=nan",), ("n=nan", "whole number")),
    (("n=[9]",), ("n=[9]", "whole number")),
    (("n=",), ("n=", "whole number")),
    (("n=1e9",), ("n=1000000000", "GB of memory", "is the most")),
    (("n=1000000000",), ("n=1000000000", "GB of memory", "is the most")),
    (("seed=-1",), ("seed=-1", "whole number, 0 or more")),
    (("seed=x",), ("seed=x", "whole number, 0 or more")),
    (("criterion=dfair",), ("criterion=dfair", "did you mean d_fair?")),
    (("criterion=bogus",), ("criterion=bogus", "a, a_fair, custom, d, d_fair, e, e_fair")),
    (("criterion=my/own",), ("criterion=my/own", "d_fair")),
    (("optimizer=gradint",), ("optimizer=gradint", "did you mean gradient?")),
    (("stand=two_axes",), ("stand=two_axes", "did you mean two_axis?")),
    (("model=scaler_accel",), ("model=scaler_accel", "did you mean scalar_accel?")),
    (("modle=scalar_accel",), ("modle", "did you mean model?")),
    (("sed=3",), ("sed", "did you mean seed?")),
    (("+sed=3",), ("sed", "did you mean seed?")),
    (("optimizer.popsiz=4",), ("optimizer.popsiz", "did you mean popsize?")),
    (("stand.alpha3_deg=[0,1]",), ("stand.alpha3_deg", "alpha1_deg, alpha2_deg")),
    (("optimizer=de,gradient",), ("optimizer=de,gradient", "-m")),
    (("stand=null",), ("stand=null", "name")),
    (("~criterion",), ("criterion", "criterion=NAME")),
    (("word",), ("'word'", "key=value")),
    (("n=[9",), ("'n=[9'", "key=value")),
    (("figures=maybe",), ("figures", "maybe", "true or false")),
    (("optimizer.popsize=x",), ("popsize=x", "whole number")),
    (("optimizer.strategy=x",), ("strategy=x", "best1bin")),
    (("stand.alpha2_deg=[45,-45]",), ("stand.alpha2_deg=[45,-45]", "lower bound must be below")),
    (("stand.alpha2_deg=[30,30]",), ("stand.alpha2_deg=[30,30]", "lower bound must be below")),
    (("stand.alpha1_deg=[nan,3]",), ("stand.alpha1_deg=[nan,3]", "finite")),
    (("stand.alpha1_deg=[0,inf]",), ("stand.alpha1_deg=[0,inf]", "finite")),
    (("stand.alpha1_deg=5",), ("alpha1_deg=5", "[-180,180]")),
    (("stand.step_deg=-15",), ("step_deg=-15", "positive")),
    (("stand.step_deg=nan",), ("step_deg=nan", "number of degrees")),
    (("stand.alpha2_deg=[1,14]", "stand.step_deg=15"), ("stand.alpha2_deg=[1,14]", "no multiple of the step of 15")),
    (("optimizer=gradient", "stand.step_deg=15"), ("Gradient", "TwoAxis", "optimizer=exchange")),
    (("optimizer=gradient", "stand.alpha1_deg=[0,1e-9]"), ("alpha1_deg=[0,1e-09]", "can estimate all the parameters")),
    (custom("mine.Shape"), ("Shape.loss", "(3,)", "expected")),
    (custom("mine.Shape", "optimizer=gradient"), ("Shape.loss", "(3,)", "expected")),
    (custom("mine.Raises"), ("Raises.loss", "RuntimeError", "no luck today", "mine.py, line 10")),
    (custom("mine.Raises", "optimizer=gradient"), ("Raises.loss", "no luck today", "mine.py")),
    (custom("mine.Nan", "optimizer=gradient"), ("Nan.loss", "nan")),
    (custom("mine.NoCriterion"), ("mine.NoCriterion", "acalx.criteria.Criterion")),
    (custom("mine.Begins"), ("mine.Begins", "can't begin")),
    (custom("mine.Absent"), ("mine.Absent",)),
    (custom("absent.Criterion"), ("absent.Criterion",)),
    (("criterion=custom",), ("criterion._target_", "my_module.MyCriterion")),
    (("hydra/launcher=absent",), ("hydra/launcher=absent", "acalx")),
    (("--config-name=absent",), ("absent",)),
    (("--config-dir=absent", "--config-name=resolved"), ("absent", "not found")),
]


@pytest.fixture(scope="module")
def refused(tmp_path_factory):
    folder = tmp_path_factory.mktemp("refused")
    (folder / "mine.py").write_text(MINE)
    calls = [partial(run, folder, *arguments, into=f"{k}") for k, (arguments, _) in enumerate(REFUSED)]
    return together(calls)


@pytest.mark.parametrize("k", range(len(REFUSED)), ids=[" ".join(arguments) for arguments, _ in REFUSED])
def test_bad_input_gets_one_plain_message(refused, k):
    arguments, phrases = REFUSED[k]
    assert_refused(refused[k], *phrases)
    given = [argument for argument in arguments if not argument.startswith("-")]
    assert refused[k].result["overrides"][: len(given)] == given


def test_a_switch_shows_the_traceback(tmp_path):
    calls = [
        partial(run, tmp_path, "traceback=true", "n=8", into="job"),
        partial(run, tmp_path, "traceback=true", "criterion=bogus", into="composition"),
    ]
    for outcome in together(calls):
        assert outcome.status == 1
        assert outcome.err.startswith("Traceback (most recent call last)")
        assert outcome.err.endswith(f"acalx: {outcome.result['message']}\n")


def test_an_output_directory_that_cannot_be_written(tmp_path):
    (tmp_path / "afile").write_text("in the way")
    commands = [
        (*QUICK, "hydra.run.dir=afile/x"),
        (*QUICK, "hydra.run.dir=afile"),
        ("-m", *QUICK, "n=9,10", "hydra.sweep.dir=afile/x"),
        ("criterion=bogus", "hydra.run.dir=afile/x"),
    ]
    for outcome in together(partial(execute, tmp_path, *RUN, *command) for command in commands):
        assert outcome.status == 1
        assert "Traceback" not in outcome.err
        assert re.search(r"acalx: can't write to .*afile.*; choose another .*hydra.run.dir=DIRECTORY\n", outcome.err)
    assert [path.name for path in tmp_path.iterdir()] == ["afile"]


def test_a_run_is_never_written_over(tmp_path):
    first = run(tmp_path, "criterion=d", *QUICK)
    before = {path.name: path.read_bytes() for path in first.directory.iterdir()}
    second = run(tmp_path, "criterion=d", *QUICK, "seed=1")
    assert second.status == 1
    assert "holds a run already" in second.err
    assert "Traceback" not in second.err
    assert {path.name: path.read_bytes() for path in first.directory.iterdir()} == before


def test_a_recorded_configuration_has_no_groups_to_choose_from(tmp_path):
    first = run(tmp_path, "criterion=d", *QUICK)
    recorded = (f"--config-dir={first.directory}", "--config-name=resolved")
    calls = [
        partial(run, tmp_path, *recorded, "optimizer=de", into="group"),
        partial(run, tmp_path, *recorded, "seed=1", "optimizer.batch=16", into="values"),
    ]
    group, values = together(calls)
    assert_refused(group, "optimizer", "optimizer.OPTION=VALUE")
    assert values.status == 0, values.err
    assert values.text() != first.text()


# ---------------------------------------------------------------- the console script


@pytest.fixture(scope="module")
def script(tmp_path_factory):
    """Answers of the console script, by its arguments."""
    folder = tmp_path_factory.mktemp("script")
    (folder / "mine.py").write_text("from acalx.criteria import D as Mine")
    lines = [
        "",
        "--help",
        "--version",
        "rnu",
        "run --help",
        "evaluate --help",
        "run criterion=custom criterion._target_=mine.Mine optimizer=gradient hydra.run.dir=run",
        "evaluate program=icosahedron_12 figures=false hydra.run.dir=evaluation",
        "run n=8 hydra.run.dir=refused",
    ]
    calls = [partial(execute, folder, SCRIPT, *line.split()) for line in lines]
    return dict(zip(lines, together(calls), strict=True))


def test_script_runs_and_evaluates(script):
    folder = next(iter(script.values())).directory
    for directory, line in (("run", 6), ("evaluation", 7)):
        outcome = list(script.values())[line]
        assert outcome.status == 0, outcome.err
        assert json.loads((folder / directory / "result.json").read_text())["status"] == "ok"
    refusal = script["run n=8 hydra.run.dir=refused"]
    assert refusal.status == 1
    assert refusal.err.startswith("acalx: n=8: ")


def test_script_helps(script):
    for line in ("", "--help"):
        assert script[line].status == 0
        assert "acalx run " in script[line].out
        assert "acalx evaluate " in script[line].out
    assert script["--version"].out.strip() == acalx.__version__
    assert "criterion: a, a_fair, custom, d, d_fair, e, e_fair" in script["run --help"].out
    assert "program: ???" in script["evaluate --help"].out


def test_script_suggests_a_command(script):
    assert script["rnu"].status == 2
    commands = "calibrate, evaluate, run, simulate, validate"
    assert script["rnu"].err == f"acalx: no command 'rnu'; did you mean run? (there are: {commands})\n"


CONF = Path(str(resources.files("acalx.conf")))
COMPLETIONS = {
    "acalx ": {"run", "evaluate", "simulate", "calibrate", "validate"},
    "acalx ev": {"evaluate"},
    "acalx run crit": {"criterion=", "criterion."},
    "acalx run criterion=": {f"criterion={path.stem}" for path in (CONF / "criterion").glob("*.yaml")},
    "acalx run n=9 optimizer=g": {"optimizer=gradient"},
    "acalx run optimizer=gradient optimizer.ba": {"optimizer.batch="},
    "acalx evaluate prog": {"program="},
    "acalx calibrate unit=c": {"unit=counts"},
    "acalx run -m criterion=d_": {"criterion=d_fair"},
}


def test_completion_answers_the_shell(tmp_path):
    calls = [
        partial(execute, tmp_path, SCRIPT, "-sc", "query=bash", COMP_LINE=line, COMP_POINT=str(len(line)))
        for line in COMPLETIONS
    ]
    for expected, outcome in zip(COMPLETIONS.values(), together(calls), strict=True):
        assert outcome.status == 0
        assert set(outcome.out.split()) == expected
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(BASH is None, reason="needs bash")
def test_completion_works_in_bash(tmp_path):
    """The script that acalx prints is sourced, and its function called as bash does on TAB."""
    press = (
        'press() { COMP_LINE="$1"; COMP_POINT=${#COMP_LINE}; local words=($COMP_LINE);'
        " COMP_CWORD=$(( ${#words[@]} - 1 ));"
        ' [[ $COMP_LINE == *" " ]] && COMP_CWORD=${#words[@]}; COMPREPLY=(); hydra_bash_completion;'
        ' echo "$1|${COMPREPLY[*]}"; }'
    )
    lines = ["acalx ev", "acalx run crit", "acalx run criterion=d", "acalx "]
    presses = "\n".join(f"press '{line}'" for line in lines)
    code = f'eval "$(acalx -sc install=bash)"\ncomplete -p acalx\ncomplete -p run\n{press}\n{presses}'
    path = os.pathsep.join([str(Path(SCRIPT).parent), os.environ["PATH"]])
    outcome = execute(tmp_path, str(BASH), "--norc", "-c", code, PATH=path)
    first, *answers = outcome.out.splitlines()
    assert first.endswith("-F hydra_bash_completion acalx")
    assert "run: no completion specification" in outcome.err  # not for other people's commands
    answered = dict(answer.split("|") for answer in answers)
    assert answered["acalx ev"] == "evaluate"
    assert set(answered["acalx run crit"].split()) == {"criterion=", "criterion."}
    assert set(answered["acalx run criterion=d"].split()) == {"criterion=d", "criterion=d_fair"}
    assert set(answered["acalx "].split()) == {"run", "evaluate", "simulate", "calibrate", "validate"}


# ---------------------------------------------------------------- configuration

KINDS = {
    "model": (Model, Sensor),
    "stand": Stand,
    "criterion": Criterion,
    "optimizer": Optimizer,
    "scheme": Scheme,
    "estimator": Estimator,
    "unit": Unit,
    "static": StaticIntervals,
    "errors": ErrorSources,
}
# What stands for a part of the user's own.
OF_OWN = {
    "criterion": "acalx.criteria.D",
    "model": "acalx.models.VectorAccel",
    "optimizer": "acalx.optimizers.Gradient",
    "stand": "acalx.stands.TwoAxis",
}
OPTIONS = sorted(path.relative_to(CONF) for path in CONF.glob("*/*.yaml"))


def test_every_group_is_known():
    assert {path.parent.name for path in OPTIONS} == set(KINDS)


@pytest.mark.parametrize("path", OPTIONS, ids=str)
def test_every_option_builds(path):
    config = OmegaConf.load(CONF / path)
    if OmegaConf.is_missing(config, "_target_"):
        config._target_ = OF_OWN[path.parent.name]
    if OmegaConf.is_missing(config, "per_g"):
        config.per_g = 4096.0
    if path.stem == "target":  # which is given at the root
        config.standard_errors = {"bias": 0.5}
    part = hydra.utils.instantiate(config, _convert_="all")
    assert isinstance(part, KINDS[path.parent.name])


def test_every_class_of_an_option_is_a_public_name():
    named = {match for path in OPTIONS for match in re.findall(r"acalx[\w.]*\.(\w+)", (CONF / path).read_text())}
    assert named - {"OPTION"} <= set(dir(acalx))


@pytest.mark.parametrize("path", sorted((CONF / "hydra").glob("*/*.yaml")), ids=lambda path: path.stem)
def test_launcher_and_sweeper_build(path):
    config = OmegaConf.load(path)
    assert type(hydra.utils.instantiate(config)).__name__ == config._target_.rpartition(".")[2]


@pytest.mark.parametrize(
    "path",
    [p for p in OPTIONS if p.parent.name in ("model", "stand", "optimizer", "static") and p.stem != "custom"],
    ids=str,
)
def test_options_are_the_defaults_of_the_class_and_all_of_them(path):
    """Else the command line and Python would give different programs."""
    config = OmegaConf.load(CONF / path)
    part = hydra.utils.instantiate(config, _convert_="all")
    options = [field for field in fields(part) if field.init]
    variety = path.stem in ("magnetic_table", "usual", "fine")  # of another option's class, with other values
    if not variety and all(f.default is not MISSING or f.default_factory is not MISSING for f in options):
        others = type(part)()  # a sensor with a comparison has no defaults, nor have joined ones
        for field in options:
            assert plain(getattr(part, field.name)) == plain(getattr(others, field.name))
    assert set(config) - {"_target_"} == {field.name for field in options}


def plain(value: object) -> object:
    """As JSON has it."""
    return json.loads(json.dumps(asdict(value) if is_dataclass(value) else value))  # type: ignore[call-overload]


def test_fair_criteria_are_as_documented():
    for letter in "ade":
        config = OmegaConf.load(CONF / "criterion" / f"{letter}_fair.yaml")
        part = hydra.utils.instantiate(config, _convert_="all")
        assert part.exponents == (1, 0.1, 0.1, 0.1)
        assert [criterion.group for criterion in part.criteria[1:]] == ["bias", "scale", "nonorthogonality"]
        assert {criterion.floor for criterion in part.criteria[1:]} == {5e-4}
    config = OmegaConf.load(CONF / "criterion" / "d_fair.yaml")
    assert hydra.utils.instantiate(config, _convert_="all").criteria[0] == D()


def test_a_yaml_alone_makes_another_criterion(tmp_path):
    """A folder of one's own, given by --config-dir."""
    (tmp_path / "criterion").mkdir()
    (tmp_path / "criterion" / "a_and_e.yaml").write_text(
        "_target_: acalx.criteria.Product\n"
        "criteria: [{_target_: acalx.criteria.A}, {_target_: acalx.criteria.E}]\n"
        "exponents: [1, 0.5]\n"
    )
    outcome = run(tmp_path, "--config-dir=.", "criterion=a_and_e", *QUICK)
    assert outcome.status == 0, outcome.err
    expected = outcome.metrics["A"] * outcome.metrics["E"] ** 0.5
    assert outcome.result["loss"] == pytest.approx(math.log(expected), abs=1e-9)


def test_public_names_are_what_they_say():
    import types

    for name in dir(acalx):
        assert not isinstance(getattr(acalx, name), types.ModuleType)
    with pytest.raises(AttributeError, match="nothing"):
        _ = acalx.nothing
