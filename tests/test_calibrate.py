"""Calibration as a user does it: each command is started for real."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import parts
from acalx.errors import DataError, SingularError
from acalx.estimation import Bisquare, Iterated, Linear, Readings, Unit, read_correction, read_readings
from acalx.estimation import calibrate as calibrated_from
from acalx.models import ScalarAccel
from acalx.programs import find_program
from acalx.recording.parts import described
from acalx.reporting.calibration import parameters_table
from command import Outcome, assert_refused, run, together
from measured import FERRARIS, XSENS, XSENS_RAW, needs_measured

TRUTH = np.array([0.01, -0.02, 0.015, 0.004, -0.006, 0.008, 0.003, -0.002, 0.001])
FORCE = parts.FULL.stimulus(find_program("egorov_2021_table_2").settings_for(parts.FULL))


def table(header: str, rows: np.ndarray) -> str:
    return header + "\n" + "".join(",".join(f"{value:.10g}" for value in row) + "\n" for row in rows)


def files() -> dict[str, str]:
    rng = np.random.default_rng(1)
    w = ScalarAccel().readings(TRUTH, FORCE) + 1e-5 * rng.standard_normal((18, 3))
    vertical = FORCE["specific_force"]
    far = w.copy()
    far[6] *= 1.01
    spread = np.column_stack([w, np.full((18, 3), 1e-4), np.full(18, 100)])
    seconds = np.arange(18 * 700) / 100
    share = np.clip((seconds % 7.0 - 5.0) / 2.0, 0.0, 1.0)[:, None]
    place = (seconds // 7).astype(int)
    raw = (1 - share) * w[place] + share * w[(place + 1) % 18]
    raw += np.where(share > 0, 0.1, 1e-3) * rng.standard_normal(raw.shape)
    lines = table("ax,ay,az", w).splitlines()
    return {
        "g.csv": table("ax,ay,az", w),
        "si.csv": table("x;y;z".replace(";", ","), 9.81 * w),
        "counts.csv": table("ax,ay,az", 32768 + 4096 * w),
        "known.csv": table("ax,ay,az,eta_x,eta_y,eta_z", np.column_stack([w, vertical])),
        "spread.csv": table("ax,ay,az,sx,sy,sz,n", spread),
        "far.csv": table("ax,ay,az", far),
        "two.csv": table("imu,ax,ay,az", np.column_stack([np.repeat([1, 2], 18), np.concatenate([w, far])])),
        "raw.csv": table("t_s,ax,ay,az", np.column_stack([seconds, raw])),
        "faces.csv": table("ax,ay,az", parts.FACES + 0.01),
        "one.csv": table("ax,ay,az", w[:1]),
        "same.csv": table("ax,ay,az", np.repeat(w[:1], 12, axis=0)),
        "word.csv": "\n".join([*lines[:3], "0.1,west,0.2"]),
        "nan.csv": "\n".join([*lines[:5], "nan,0,1"]),
        "moving.csv": table("t_s,ax,ay,az", np.column_stack([seconds, rng.standard_normal((len(seconds), 3))])),
        "broken.json": "{",
    }


COMMANDS = {
    "g": ("data=g.csv", "noise=1e-5"),
    "si": ("data=si.csv", "columns=[x,y,z]", "unit=m_s2", "unit.per_g=9.81", "figures=false"),
    "counts": ("data=counts.csv", "unit=counts", "unit.per_g=null", "unit.offset=32768", "figures=false"),
    "linear": ("data=g.csv", "estimator=linear", "figures=false"),
    "oriented": ("data=known.csv", "estimator=oriented", "figures=false"),
    "columns": ("data=spread.csv", "noise=columns", "figures=false"),
    "far": ("data=far.csv",),
    "bisquare": ("data=far.csv", "estimator=bisquare", "figures=false"),
    "huber": ("data=far.csv", "estimator=huber", "figures=false"),
    "second": ("data=two.csv", "where={imu: 2}", "figures=false"),
    "raw": ("data=raw.csv", "static=variance", "figures=false"),
    "faces": ("data=faces.csv",),
    "six": ("data=faces.csv", "model.groups=[bias,scale]"),
}
REFUSED = [
    ((), ("which measurements", "data=FILE.csv")),
    (("data=nowhere.csv",), ("no file nowhere.csv",)),
    (("data=si.csv",), ("si.csv: no column 'ax'", "columns=[NAME,NAME,NAME]")),
    (("data=si.csv", "columns=[x,y]"), ("columns=[x,y]", "give 3 names")),
    (("data=si.csv", "columns=[x,y,z]"), ("mean magnitude is 9.8", "unit=m_s2", "Nothing is scaled silently")),
    (("data=counts.csv", "unit=counts"), ("unit.per_g is missing", "unit.per_g=null")),
    (("data=g.csv", "unit.per_g=-3"), ("per_g=-3", "such as 9.80665")),
    (("data=g.csv", "unit=feet"), ("unit=feet", "m_s2")),
    (("data=word.csv",), ("word.csv, row 4, column ay: 'west'",)),
    (("data=nan.csv",), ("nan.csv, row 6, column ax: 'nan'",)),
    (("data=one.csv",), ("one.csv: a single position",)),
    (("data=same.csv",), ("same.csv: all 12 positions read the same",)),
    (("data=moving.csv", "static=variance"), ("moving.csv: no static intervals", "never turned, or never still?")),
    (("data=raw.csv", "static=variance", "static.shortest_s=10"), ("raw.csv: no static intervals of 10 s",)),
    (("data=g.csv", "static=variance"), ("no column t_s", "static.rate_hz")),
    (("data=g.csv", "noise=columns"), ("noise=columns needs", "sx, sy, sz")),
    (("data=g.csv", "noise=loud"), ("noise=loud", "such as 1e-4")),
    (("data=g.csv", "estimator=oriented"), ("needs the direction of the vertical", "eta_x")),
    (("data=g.csv", "where={imu: 3}"), ("no column 'imu'",)),
    (("data=two.csv", "where={imu: 3}"), ("no row with imu=3",)),
    (("data=g.csv", "where=3"), ("where=3", "where={imu: 3}")),
    (("data=g.csv", "apply=nowhere.json"), ("nowhere.json: can't be read",)),
    (("data=g.csv", "apply=broken.json"), ("broken.json: not a calibration.json",)),
    (("data=g.csv", "model.groups=[drift]"), ("model.groups=[drift]", "bias, scale, nonorthogonality")),
    (("data=g.csv", "confidence=95"), ("confidence=95", "such as 0.95")),
    (("data=g.csv", "estimater=linear"), ("estimater", "did you mean estimator?")),
]


def calibrate(folder: Path, *arguments: str, into: str) -> Outcome:
    return run(folder, *arguments, into=into, entry="calibrate")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("calibrate")
    for name, text in files().items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def calibrated(folder: Path) -> dict[str, Outcome]:
    calls = [partial(calibrate, folder, *arguments, into=name) for name, arguments in COMMANDS.items()]
    return dict(zip(COMMANDS, together(calls), strict=True))


def calibration(outcome: Outcome) -> dict[str, dict[str, dict[str, float]]]:
    found: dict[str, dict[str, dict[str, float]]] = json.loads(outcome.text("calibration.json"))
    return found


def estimates(outcome: Outcome) -> np.ndarray:
    return np.array([entry["estimate"] for entry in calibration(outcome)["parameters"].values()])


def test_a_calibration_is_recorded_with_its_accuracy(calibrated: dict[str, Outcome]) -> None:
    outcome = calibrated["g"]
    assert outcome.status == 0, outcome.err
    assert outcome.err == ""
    figures = {"residuals.svg", "residuals.png"}
    assert outcome.files == figures | {"calibration.json", "residuals.csv", "resolved.yaml", "result.json"}
    assert outcome.result["status"] == "ok"
    assert outcome.result["n"] == 18
    entries = calibration(outcome)
    assert list(entries["parameters"]) == [parameter.name for parameter in ScalarAccel().parameters]
    for entry, truth in zip(entries["parameters"].values(), TRUTH, strict=True):
        assert abs(entry["estimate"] - truth) < 4 * entry["standard_error"] < 6e-5
        low, high = entry["interval"]  # type: ignore[misc]
        assert high - low == pytest.approx(2 * 1.95996 * entry["standard_error"], rel=1e-4)
    errors = [entry["standard_error"] for entry in entries["parameters"].values()]
    np.testing.assert_allclose(np.sqrt(np.diag(np.array(entries["covariance"]))), errors, rtol=1e-12)
    assert entries["chi_square"]["freedom"] == 9
    assert entries["chi_square"]["probability"] > 0.01  # type: ignore[operator]
    assert "specific force in g = matrix (reading - offset)" in outcome.out
    assert "95 % interval" in outcome.out
    rows = outcome.rows("residuals.csv")
    assert [row["position"] for row in rows] == [str(k + 1) for k in range(18)]
    assert sum(float(row["leverage"]) for row in rows) == pytest.approx(9.0)


@pytest.mark.parametrize("name", ["si", "oriented", "columns", "bisquare", "huber", "raw"])
def test_all_ways_give_the_same_sensor(calibrated: dict[str, Outcome], name: str) -> None:
    outcome = calibrated[name]
    assert outcome.status == 0, outcome.err
    np.testing.assert_allclose(estimates(outcome), TRUTH, atol=4e-4 if name == "huber" else 1e-4)


def test_an_unknown_scale_is_found(calibrated: dict[str, Outcome]) -> None:
    entries = calibration(calibrated["counts"])
    assert entries["unit"]["per_g"] == pytest.approx(4096 * (1 + TRUTH[3:6].mean()), rel=1e-4)
    np.testing.assert_allclose(estimates(calibrated["counts"])[3:6].sum(), 0.0, atol=1e-12)


def test_the_linear_estimate_is_off_by_the_square_of_the_errors(calibrated: dict[str, Outcome]) -> None:
    off = np.abs(estimates(calibrated["linear"]) - TRUTH).max()
    assert 2e-4 < off < 3e-3


@pytest.mark.parametrize("name", ["far", "bisquare", "huber", "second"])
def test_an_outlying_position_is_named(calibrated: dict[str, Outcome], name: str) -> None:
    outcome = calibrated[name]
    assert 7 in outcome.result["outlying"]
    assert "outlying: position" in outcome.out
    assert [row["outlying"] for row in outcome.rows("residuals.csv")][6] == "1"


OPTIONS: dict[str, dict[str, object]] = {
    "g": {"noise": 1e-5},
    "linear": {"estimator": Linear()},
    "counts": {"unit": Unit("counts", None, 32768.0)},
    "columns": {"noise": "columns"},
    "bisquare": {"estimator": Iterated(loss=Bisquare())},
}


@pytest.mark.parametrize("name", OPTIONS)
def test_the_function_gives_what_the_command_gives(
    calibrated: dict[str, Outcome],
    folder: Path,
    tmp_path: Path,
    name: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    data = COMMANDS[name][0].removeprefix("data=")
    found = calibrated_from(read_readings(folder / data), **OPTIONS[name])  # type: ignore[arg-type]
    recorded = calibration(calibrated[name])
    assert estimates(calibrated[name]).tolist() == found.estimate.parameters.tolist()
    assert recorded["correction"] == found.correction.entries()
    assert recorded["chi_square"] == found.chi_square
    assert calibrated[name].result["outlying"] == found.outlying
    assert list(tmp_path.iterdir()) == []
    assert capsys.readouterr() == ("", "")


def test_an_array_of_means_is_enough_and_stays_as_it_is(calibrated: dict[str, Outcome], folder: Path) -> None:
    means = read_readings(folder / "g.csv").means.copy()
    before = means.copy()
    found = calibrated_from(means, noise=1e-5)
    assert found.estimate.parameters.tolist() == estimates(calibrated["g"]).tolist()
    means[0] = 9.0
    np.testing.assert_array_equal(found.readings.means, before)
    with pytest.raises(DataError, match=r"readings: means of shape \(3,\), expected \(n, k\)"):
        calibrated_from(before[0])
    with pytest.raises(DataError, match="readings: means must be numbers"):
        calibrated_from([["west", 0, 1]])  # type: ignore[arg-type]
    with pytest.raises(SingularError, match=r"as in groups=\(\"bias\", \"scale\"\)"):
        calibrated_from(parts.FACES + 0.01)


def test_a_record_says_what_it_is_of(calibrated: dict[str, Outcome]) -> None:
    result = calibrated["si"].result
    assert result["model"] == described(ScalarAccel())
    assert result["estimator"] == described(Iterated())
    assert result["unit"] == {"class": "Unit", "name": "m/s^2", "per_g": 9.81, "offset": 0.0}
    assert calibrated["bisquare"].result["estimator"]["loss"] == {"class": "Bisquare", "tuning": 4.685}
    assert calibrated["faces"].result["model"] == described(ScalarAccel())


@pytest.mark.parametrize("noise", [1e-4, 1e-9, 1e-12])
def test_errors_are_shown_however_small_they_are(noise: float) -> None:
    measured = ScalarAccel().readings(TRUTH, FORCE)
    found = calibrated_from(Readings("simulated", measured), noise=noise)
    rows = [line.split() for line in parameters_table(found).splitlines()[1:]]
    for row, value, error in zip(rows, found.estimate.parameters, found.estimate.standard_errors, strict=True):
        assert float(row[3]) == pytest.approx(error, rel=0.02 if noise == 1e-4 else 5e-4)
        assert float(row[2]) == pytest.approx(value, abs=0.1 * error)
        assert float(row[4]) < float(row[2]) < float(row[6])


def test_a_recording_leaves_its_static_positions(calibrated: dict[str, Outcome]) -> None:
    outcome = calibrated["raw"]
    rows = outcome.rows("static.csv")
    assert len(rows) == outcome.result["n"] == 18
    assert all(300 < int(row["n"]) < 600 for row in rows)


def test_positions_that_cannot_carry_the_model_are_answered(calibrated: dict[str, Outcome]) -> None:
    outcome = calibrated["faces"]
    assert outcome.status == 1
    assert outcome.err == f"acalx: {outcome.result['message']}\n"
    assert "6 positions can't estimate all the 9 parameters; they can't see: " in outcome.err
    assert "model.groups=[bias,scale]" in outcome.err
    assert outcome.result["status"] == "singular"
    assert len(outcome.result["inestimable"]) == 3
    assert outcome.files == {"result.json"}
    six = calibrated["six"]
    assert six.status == 0, six.err
    assert len(estimates(six)) == 6
    assert "nothing tells the noise" in six.result["message"]


@pytest.mark.parametrize("name", ["g", "si", "counts"])
def test_readings_are_made_right(calibrated: dict[str, Outcome], folder: Path, name: str) -> None:
    data = f"{name}.csv"
    columns = ("columns=[x,y,z]",) if name == "si" else ()
    outcome = calibrate(folder, f"apply={name}/calibration.json", f"data={data}", *columns, into=f"right_{name}")
    assert outcome.status == 0, outcome.err
    assert outcome.files == {"corrected.csv", "result.json"}
    rows = outcome.rows("corrected.csv")
    before = (folder / data).read_text().splitlines()
    assert [",".join(list(row.values())[:3]) for row in rows] == before[1:]
    right = np.array([[float(value) for value in list(row.values())[3:]] for row in rows])
    np.testing.assert_allclose(right, FORCE["specific_force"], atol=1e-4)
    assert outcome.result["mean_magnitude_g"] == pytest.approx(1.0, abs=1e-4)
    again = read_correction(folder / name)
    assert again.unit == {"g": "g", "si": "m/s^2", "counts": "counts"}[name]


def test_a_configuration_that_cannot_be_read_is_no_model(calibrated: dict[str, Outcome], folder: Path) -> None:
    (folder / "torn").mkdir()
    (folder / "torn" / "calibration.json").write_text(calibrated["g"].text("calibration.json"))
    (folder / "torn" / "resolved.yaml").write_text("model: {")
    assert_refused(calibrate(folder, "apply=torn", "data=g.csv", into="torn_1"), "resolved.yaml", "give model=NAME")
    named = calibrate(folder, "apply=torn", "data=g.csv", "model=scalar_accel", into="torn_2")
    assert named.status == 0, named.err


@pytest.mark.parametrize("data", ["word.csv", "nan.csv"])
def test_nothing_is_half_corrected(calibrated: dict[str, Outcome], folder: Path, data: str) -> None:
    outcome = calibrate(folder, "apply=g/calibration.json", f"data={data}", into=f"half_{data}")
    assert_refused(outcome, f"{data}, row ")
    assert outcome.files == {"result.json"}


@pytest.fixture(scope="module")
def refused(folder: Path) -> list[Outcome]:
    return together(
        partial(calibrate, folder, *arguments, into=f"refused_{k}") for k, (arguments, _) in enumerate(REFUSED)
    )


@pytest.mark.parametrize("k", range(len(REFUSED)), ids=[" ".join(arguments) or "nothing" for arguments, _ in REFUSED])
def test_bad_input_gets_one_plain_message(refused: list[Outcome], k: int) -> None:
    assert_refused(refused[k], *REFUSED[k][1])
    assert refused[k].files == {"result.json"}


@needs_measured
def test_a_real_recording_from_end_to_end(tmp_path: Path) -> None:
    counts = ("unit=counts", "unit.per_g=null", "figures=false")
    raw, static, six = together(
        [
            partial(
                calibrate, tmp_path, f"data={XSENS_RAW}", "static=variance", *counts, "unit.offset=32768", into="a"
            ),
            partial(calibrate, tmp_path, f"data={XSENS}", *counts, into="b"),
            partial(calibrate, tmp_path, f"data={FERRARIS}", "unit=m_s2", into="c"),
        ]
    )
    assert abs(raw.result["n"] - static.result["n"]) <= 1
    np.testing.assert_allclose(estimates(raw), estimates(static), atol=2e-4)
    assert six.result["status"] == "singular"
    right = calibrate(tmp_path, "apply=a", f"data={XSENS_RAW}", into="d")
    assert right.result["n"] == 51175
