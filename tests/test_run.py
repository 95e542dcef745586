"""The main job and what it leaves: each command is started for real, in an empty directory."""

import os
import re
import shutil
import signal
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from decimal import Decimal
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from command import Outcome, assert_refused, execute, finish, run, start, together

MAIN_JOB = ["python", "-m", "acalx.run", "model=scalar_accel", "criterion=d_fair", "optimizer=de", "n=9"]
GROUPS = ("bias", "scale", "nonorthogonality")
KEYS = {"status", "n", "seed", "metrics", "loss", "evaluations", "seconds", "message", "versions", "overrides"}
FIGURES = {f"{name}.{kind}" for name in ("positions", "convergence", "entries") for kind in ("svg", "png")}
PROGRESS = re.compile(r"\d+ s: best loss -?\d+\.\d+, \d+ evaluations, at most .+ left\n")
QUICK = ("criterion=d", "optimizer=gradient", "figures=false")
# searches that would go on for hours
ENDLESS_DE = ("criterion=e_fair", "n=25", "optimizer.restarts=100000", "optimizer.agree=100000")
ENDLESS_GRADIENT = (
    "criterion=a",
    "n=30",
    "optimizer=gradient",
    "optimizer.starts=10000000",
    "optimizer.agreement=1e-300",
)


@pytest.fixture(scope="module")
def main_job(tmp_path_factory):
    folder = tmp_path_factory.mktemp("main_job")
    outcome = execute(folder, *MAIN_JOB)
    assert outcome.status == 0, outcome.err
    (directory,) = (folder / "runs").iterdir()
    assert [path.name for path in folder.iterdir()] == ["runs"]
    return replace(outcome, directory=directory)


# ---------------------------------------------------------------- the main job


def test_main_job_is_better_than_anything_printed(main_job):
    assert main_job.metrics["D"] <= 0.048932
    for group in GROUPS:
        assert main_job.metrics["inequality"][group] <= 0.0006


def test_result_holds_what_it_must(main_job):
    result = main_job.result
    assert set(result) >= KEYS
    assert result["status"] == "ok"
    assert (result["n"], result["seed"]) == (9, 0)
    assert result["overrides"] == MAIN_JOB[3:]
    assert {"D", "A", "E", "theta", "inequality"} <= set(result["metrics"])
    for name in ("theta", "inequality"):
        assert tuple(result["metrics"][name]) == GROUPS
    assert len(result["metrics"]["standard_deviations"]) == 9
    assert np.array(result["metrics"]["correlations"]).shape == (9, 9)
    assert result["metrics"]["condition_number"] > 1
    assert result["evaluations"] > 1000
    assert 0 < result["seconds"] < 120
    assert "agree" in result["message"]
    assert {"acalx", "numpy", "scipy", "hydra-core", "python"} <= set(result["versions"])
    assert result["gain"] > 0


def test_figures_of_merit_are_those_of_the_written_program(main_job):
    x, y, z = np.array([[float(row[f"eta_{axis}"]) for axis in "xyz"] for row in main_job.rows()]).T
    regressors = np.stack([x, y, z, x * x, y * y, z * z, x * y, x * z, z * y], axis=-1)
    covariance = np.linalg.inv(regressors.T @ regressors)
    deviations = np.sqrt(np.diag(covariance)).reshape(3, 3)
    assert main_job.metrics["D"] == pytest.approx(np.linalg.det(covariance), rel=1e-9)
    assert main_job.metrics["A"] == pytest.approx(np.trace(covariance), rel=1e-9)
    assert main_job.metrics["E"] == pytest.approx(np.linalg.eigvalsh(covariance)[-1], rel=1e-9)
    for group, row in zip(GROUPS, deviations, strict=True):
        assert main_job.metrics["theta"][group] == pytest.approx(row.max(), rel=1e-9)
        assert main_job.metrics["inequality"][group] == pytest.approx(1 - row.min() / row.max(), abs=1e-9)
    floored = [max(value, 5e-4) for value in main_job.metrics["inequality"].values()]
    loss = np.log(main_job.metrics["D"]) + 0.1 * np.log(floored).sum()
    assert main_job.result["loss"] == pytest.approx(loss, abs=1e-9)


def test_program_csv_has_angles_and_the_vertical(main_job):
    assert main_job.text().splitlines()[0] == "position,alpha1_deg,alpha2_deg,eta_x,eta_y,eta_z"
    rows = main_job.rows()
    assert [row["position"] for row in rows] == [str(k + 1) for k in range(9)]
    for row in rows:
        first, second = (np.radians(float(row[name])) for name in ("alpha1_deg", "alpha2_deg"))
        expected = (np.sin(first), np.cos(first) * np.sin(second), np.cos(first) * np.cos(second))
        assert [float(row[f"eta_{axis}"]) for axis in "xyz"] == pytest.approx(expected, abs=1e-13)
        assert 0 <= float(row["alpha1_deg"]) <= 360
        assert 0 <= float(row["alpha2_deg"]) <= 360


def test_history_falls(main_job):
    rows = main_job.rows("history.csv")
    assert list(rows[0]) == ["evaluations", "seconds", "loss"]
    losses = [float(row["loss"]) for row in rows]
    evaluations = [int(row["evaluations"]) for row in rows]
    seconds = [float(row["seconds"]) for row in rows]
    assert len(rows) > 10
    assert all(np.diff(losses) < 0)
    assert all(np.diff(evaluations) >= 0)
    assert all(np.diff(seconds) >= 0)
    assert losses[-1] == pytest.approx(main_job.result["loss"], abs=1e-12)
    assert evaluations[-1] <= main_job.result["evaluations"]


def test_alternatives_are_as_good(main_job):
    rows = main_job.rows("alternatives.csv")
    losses = {row["program"]: float(row["loss"]) for row in rows}
    assert len(losses) == main_job.result["alternatives"] + 1
    assert len(rows) == 9 * len(losses)
    assert losses["1"] == min(losses.values()) == pytest.approx(main_job.result["loss"], abs=1e-12)
    assert max(losses.values()) <= losses["1"] + 1e-5
    first = [[row[name] for name in ("alpha1_deg", "alpha2_deg")] for row in rows if row["program"] == "1"]
    assert first == [[row["alpha1_deg"], row["alpha2_deg"]] for row in main_job.rows()]


def test_figures_are_drawn_as_svg_and_png(main_job):
    assert FIGURES | {"program.csv", "result.json", "history.csv", "resolved.yaml"} <= main_job.files
    for name in FIGURES:
        path = main_job.directory / name
        if name.endswith("svg"):
            assert ElementTree.parse(path).getroot().tag.endswith("svg")
        else:
            assert path.read_bytes().startswith(b"\x89PNG")


def test_nothing_is_left_half_written(main_job):
    assert not [name for name in main_job.files if name.startswith(".")]


def test_terminal_shows_the_program_and_the_figures(main_job):
    lines = [line.split() for line in main_job.out.splitlines()]
    for row in main_job.rows():
        angles = [f"{float(row[name]):.2f}" for name in ("alpha1_deg", "alpha2_deg")]
        assert any(line[:3] == [row["position"], *angles] for line in lines)
    assert ["D", f"{main_job.metrics['D']:.6g}", "0.048932"] in lines
    assert "egorov_2021_table_1" in main_job.out
    assert "inequality nonorthogonality" in main_job.out
    assert main_job.result["message"] in main_job.out
    assert str(main_job.directory.relative_to(main_job.directory.parents[1])) in main_job.out


# ---------------------------------------------------------------- again, and bit for bit

VARIANTS = {
    "gradient": ("optimizer=gradient", "n=12", "seed=3"),
    "stepped": ("stand.step_deg=7.5", "criterion=d", "optimizer.restarts=2", "optimizer.maxiter=100"),
    "bounded": ("stand.alpha1_deg=[-180,180]", "stand.alpha2_deg=[-45,45]", "criterion=d", "optimizer.restarts=1"),
    "a product": ("criterion.exponents=[1,0.2,0.2,0.05]", "optimizer=gradient"),
}


@pytest.fixture(scope="module")
def variants(tmp_path_factory):
    folder = tmp_path_factory.mktemp("variants")
    calls = [
        partial(run, folder, *arguments, "figures=false", into=name.replace(" ", "_"))
        for name, arguments in VARIANTS.items()
    ]
    return dict(zip(VARIANTS, together(calls), strict=True))


@pytest.fixture(scope="module")
def again(main_job, variants, tmp_path_factory):
    """Each run once more, from the configuration that it left and in another folder."""
    folder = tmp_path_factory.mktemp("again")
    before = {"main": main_job, **variants}
    calls = [
        partial(
            run,
            folder,
            f"--config-dir={outcome.directory}",
            "--config-name=resolved",
            into=f"{name.replace(' ', '_')}_again",
        )
        for name, outcome in before.items()
    ]
    return before, dict(zip(before, together(calls), strict=True))


@pytest.mark.parametrize("name", ["main", *VARIANTS])
def test_resolved_configuration_gives_the_same_program(again, name):
    before, after = again[0][name], again[1][name]
    assert before.status == 0, before.err
    assert after.status == 0, after.err
    for file in ("program.csv", "alternatives.csv", "resolved.yaml"):
        assert (after.directory / file).read_bytes() == (before.directory / file).read_bytes()
    for key in ("metrics", "loss", "evaluations", "n", "seed", "message"):
        assert after.result[key] == before.result[key]


def test_a_figure_is_the_same_file_again(again):
    for name in ("positions.svg", "entries.svg"):
        assert again[1]["main"].text(name) == again[0]["main"].text(name)


def test_written_program_evaluates_to_the_same_figures(main_job, variants, tmp_path):
    runs = [main_job, variants["stepped"], variants["bounded"]]
    calls = [
        partial(
            run,
            tmp_path,
            f"program={outcome.directory}/program.csv",
            "figures=false",
            "criterion=d" if k else "criterion=d_fair",
            into=str(k),
            entry="evaluate",
        )
        for k, outcome in enumerate(runs)
    ]
    for before, after in zip(runs, together(calls), strict=True):
        assert after.status == 0, after.err
        assert after.result["loss"] == pytest.approx(before.result["loss"], abs=1e-9)
        for name in ("D", "A", "E", "condition_number"):
            assert after.metrics[name] == pytest.approx(before.metrics[name], rel=1e-9)
        for name in ("theta", "inequality", "standard_deviations"):
            assert after.metrics[name] == pytest.approx(before.metrics[name], abs=1e-9)


def test_another_seed_gives_another_program(tmp_path):
    outcomes = together([partial(run, tmp_path, *QUICK, f"seed={seed}", into=str(seed)) for seed in (0, 1)])
    assert outcomes[0].text() != outcomes[1].text()
    assert outcomes[0].metrics["D"] == pytest.approx(outcomes[1].metrics["D"], rel=1e-6)


# ---------------------------------------------------------------- limits and steps


@pytest.fixture(scope="module")
def limited(tmp_path_factory):
    folder = tmp_path_factory.mktemp("limited")
    table = ("stand.alpha1_deg=[-180,180]", "stand.alpha2_deg=[-45,45]", "stand.step_deg=15")
    rest = ("criterion=d", "figures=false")
    commands = {
        "table": (*table, "optimizer=de", "optimizer.restarts=2", "figures=false"),
        "35 de": ("stand.alpha2_deg=[-35,35]", "optimizer=de", *rest),
        "35 gradient": ("stand.alpha2_deg=[-35,35]", "optimizer=gradient", *rest),
        "33.3": (
            "stand.alpha1_deg=[-33.3,70.1]",
            "stand.alpha2_deg=[-33.3,33.3]",
            "optimizer=gradient",
            *rest,
        ),
        "0.1 table": ("stand.step_deg=0.1", "optimizer.restarts=1", "optimizer.polish=false", *rest),
    }
    calls = [partial(run, folder, *arguments, into=name.replace(" ", "_")) for name, arguments in commands.items()]
    return dict(zip(commands, together(calls), strict=True))


def angles_of(outcome):
    assert outcome.status == 0, outcome.err
    return [[row[name] for row in outcome.rows()] for name in ("alpha1_deg", "alpha2_deg")]


def test_a_15_degree_table_gets_exact_multiples_within_its_limits(limited):
    first, second = angles_of(limited["table"])
    assert all(Decimal(text) % 15 == 0 for text in first + second)
    assert all(-180 <= Decimal(text) <= 180 for text in first)
    assert all(-45 <= Decimal(text) <= 45 for text in second)


def test_steps_of_a_tenth_are_written_as_tenths(limited):
    first, second = angles_of(limited["0.1 table"])
    assert all(Decimal(text) % Decimal("0.1") == 0 for text in first + second)
    assert all(len(text.partition(".")[2]) == 1 for text in first + second)


@pytest.mark.parametrize("optimizer", ["de", "gradient"])
def test_a_limit_of_35_degrees_is_written_as_35(limited, optimizer):
    _, second = angles_of(limited[f"35 {optimizer}"])
    assert all(-35 <= Decimal(text) <= 35 for text in second)
    assert {"35.0", "-35.0"} <= set(second)


def test_limits_that_are_not_whole_are_kept(limited):
    first, second = angles_of(limited["33.3"])
    assert all(Decimal("-33.3") <= Decimal(text) <= Decimal("70.1") for text in first)
    assert all(Decimal("-33.3") <= Decimal(text) <= Decimal("33.3") for text in second)
    assert {"33.3", "-33.3"} <= set(second)


def test_optimizers_agree_within_limits(limited):
    assert limited["35 de"].result["loss"] == pytest.approx(limited["35 gradient"].result["loss"], abs=1e-5)


# ---------------------------------------------------------------- a criterion beside the user

CUSTOM = '''
"""A criterion with one method."""

import numpy as np

from acalx.criteria import Criterion


class Largest(Criterion):
    """Log of the sum of the fourth powers of the standard deviations."""

    def loss(self, information):
        return np.log((information.variances**2).sum(axis=-1))


class Weighted(Criterion):
    """Takes an option."""

    def __init__(self, weight):
        self.weight = weight

    def loss(self, information):
        return np.log(information.variances[..., :3].sum(-1) + self.weight * information.variances[..., 3:].sum(-1))
'''


def test_a_custom_criterion_runs_with_both_optimizers(tmp_path):
    (tmp_path / "mine.py").write_text(CUSTOM)
    custom = ("criterion=custom", "criterion._target_=mine.Largest", "figures=false")
    calls = [
        partial(run, tmp_path, *custom, "optimizer=gradient", into="gradient"),
        partial(run, tmp_path, *custom, "optimizer=de", "optimizer.restarts=1", "optimizer.companions=0", into="de"),
        partial(
            run,
            tmp_path,
            *(custom[0], "criterion._target_=mine.Weighted", "+criterion.weight=2.5", "optimizer=gradient", "n=10"),
            into="weighted",
        ),
    ]
    by_gradient, by_de, weighted = together(calls)
    assert (by_gradient.status, by_de.status, weighted.status) == (0, 0, 0)
    assert by_gradient.result["loss"] == pytest.approx(by_de.result["loss"], abs=1e-5)
    deviations = np.array(list(by_gradient.metrics["standard_deviations"].values()))
    assert by_gradient.result["loss"] == pytest.approx(np.log((deviations**4).sum()), abs=1e-9)
    variances = np.array(list(weighted.metrics["standard_deviations"].values())) ** 2
    assert weighted.result["loss"] == pytest.approx(np.log(variances[:3].sum() + 2.5 * variances[3:].sum()), abs=1e-9)


# ---------------------------------------------------------------- time and interrupts


def test_a_short_job_is_quiet(tmp_path):
    outcome = run(tmp_path, *QUICK)
    assert outcome.status == 0
    assert outcome.complaints == ""


@pytest.fixture(scope="module")
def interrupted(tmp_path_factory):
    """Long jobs, interrupted by Ctrl-C after their first line of progress."""
    folder = tmp_path_factory.mktemp("interrupted")
    sweep = ("-m", *ENDLESS_DE, "seed=0,1", "hydra.sweep.dir=sweep")
    commands = {
        "de": (*ENDLESS_DE, "hydra.run.dir=de"),
        "gradient": (*ENDLESS_GRADIENT, "figures=false", "hydra.run.dir=gradient"),
        "sweep/0": (*sweep, "figures=false"),
    }

    def interrupt(name):
        process = start(folder, "python", "-m", "acalx.run", *commands[name])
        line = process.stderr.readline()
        process.send_signal(signal.SIGINT)
        return line, finish(process, folder / name)

    return dict(zip(commands, together(partial(interrupt, name) for name in commands), strict=True))


@pytest.mark.parametrize("name", ["de", "gradient", "sweep/0"])
def test_a_long_job_shows_progress_with_the_time_left(interrupted, name):
    line, _ = interrupted[name]
    assert PROGRESS.fullmatch(line)


@pytest.mark.parametrize("name", ["de", "gradient", "sweep/0"])
def test_ctrl_c_leaves_the_best_program_so_far(interrupted, name):
    _, outcome = interrupted[name]
    assert outcome.status == 130
    assert "Traceback" not in outcome.err
    assert outcome.result["status"] == "interrupted"
    assert "interrupted after" in outcome.result["message"]
    assert len(outcome.rows()) == outcome.result["n"]
    assert float(outcome.rows("history.csv")[-1]["loss"]) == pytest.approx(outcome.result["loss"], abs=1e-9)
    assert outcome.metrics["D"] > 0
    if name == "de":
        assert outcome.files >= FIGURES


def test_ctrl_c_ends_a_sweep(interrupted):
    _, outcome = interrupted["sweep/0"]
    assert not (outcome.directory.parent / "1").exists()


def test_a_directory_that_vanishes_gives_no_traceback(tmp_path):
    process = start(tmp_path, "python", "-m", "acalx.run", *ENDLESS_DE, "hydra.run.dir=gone")
    process.stderr.readline()
    shutil.rmtree(tmp_path / "gone")
    process.send_signal(signal.SIGINT)
    outcome = finish(process, tmp_path / "gone")
    assert outcome.status != 0
    assert "Traceback" not in outcome.err
    assert "gone" in outcome.err


def test_a_reader_that_goes_away_does_not_spoil_the_record(tmp_path):
    """As with ``acalx run ... | head -1``."""
    process = start(tmp_path, "python", "-u", "-m", "acalx.run", *QUICK, "hydra.run.dir=run")
    process.stdout.close()
    process.stderr.read()
    process.stderr.close()
    outcome = Outcome(process.wait(), "", "", tmp_path / "run")
    assert outcome.result["status"] == "ok"
    assert outcome.metrics["D"] < 0.05


# ---------------------------------------------------------------- many at once


def test_simultaneous_runs_never_share_a_directory(tmp_path):
    processes = [start(tmp_path, "python", "-m", "acalx.run", *QUICK) for _ in range(6)]
    outcomes = [finish(process, tmp_path) for process in processes]
    assert [outcome.status for outcome in outcomes] == [0] * 6
    directories = list((tmp_path / "runs").iterdir())
    assert len(directories) == 6
    written = {outcome.out.splitlines()[-1].removeprefix("written to ").rpartition(os.sep)[2] for outcome in outcomes}
    assert written == {path.name for path in directories}
    assert len({(path / "program.csv").read_bytes() for path in directories}) == 1


# ---------------------------------------------------------------- nothing heavy is imported

HEAVY = ("cvxpy", "pymoo", "matplotlib", "scipy.optimize")
IMPORTS = f"""
import sys
from acalx.commands.run import main
status = main()
print("heavy:", *[name for name in {HEAVY} if name in sys.modules])
sys.exit(status)
"""


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("optimizer=gradient", "criterion=d_fair", "figures=false"), ""),
        (("optimizer=gradient", "criterion=d"), "matplotlib"),
        (("optimizer=de", "criterion=d", "optimizer.restarts=1", "figures=false"), "scipy.optimize"),
    ],
)
def test_imports_only_what_a_job_uses(tmp_path, arguments, expected):
    outcome = execute(tmp_path, "python", "-c", IMPORTS, *arguments)
    assert outcome.status == 0, outcome.err
    assert outcome.out.splitlines()[-1].removeprefix("heavy:").strip() == expected


def test_package_imports_nothing_heavy(tmp_path):
    code = "import sys, acalx; print([m for m in ('numpy', 'scipy', 'hydra') if m in sys.modules])"
    assert execute(tmp_path, "python", "-c", code).out == "[]\n"


def test_a_thousand_positions(tmp_path):
    outcome = run(tmp_path, *QUICK, "n=1000")
    assert outcome.status == 0, outcome.err
    assert len(outcome.rows()) == 1000
    assert outcome.metrics["D"] == pytest.approx(1.5377e7 / 1000**9, rel=1e-4)
    assert "more in program.csv" in outcome.out


def test_works_where_the_path_has_spaces(tmp_path):
    folder = tmp_path / "a folder"
    folder.mkdir()
    outcome = run(folder, *QUICK, into="a run")
    assert outcome.status == 0, outcome.err
    assert Path(folder / "a run" / "program.csv").is_file()


def test_a_search_without_a_program_says_what_was_asked(tmp_path):
    north = ("model=platform", "stand=platform_gimbals", "stand.azimuth_deg=0", "criterion=d", "optimizer=gradient")
    outcome = run(tmp_path, *north, "n=16")
    assert_refused(outcome, "gyro_x_misalignment_S")
    asked = {name: outcome.result[name] for name in ("model", "stand", "criterion", "optimizer", "scheme")}
    assert [part["class"] for part in asked.values()] == ["Platform", "PlatformGimbals", "D", "Gradient", "Joint"]
    assert asked["stand"]["azimuth_deg"] == 0
