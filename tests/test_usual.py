"""What suits a model is there unless the command line says something else; an option of a group says nothing of it."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import hydra
import pytest
from omegaconf import OmegaConf

from acalx.commands.former import renewed
from acalx.commands.usual import with_usual
from acalx.models import as_model
from command import execute, run

GROUPS = ("model", "stand", "criterion", "optimizer", "scheme", "errors", "estimator")
FOLDER = Path(str(files("acalx.conf")))
MODELS = sorted(path.stem for path in FOLDER.glob("model/*.yaml") if path.stem != "custom")


def usual_of(name: str) -> dict[str, str]:
    options = OmegaConf.load(FOLDER / "model" / f"{name}.yaml")
    usual = as_model(hydra.utils.instantiate(options, _convert_="all")).usual
    return {option: f"{option}={choice}" for option, choice in usual.items() if option != "n"}


def suited(*arguments: str) -> list[str]:
    return with_usual(arguments, GROUPS, "config")


@pytest.mark.parametrize("name", MODELS)
def test_an_option_of_a_group_leaves_the_choice(name: str) -> None:
    usual, model = usual_of(name), f"model={name}"
    assert suited(model) == [*usual.values(), model]
    for group in [option for option in usual if "." not in option]:
        for own in (f"{group}.some=1", f"+{group}.some=1", f"~{group}.some", f"{group}.some.more=2"):
            assert suited(model, own) == [*usual.values(), model, own]
        own = f"{group}._target_=my.Part"
        left = [each for option, each in usual.items() if not option.startswith(f"{group}.")]
        assert suited(model, own) == [*left, model, own]
        for own in (f"{group}=other", f"~{group}"):
            left = [each for option, each in usual.items() if option.partition(".")[0] != group]
            assert suited(model, own) == [*left, model, own]
    for option in [option for option in usual if "." in option]:
        left = [each for other, each in usual.items() if other != option]
        assert suited(model, f"{option}=3") == [*left, model, f"{option}=3"]


def test_parts_say_what_suits_a_model_that_is_made_of_them() -> None:
    assert "stand=platform_gimbals" in suited("model=joined")
    assert "stand=magnetic_table" in suited("model=vector_magnetometer")
    other = "model.parts=[{_target_: acalx.sensors.IMU}]"
    assert "stand=two_axis_rate_table" in suited("model=joined", other)
    sensor = "model.sensor={_target_: acalx.sensors.AccelTemperature}"
    assert "stand=chamber" in suited("model=vector_magnetometer", sensor)
    assert suited("model=joined", "model.parts=[3]") == ["model=joined", "model.parts=[3]"]


def test_the_default_model_is_that_of_the_configuration(tmp_path: Path) -> None:
    assert suited("n=9") == [*usual_of("scalar_accel").values(), "n=9"]
    (tmp_path / "config.yaml").write_text("defaults:\n  - model: imu\n")
    assert "stand=two_axis_rate_table" in suited(f"--config-dir={tmp_path}", "n=24")


def test_commands_with_an_option_of_a_usual_group(tmp_path: Path) -> None:
    short = ("n=24", "figures=false", "certificate=false")
    for name in "ab":
        (tmp_path / name).mkdir()
    imu = run(tmp_path / "a", "model=imu", "stand.averaging_s=0", "optimizer.starts=2", *short)
    assert imu.status == 0, imu.err
    joined = run(tmp_path / "b", "model=joined", "criterion=d", "optimizer=gradient", "n=12", *short[1:])
    assert joined.status == 0, joined.err


# ---------------------------------------------------------------- words of former versions


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("estimator.residual=null", "estimator.comparison=null"),
        ("~estimator.residual", "~estimator.comparison"),
        (
            "estimator.residual._target_=acalx.estimation.Magnitude",
            "++estimator.comparison._target_=acalx.models.Magnitude",
        ),
        (
            "estimator.residual={_target_:acalx.estimation.Oriented}",
            "estimator.comparison={_target_:acalx.models.Projection}",
        ),
        ("model._target_=acalx.models.platform_accel.PlatformAccel", "model._target_=acalx.sensors.PlatformAccel"),
        ("model.parts=[{_target_:acalx.models.PlatformGyro}]", "model.parts=[{_target_:acalx.sensors.PlatformGyro}]"),
        ("data=acalx.estimation.Magnitude.csv", "data=acalx.estimation.Magnitude.csv"),
        ("estimator.residuals=3", "estimator.residuals=3"),
    ],
)
def test_old_words_are_those_of_now(old: str, new: str) -> None:
    assert renewed([old]) == [new]


READINGS = "\n".join(["ax,ay,az", *(f"{x},{y},{z}" for x in (-0.6, 0.6) for y in (-0.6, 0.6) for z in (-0.53, 0.53))])
MORE = "\n1.01,0,0\n-0.99,0,0\n0,1,0\n0,-1,0\n0,0,1\n0,0,-1\n"


@pytest.mark.parametrize("word", ["estimator.residual._target_=", "estimator.comparison._target_=", "yaml"])
def test_an_old_command_line_calibrates(tmp_path: Path, word: str) -> None:
    (tmp_path / "data.csv").write_text(READINGS + MORE)
    own = [f"{word}acalx.estimation.Magnitude"]
    if word == "yaml":
        (tmp_path / "own" / "estimator").mkdir(parents=True)
        text = "_target_: acalx.estimation.Iterated\nresidual: {_target_: acalx.estimation.residuals.Magnitude}\n"
        (tmp_path / "own" / "estimator" / "mine.yaml").write_text(text)
        own = ["--config-dir=own", "estimator=mine"]
    outcome = execute(tmp_path, "python", "-m", "acalx.calibrate", *own, "data=data.csv", "unit=g", "figures=false")
    assert outcome.status == 0, outcome.err
    said = outcome.err.splitlines()
    assert any(line.endswith("is acalx.models.Magnitude now") for line in said)
    assert ("acalx: estimator.residual is estimator.comparison now" in said) == ("comparison" not in word)
    assert len(said) == len(set(said))
