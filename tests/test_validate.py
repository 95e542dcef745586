"""Validation on positions held out: its arithmetic, real sensors, and the command."""

from __future__ import annotations

import json
from functools import partial
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

import parts
from acalx.criteria import D
from acalx.errors import ArgumentError, DataError
from acalx.estimation import Huber, Iterated, Linear, Readings, Unit, calibrate, read_groups, read_readings
from acalx.models import ScalarAccel
from acalx.numerics.arrays import Array
from acalx.programs import find_program
from acalx.quantities.stimulus import Stimulus
from acalx.recording.parts import described
from acalx.recording.run_directory import RunDirectory
from acalx.recording.validation import record
from acalx.reporting.validation import show
from acalx.validation import Validated, ValidatedSensor, Validation
from acalx.validation import validate as validated_from
from acalx.validation.comparison import compare_programs, directions_of
from acalx.validation.splits import held_out, random_splits, take_folds, validate_folds, validate_splits
from acalx.validation.subsets import best_positions, efficiency, nearest_positions, random_positions, random_turns
from command import Outcome, assert_refused, run, together
from measured import FERRARIS, METERS, MIKOFF, MIMU, MIMU_COUNTS, needs_measured

MODEL = ScalarAccel()
COUNTS = Unit("counts", None, 32768.0)


def directions(name: str) -> Array:
    force = parts.FULL.stimulus(find_program(name).settings_for(parts.FULL))["specific_force"]
    assert force is not None
    return force


def readings(name: str = "dodecahedron_20", noise: float = 1e-4, seed: int = 0, n: int | None = None) -> Readings:
    rng = np.random.default_rng(seed)
    truth = 0.02 * np.random.default_rng(9).standard_normal(9)
    w = MODEL.readings(truth, Stimulus(specific_force=directions(name)[:n]))
    return Readings(name, w + noise * rng.standard_normal(w.shape))


def in_counts(given: Readings) -> Readings:
    return Readings(given.name, 32768.0 + 4000.0 * given.means)


# ---------------------------------------------------------------- splits


def test_held_out_positions_by_hand() -> None:
    train, test = readings(), readings("icosahedron_12", seed=1)
    found = held_out(train, test, MODEL, Iterated(), Unit())
    right = calibrate(train, MODEL, Iterated(), Unit()).correction.apply(test.means)
    after, before = (np.linalg.norm(w, axis=1) - 1.0 for w in (right, test.means))
    np.testing.assert_allclose(found.after[0], after, atol=1e-12)
    np.testing.assert_allclose(found.before[0], before, atol=1e-12)
    assert found.r_squared[0] == pytest.approx(1.0 - after.var() / before.var())
    assert found.rms[0] == pytest.approx(np.sqrt(np.mean(after**2)))
    assert found.rms[0] < 3e-4


def test_the_unit_makes_no_difference() -> None:
    given = readings()
    train, test = random_splits(20, 0.667, 10, np.random.default_rng(0))
    in_g = validate_splits(given, train, test, MODEL, Iterated(), Unit())
    found = validate_splits(in_counts(given), train, test, MODEL, Iterated(), COUNTS)
    np.testing.assert_allclose(found.r_squared, in_g.r_squared, atol=1e-5)
    np.testing.assert_allclose(found.rms, in_g.rms, rtol=0.03)


def test_leaving_one_out_of_the_linear_model_by_leverage() -> None:
    given = readings(noise=1e-3)
    calibration = calibrate(given, MODEL, Linear(), Unit())
    found = validate_folds(given, take_folds(20, 20, np.random.default_rng(0)), MODEL, Linear(), Unit())
    np.testing.assert_allclose(found.after, calibration.estimate.residual / (1 - calibration.leverage), rtol=1e-8)


def test_splits_and_folds_hold_each_position_out_once() -> None:
    rng = np.random.default_rng(0)
    train, test = random_splits(20, 0.667, 30, rng)
    assert (train.shape, test.shape) == ((30, 13), (30, 7))
    assert (np.sort(np.hstack([train, test]), axis=1) == np.arange(20)).all()
    assert len({tuple(sorted(row)) for row in train.tolist()}) > 25
    folds = take_folds(20, 3, rng)
    assert sorted(np.concatenate(folds).tolist()) == list(range(20))
    assert sorted(map(len, folds)) == [6, 7, 7]


def test_splits_that_cannot_show_the_parameters_are_counted() -> None:
    given = readings("classical_12", noise=0.0)
    train = np.array([np.arange(10), np.arange(2, 12)])
    test = np.array([[10, 11], [0, 1]])
    found = validate_splits(given, train, test, MODEL, Iterated(), Unit())
    assert found.failed == 2
    assert (found.r_squared == -np.inf).all()
    assert (found.rms == np.inf).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda rng: random_splits(20, 2.0, 5, rng), "share=2.0"),
        (lambda rng: random_splits(20, 0.5, 0, rng), "splits=0"),
        (lambda rng: take_folds(20, 21, rng), "folds=21"),
        (lambda rng: take_folds(20, 1, rng), "folds=1"),
    ],
)
def test_impossible_splits_are_refused(call: object, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        call(np.random.default_rng(0))  # type: ignore[operator]
    with pytest.raises(DataError, match="fewer than two to test on"):
        random_splits(10, 0.9, 5, np.random.default_rng(0))


# ---------------------------------------------------------------- programs on measured positions


def test_nearest_positions_of_a_program_that_was_measured_are_its_own() -> None:
    rng = np.random.default_rng(0)
    measured = directions("dodecahedron_20")
    order = rng.permutation(20)[:12]
    found, angles = nearest_positions(measured, measured[order])
    assert found.tolist() == order.tolist()
    np.testing.assert_allclose(angles, 0.0, atol=1e-7)
    # each is taken once even where two want the same
    found, _ = nearest_positions(measured, np.repeat(measured[:1], 3, axis=0))
    assert len(set(found.tolist())) == 3


def test_turns_are_rotations_and_make_angles_smaller() -> None:
    rng = np.random.default_rng(0)
    turns = random_turns(300, rng)
    np.testing.assert_allclose(turns @ turns.swapaxes(1, 2), np.broadcast_to(np.eye(3), turns.shape), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(turns), 1.0)
    measured, program = directions("dodecahedron_20") @ turns[7], directions("icosahedron_12")
    _, plain = nearest_positions(measured, program)
    _, turned = nearest_positions(measured, program, turns)
    assert turned.mean() < plain.mean()


def test_best_positions_are_those_of_all_subsets() -> None:
    measured = directions("rotations_12") @ random_turns(2, np.random.default_rng(1))[1]
    measured = measured + 0.2 * np.random.default_rng(2).standard_normal(measured.shape)
    measured /= np.linalg.norm(measured, axis=1, keepdims=True)
    found = best_positions(Stimulus(specific_force=measured), 10, MODEL, D(), np.random.default_rng(0))
    subsets = [list(subset) for subset in combinations(range(12), 10)]
    shares = efficiency(measured[np.array(subsets)], MODEL)
    assert found.tolist() == subsets[int(np.argmax(shares))]


def test_efficiency_is_one_where_the_bound_is_attained() -> None:
    for name in ("icosahedron_12", "dodecahedron_20"):
        assert efficiency(directions(name), MODEL) == pytest.approx(1.0)
    # D of Table 1 against D1 / n^9
    expected = (0.0396916 / 0.048932) ** (1 / 9)
    assert efficiency(directions("egorov_2021_table_1"), MODEL) == pytest.approx(expected, rel=1e-4)
    assert efficiency(directions("classical_6"), MODEL) == 0.0


def test_programs_are_compared_on_the_positions_near_them() -> None:
    given = readings(noise=1e-4)
    calibration = calibrate(given, MODEL, Iterated(), Unit())
    np.testing.assert_allclose(directions_of(calibration), directions("dodecahedron_20"), atol=1e-3)
    programs = {name: directions(name) for name in ("icosahedron_12", "classical_6", "dodecahedron_20")}
    rows = compare_programs(calibration, programs, D(), Iterated(), np.random.default_rng(0), subsets=[10], turns=20)
    assert [(row.name, row.n) for row in rows] == [
        ("best 10 measured", 10),
        ("random 10, median", 10),
        ("icosahedron_12", 12),
        ("best 12 measured", 12),
        ("random 12, median", 12),
    ]
    by_name = {row.name: row for row in rows}
    assert by_name["best 12 measured"].efficiency >= by_name["icosahedron_12"].efficiency
    assert by_name["best 10 measured"].efficiency > by_name["random 10, median"].efficiency
    assert all(row.r_squared > 0.9 for row in rows)


# ---------------------------------------------------------------- real sensors


@needs_measured
def test_the_72_triads_of_an_array_are_right_on_positions_that_were_held_out() -> None:
    rng = np.random.default_rng(0)
    sensors = read_groups(MIMU, ["experiment", "imu"])
    assert len(sensors) == 72
    shares, designed, random = [], {10: [], 12: []}, {10: [], 12: []}  # type: ignore[var-annotated]
    for given in sensors.values():
        train, test = random_splits(20, 2 / 3, 100, rng)
        splits = validate_splits(given, train, test, MODEL, Iterated(), MIMU_COUNTS)
        shares.append(np.median(splits.r_squared))
        vertical = directions_of(calibrate(given, MODEL, Iterated(), MIMU_COUNTS))
        for n in (10, 12):
            chosen = best_positions(Stimulus(specific_force=vertical), n, MODEL, D(), rng, starts=3)[None]
            others = random_positions(20, n, 50, rng)
            for taken, found in ((chosen, designed[n]), (others, random[n])):
                rest = np.array([np.setdiff1d(np.arange(20), row) for row in taken])
                tested = validate_splits(given, taken, rest, MODEL, Iterated(), MIMU_COUNTS)
                found.append(np.median(tested.rms))
    assert np.median(shares) >= 0.9997
    assert min(shares) >= 0.98
    for n, factor in ((10, 0.7), (12, 0.9)):
        assert np.median(designed[n]) < factor * np.median(random[n])
        assert np.mean(np.array(designed[n]) < np.array(random[n])) > 0.9


@needs_measured
@pytest.mark.parametrize("path", MIKOFF, ids=lambda path: path.stem)
def test_five_sensors_are_right_on_positions_that_were_held_out(path: Path) -> None:
    given = read_readings(path)
    train, test = random_splits(given.n, 2 / 3, 500, np.random.default_rng(0))
    assert np.median(validate_splits(given, train, test, MODEL, Iterated(), METERS).r_squared) >= 0.997
    huber = Iterated(loss=Huber())
    assert validate_folds(given, take_folds(22, 22, np.random.default_rng(0)), MODEL, huber, METERS).r_squared > 0.99


# ---------------------------------------------------------------- the command


def table(header: str, rows: Array) -> str:
    return header + "\n" + "".join(",".join(f"{value:.10g}" for value in row) + "\n" for row in rows)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("validate")
    first, second = readings(), readings(seed=1)
    both = np.concatenate([first.means, second.means])
    labeled = np.column_stack([np.repeat([1, 2], 20), both])
    texts = {
        "one.csv": table("ax,ay,az", first.means),
        "two.csv": table("imu,ax,ay,az", labeled),
        "half.csv": table("imu,ax,ay,az", labeled[:20]),
        "twelve.csv": table("ax,ay,az", readings("icosahedron_12").means),
        "nine.csv": table("ax,ay,az", readings("egorov_2021_table_1").means),
        "faces.csv": table("ax,ay,az", parts.FACES.astype(float)),
        "mine.csv": table("eta_x,eta_y,eta_z", directions("icosahedron_12")),
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def validate(folder: Path, *arguments: str, into: str) -> Outcome:
    return run(folder, *arguments, into=into, entry="validate")


COMMANDS = {
    "one": ("data=one.csv", "splits=50", "turns=10", "programs=[mine.csv,axes_and_edges_9]"),
    "two": ("data=two.csv", "by=[imu]", "splits=20", "turns=1", "figures=false"),
    "test": ("data=one.csv", "test=twelve.csv", "figures=false"),
    "twelve": ("data=twelve.csv", "programs=[]", "figures=false"),
    "faces": ("data=faces.csv",),
}
REFUSED = [
    ((), ("which measurements",)),
    (("data=nowhere.csv",), ("no file nowhere.csv",)),
    (("data=nine.csv",), ("9 positions for 9 parameters leave none to test on", "test=FILE.csv")),
    (("data=one.csv", "by=[imu]"), ("no column 'imu'",)),
    (("data=one.csv", "by=imu"), ("by=imu", "names of columns")),
    (("data=two.csv", "test=half.csv", "by=[imu]"), ("the test file has no sensor 2",)),
    (("data=one.csv", "folds=30"), ("folds=30", "the 20 positions")),
    (("data=one.csv", "share=1.5"), ("share=1.5",)),
    (("data=one.csv", "splits=none"), ("splits=none",)),
    (("data=one.csv", "seed=-1"), ("seed=-1",)),
    (("data=one.csv", "turns=0"), ("turns=0",)),
    (("data=one.csv", "programs=[icosahedrn_12]"), ("icosahedrn_12", "did you mean icosahedron_12")),
    (("data=one.csv", "unit=m_s2"), ("mean magnitude", "unit=g")),
    (("data=one.csv", "criterion=d_fair", "model.groups=[bias,scale]"), ("nonorthogonality",)),
]


@pytest.fixture(scope="module")
def validated(folder: Path) -> dict[str, Outcome]:
    calls = [partial(validate, folder, *arguments, into=name) for name, arguments in COMMANDS.items()]
    return dict(zip(COMMANDS, together(calls), strict=True))


def test_one_sensor(validated: dict[str, Outcome]) -> None:
    outcome = validated["one"]
    assert outcome.status == 0, outcome.err
    assert outcome.err == ""
    tables = {"validation.json", "validation.csv", "programs.csv"}
    assert outcome.files == tables | {"result.json", "validation.svg", "validation.png"}
    for way in ("splits", "folds", "leave_one_out"):
        assert 0.99 < outcome.metrics[f"{way}_r_squared"] < 1.0
        assert 0.5e-4 < outcome.metrics[f"{way}_rms_g"] < 4e-4
    names = [row["program"] for row in outcome.rows("programs.csv")]
    assert names == [
        "axes_and_edges_9",
        "best 9 measured",
        "random 9, median",
        "mine.csv",
        "best 12 measured",
        "random 12, median",
    ]
    assert "calibrated on the nearest to" in outcome.out
    assert json.loads(outcome.text("validation.json"))["programs"][3]["name"] == "mine.csv"


def test_the_function_gives_what_the_command_gives(
    validated: dict[str, Outcome],
    folder: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    data = {name: read_readings(folder / f"{name}.csv") for name in ("one", "twelve")}
    chosen = [find_program(str(folder / "mine.csv")), "axes_and_edges_9"]
    one = validated_from(data["one"], splits=50, turns=10, programs=chosen)
    groups = read_groups(folder / "two.csv", ["imu"])
    two = validated_from({key[0]: group for key, group in groups.items()}, splits=20, turns=1)
    test = validated_from(data["one"], test=data["twelve"])
    for name, found in (("one", one), ("two", two), ("test", test)):
        entries = json.loads(validated[name].text("validation.json"))
        assert [sensor["sensor"] for sensor in entries["sensors"]] == [sensor.name for sensor in found.sensors]
        for entry, sensor in zip(entries["sensors"], found.sensors, strict=True):
            assert {key: entry[key] for key in sensor.figures} == sensor.figures
        assert [row["rms_g"] for row in entries["programs"]] == [row.rms for row in found.programs]
        assert validated[name].metrics == found.medians
    assert validated["one"].result["criterion"] == described(D())
    assert list(tmp_path.iterdir()) == []
    assert capsys.readouterr() == ("", "")


def test_what_the_function_can_not_use_is_refused() -> None:
    given = readings()
    with pytest.raises(DataError, match="there are no readings"):
        validated_from({})
    with pytest.raises(DataError, match="no sensor two"):
        validated_from({"two": given}, test={"one": given})
    with pytest.raises(DataError, match="leave none to test on; give test=READINGS"):
        validated_from(readings("egorov_2021_table_1"), programs=())
    with pytest.raises(ArgumentError, match="turns=0"):
        validated_from(given, turns=0)


def test_arrays_are_programs_and_readings_too() -> None:
    given = readings()
    wanted = directions("icosahedron_12")
    found = validated_from(given.means, programs=[wanted], splits=5, turns=3)
    assert [row.name for row in found.programs] == ["program 1", "best 12 measured", "random 12, median"]
    again = validated_from(given, programs=["icosahedron_12"], splits=5, turns=3)
    assert found.programs[0].rms == pytest.approx(again.programs[0].rms)


def test_errors_are_shown_however_small_they_are(capsys: pytest.CaptureFixture[str]) -> None:
    tiny = Validation(np.full(4, 1e-2), 1.2345e-9 * np.array([1.0, -1.0, 1.0, -1.0]))
    figures = {"test_r_squared": float(tiny.r_squared), "test_rms_g": float(tiny.rms)}
    show(Validated([ValidatedSensor("1", 20, figures, tiny, [])]))
    assert "1.234e-06" in capsys.readouterr().out


def test_several_sensors_in_a_file(validated: dict[str, Outcome]) -> None:
    outcome = validated["two"]
    assert outcome.status == 0, outcome.err
    rows = outcome.rows("validation.csv")
    assert [row["sensor"] for row in rows] == ["1", "2"]
    middle = np.median([float(row["leave_one_out_rms_g"]) for row in rows])
    assert outcome.metrics["leave_one_out_rms_g"] == pytest.approx(middle)
    assert "median of 2" in outcome.out
    assert "faces_and_edges_18" in outcome.out


def test_another_file_as_the_test(validated: dict[str, Outcome], folder: Path) -> None:
    outcome = validated["test"]
    assert outcome.status == 0, outcome.err
    train, test = (read_readings(folder / name) for name in ("one.csv", "twelve.csv"))
    expected = held_out(train, test, MODEL, Iterated(), Unit())
    assert outcome.metrics["test_rms_g"] == pytest.approx(float(expected.rms[0]))
    assert set(outcome.metrics) == {"test_rms_g", "test_r_squared"}


def test_ways_that_leave_too_few_positions_are_left_out(validated: dict[str, Outcome]) -> None:
    outcome = validated["twelve"]
    assert outcome.status == 0, outcome.err
    assert set(outcome.metrics) == {
        f"{way}_{what}" for way in ("folds", "leave_one_out") for what in ("r_squared", "rms_g")
    }


def test_sensors_of_different_sizes_are_shown_together(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    few, many = readings(n=11), readings()
    for order in (("few", "many"), ("many", "few")):
        both = validated_from({name: {"few": few, "many": many}[name] for name in order}, programs=[])
        assert "splits_r_squared" in both.medians
        show(both)
        rows = capsys.readouterr().out.splitlines()
        assert rows[0].split()[:2] == ["sensor", "positions"]
        cells = {row.split()[0]: row.split() for row in rows[1:4]}
        assert cells["few"].count("-") > cells["many"].count("-") == 0
        assert len(cells["few"]) == len(cells["many"])
        directory = RunDirectory(tmp_path / order[0], [])
        record(both, "data.csv", None, directory)
        table = (tmp_path / order[0] / "validation.csv").read_text().splitlines()
        assert {len(line.split(",")) for line in table} == {len(both.medians) + 2}


def test_positions_that_cannot_carry_the_model_are_answered(validated: dict[str, Outcome]) -> None:
    outcome = validated["faces"]
    assert outcome.status == 1
    assert outcome.result["status"] == "singular"
    assert len(outcome.result["inestimable"]) == 3


@pytest.fixture(scope="module")
def refused(folder: Path) -> list[Outcome]:
    return together(
        partial(validate, folder, *arguments, into=f"refused_{k}") for k, (arguments, _) in enumerate(REFUSED)
    )


@pytest.mark.parametrize("k", range(len(REFUSED)), ids=[" ".join(arguments) or "nothing" for arguments, _ in REFUSED])
def test_bad_input_gets_one_plain_message(refused: list[Outcome], k: int) -> None:
    assert_refused(refused[k], *REFUSED[k][1])
    assert refused[k].files == {"result.json"}


@needs_measured
def test_real_sensors_by_the_command(tmp_path: Path) -> None:
    one, six = together(
        [
            partial(validate, tmp_path, f"data={MIKOFF[0]}", "unit=m_s2", "turns=5", "figures=false", into="a"),
            partial(validate, tmp_path, f"data={FERRARIS}", "unit=m_s2", "figures=false", into="b"),
        ]
    )
    assert one.metrics["splits_r_squared"] > 0.997
    assert six.result["status"] == "singular"
