"""Sensors from outside, one short file each, go the whole way: by the command line, by a YAML and from Python."""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from acalx import D, ErrorSources, Gradient, Problem, bound, calibrate, design, find_program, read_correction, simulate
from acalx import evaluate as evaluated
from acalx import validate as validated
from acalx.estimation import read_readings
from acalx.numerics.arrays import Array
from acalx.stands import Stand, TwoAxis
from acalx.testing import check_sensor, check_stand
from command import Outcome, run
from costs import code_lines

FILES = {
    "cubic.py": """
from dataclasses import dataclass

from acalx import Channel, Parameter, Polynomial, Term


@dataclass(frozen=True)
class Cubic(Polynomial):
    noise_g: float = 1e-4
    channels = property(lambda self: (Channel("ax", "g", self.noise_g),))
    terms = (
        Term(None, "fx"),
        Term(Parameter("bias", "bias", "g", scatter=0.02)),
        Term(Parameter("scale", "scale", "1", scatter=0.01), "fx"),
        Term(Parameter("cubic", "cubic", "1/g^2", scatter=0.001), "fx fx fx"),
    )
""",
    "saturating.py": """
import numpy as np

from acalx import Channel, Parameter, Sensor


class Saturating(Sensor):
    groups = (("bias", "g", 0.02), ("scale", "1", 0.02), ("bend", "1/g", 0.05))
    parameters = tuple(Parameter(f"{name}_{k}", name, unit, scatter=size) for name, unit, size in groups for k in "xyz")
    channels = tuple(Channel(f"a{axis}", "g", 1e-4) for axis in "xyz")
    needs = {"specific_force": "g"}
    senses = ("specific_force",)

    def readings(self, parameters, stimulus):
        bias, scale, bend = np.split(parameters[..., None, :], 3, axis=-1)
        return bias + (1.0 + scale) * np.tanh((0.5 + bend) * stimulus["specific_force"]) / (0.5 + bend)
""",
    "fading.py": """
import numpy as np

from acalx import Channel, Parameter, Sensor


class Fading(Sensor):
    groups = (("bias", "uT", 0.5), ("scale", "1", 0.02), ("fade", "1/K", 1e-3))
    parameters = tuple(Parameter(f"{name}_{k}", name, unit, scatter=size) for name, unit, size in groups for k in "xyz")
    channels = tuple(Channel(f"m{axis}", "uT", 0.05) for axis in "xyz")
    needs = {"magnetic_field": "uT", "temperature": "K"}
    senses = ("magnetic_field",)

    def readings(self, parameters, stimulus):
        bias, scale, fade = np.split(parameters[..., None, :], 3, axis=-1)
        left = np.exp(-fade * (stimulus["temperature"] - 293.15))
        return bias + (1.0 + scale) * left * stimulus["magnetic_field"]
""",
    "oven.py": """
from dataclasses import dataclass

import numpy as np

from acalx import Setting, Stand, Stimulus
from acalx.quantities.units import KELVIN


@dataclass(frozen=True)
class Oven(Stand):
    hottest_K: float = 340.0

    @property
    def settings(self):
        angles = Setting("roll", 0.0, 2.0 * np.pi), Setting("pitch", -1.2, 1.2)
        return (*angles, Setting("oven", 280.0, self.hottest_K, None, False, KELVIN))

    def stimulus(self, settings):
        roll, pitch = settings[..., 0], settings[..., 1]
        along = np.sin(pitch), np.cos(pitch) * np.sin(roll), np.cos(pitch) * np.cos(roll)
        units = {"magnetic_field": "nT", "temperature": "K"}
        return Stimulus(magnetic_field=48_000.0 * np.stack(along, axis=-1), temperature=settings[..., 2:], units=units)
""",
}


@dataclass(frozen=True)
class Case:
    """A sensor of one of the files, on a stand by its options, with n positions."""

    target: str
    stand: tuple[str, ...]
    n: int

    @property
    def module(self) -> ModuleType:
        return importlib.import_module(self.target.partition(".")[0])

    @property
    def sensor(self):
        return getattr(self.module, self.target.partition(".")[2])()

    @property
    def rig(self) -> Stand:
        return importlib.import_module("oven").Oven() if len(self.stand) > 1 else TwoAxis()

    @property
    def options(self) -> tuple[str, ...]:
        return "model=custom", f"model._target_={self.target}", *self.stand


CASES = {
    "cubic": Case("cubic.Cubic", ("stand=two_axis",), 12),
    "saturating": Case("saturating.Saturating", ("stand=two_axis",), 12),
    "fading": Case("fading.Fading", ("stand=custom", "stand._target_=oven.Oven"), 12),
}
BY_YAML = {name: (f"model=my_{name}", "stand=my_oven" if name == "fading" else "stand=two_axis") for name in CASES}
QUICK = ("optimizer=gradient", "optimizer.starts=2", "seed=3", "figures=false", "certificate=false")
each_case = pytest.mark.parametrize("name", CASES)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    folder = tmp_path_factory.mktemp("outside")
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8")
    for group in ("model", "stand"):
        (folder / group).mkdir()
    for name, case in CASES.items():
        (folder / "model" / f"my_{name}.yaml").write_text(f"_target_: {case.target}\n", encoding="utf-8")
    (folder / "stand" / "my_oven.yaml").write_text("_target_: oven.Oven\nhottest_K: 340\n", encoding="utf-8")
    sys.path.insert(0, str(folder))
    yield folder
    sys.path.remove(str(folder))
    for name in FILES:
        sys.modules.pop(name.removesuffix(".py"), None)


@pytest.fixture(scope="module")
def designed(folder: Path) -> dict[str, Outcome]:
    return {
        name: run(folder, *case.options, f"n={case.n}", *QUICK, into=f"{name}_design") for name, case in CASES.items()
    }


@pytest.mark.parametrize("file", [name for name in FILES if name != "oven.py"])
def test_a_sensor_is_a_few_lines(file: str) -> None:
    assert code_lines(FILES[file]) <= 15


@each_case
def test_what_is_from_outside_keeps_the_contracts(folder: Path, name: str) -> None:
    case = CASES[name]
    check_stand(case.rig)
    check_sensor(case.sensor, case.rig)


def truth_of(name: str) -> Array:
    parameters = CASES[name].sensor.parameters
    return np.array([one.scatter for one in parameters]) * np.random.default_rng(7).standard_normal(len(parameters))


def measured(folder: Path, name: str, program: Path) -> Path:
    """The program twice over, with columns of simulated readings beside its own."""
    case, rng = CASES[name], np.random.default_rng(8)
    settings, sensor = find_program(str(program)).settings_for(case.rig), case.sensor
    felt = case.rig.stimulus(settings).in_units(sensor.needs)
    sigma = np.array([channel.noise for channel in sensor.channels])
    header, *rows = program.read_text(encoding="utf-8").splitlines()
    lines = [",".join([header, *(channel.name for channel in sensor.channels)])]
    for _ in range(2):
        means = sensor.readings(truth_of(name), felt) + sigma * rng.standard_normal((len(settings), len(sigma)))
        lines += [",".join([row, *map(repr, mean)]) for row, mean in zip(rows, means.tolist(), strict=True)]
    path = folder / f"{name}_{program.parent.name}.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def assert_found(name: str, parameters: dict[str, dict[str, float]]) -> None:
    for truth, (key, entry) in zip(truth_of(name), parameters.items(), strict=True):
        assert abs(entry["estimate"] - truth) < 5.0 * entry["standard_error"], key


def went_well(outcome: Outcome) -> Outcome:
    assert outcome.status == 0, outcome.err
    assert outcome.complaints == ""
    return outcome


def the_whole_way(folder: Path, name: str, options: tuple[str, ...], program: Path) -> None:
    """Every command but the design."""
    case, data = CASES[name], measured(folder, name, program)
    into, plain = f"{program.parent.name}_", ("figures=false", "certificate=false")
    figures = went_well(
        run(folder, *options, f"program={program}", "criterion=d", *plain, into=into + "e", entry="evaluate")
    )
    assert figures.metrics["D"] > 0.0
    campaign = ("errors=usual", "trials=400", "seed=1", "figures=false")
    simulated = went_well(run(folder, *options, f"program={program}", *campaign, into=into + "s", entry="simulate"))
    assert simulated.result["status"] == "ok"
    calibrated = went_well(run(folder, *options, f"data={data}", "figures=false", into=into + "c", entry="calibrate"))
    written = json.loads(calibrated.text("calibration.json"))
    assert_found(name, written["parameters"])
    apply = f"apply={calibrated.directory / 'calibration.json'}"
    corrected = went_well(run(folder, f"data={data}", apply, into=into + "a", entry="calibrate"))
    felt = case.rig.stimulus(np.tile(find_program(str(program)).settings_for(case.rig), (2, 1)))
    ideal = case.sensor.readings(case.sensor.nominal, felt.in_units(case.sensor.needs))
    rows = corrected.rows("corrected.csv")
    for k, channel in enumerate(case.sensor.channels):
        right = [float(row[f"{channel.name}_{channel.unit}"]) for row in rows]
        np.testing.assert_allclose(right, ideal[:, k], atol=15.0 * channel.noise)
    splits = ("splits=10", "programs=[]", "turns=1", "figures=false")
    checked = went_well(run(folder, *options, f"data={data}", *splits, into=into + "v", entry="validate"))
    assert checked.result["status"] == "ok"


@each_case
def test_by_the_command_line(folder: Path, designed: dict[str, Outcome], name: str) -> None:
    outcome = went_well(designed[name])
    assert outcome.result["n"] == CASES[name].n
    the_whole_way(folder, name, CASES[name].options, outcome.directory / "program.csv")


@each_case
def test_by_a_folder_of_options(folder: Path, designed: dict[str, Outcome], name: str) -> None:
    options = ("--config-dir=.", *BY_YAML[name])
    outcome = went_well(run(folder, *options, f"n={CASES[name].n}", *QUICK, into=f"{name}_yaml"))
    assert outcome.text() == designed[name].text()
    if name == "fading":
        the_whole_way(folder, name, options, outcome.directory / "program.csv")


@each_case
def test_from_python(folder: Path, designed: dict[str, Outcome], name: str) -> None:
    case = CASES[name]
    rig, sensor = case.rig, case.sensor
    problem = Problem(rig, sensor, D(), case.n)
    found = design(problem, Gradient(starts=2), seed=3, certificate=False)
    assert found.result.best.loss == pytest.approx(designed[name].metrics["log_D"], abs=1e-9)
    if name != "fading":  # two angles and a temperature take long to search
        least = bound(problem)
        assert least.proved == (name == "cubic")
        assert least.loss <= found.result.best.loss + 1e-9
    assert not evaluated(found.program, rig, sensor, D(), certificate=False).inestimable
    errors = ErrorSources(parameters={}, noise=1.0, setting_rad=0.0, gravity=0.0)
    simulated = simulate(found.program, rig, sensor, errors, trials=400, seed=1)
    assert all(simulated.agrees.values())
    data = measured(folder, name, designed[name].directory / "program.csv")
    columns = [channel.name for channel in sensor.channels]
    readings = read_readings(data, columns, stand=rig, quantities=tuple(sensor.needs))
    calibration = calibrate(readings, sensor)
    assert_found(name, calibration.entries()["parameters"])
    path = folder / f"{name}.json"
    path.write_text(json.dumps(calibration.entries(), default=np.ndarray.tolist), encoding="utf-8")
    again = read_correction(path, problem.model)
    np.testing.assert_allclose(again.apply(readings.means, readings.stimulus), calibration.corrected, rtol=1e-12)
    checked = validated(readings, sensor, stand=rig, programs=[], splits=10, turns=1)
    assert checked.medians[f"leave_one_out_rms_{checked.unit}"] < 3.0
