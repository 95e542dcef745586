"""Estimates against simulated sensors whose parameters are known, and against real ones."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import parts
from acalx.errors import ArgumentError, DataError
from acalx.estimation import (
    Bisquare,
    Estimator,
    Huber,
    Iterated,
    Linear,
    Loss,
    Readings,
    SingularError,
    Squares,
    StaticIntervals,
    Unit,
    calibrate,
    read_correction,
    read_groups,
    read_readings,
)
from acalx.models import Magnitude, Projection, ScalarAccel
from acalx.numerics.arrays import Array
from acalx.numerics.sphere import fit_sphere
from acalx.programs import find_program
from acalx.quantities.stimulus import Stimulus
from acalx.testing import check_loss
from measured import FERRARIS, METERS, XSENS, XSENS_COUNTS, XSENS_RAW, needs_measured

MODEL, SIX = ScalarAccel(), ScalarAccel(groups=("bias", "scale"))
TABLE_2 = parts.FULL.stimulus(find_program("egorov_2021_table_2").settings_for(parts.FULL))
ESTIMATORS: list[Estimator] = [
    Linear(),
    Linear(comparison=Projection()),
    Iterated(),
    Iterated(comparison=Projection()),
    Iterated(loss=Huber()),
    Iterated(loss=Bisquare()),
]
LOSSES: list[Loss] = [Squares(), Huber(), Bisquare(), Huber(2.0)]


def sensors(size: float, count: int = 50, noise: float = 0.0, model: ScalarAccel = MODEL) -> tuple[Array, Array]:
    """Parameters (count, p) and readings (count, 18, 3) of random sensors."""
    rng = np.random.default_rng(7)
    truth = size * rng.standard_normal((count, len(model.parameters)))
    measurement = model.readings(truth, TABLE_2)
    return truth, measurement + noise * rng.standard_normal(measurement.shape)


def readings(measurement: Array, **parts_: object) -> Readings:
    return Readings("simulated", measurement, **parts_)  # type: ignore[arg-type]


# ---------------------------------------------------------------- estimators


def test_iterated_estimate_of_large_errors_is_exact_and_the_linear_one_is_not() -> None:
    truth, measurement = sensors(0.05)
    iterated = Iterated().estimate(MODEL, measurement)
    assert iterated.converged.all()
    np.testing.assert_allclose(iterated.parameters, truth, atol=1e-10)
    np.testing.assert_allclose(iterated.residual, 0.0, atol=1e-12)
    linear = Linear().estimate(MODEL, measurement)
    # errors of second order: 5 % squared, times what the program makes of it
    assert 1e-3 < np.abs(linear.parameters - truth).std() < 1e-2


def test_the_oriented_residual_is_linear_and_exact() -> None:
    truth, measurement = sensors(0.05)
    for estimator in (Linear(comparison=Projection()), Iterated(comparison=Projection())):
        np.testing.assert_allclose(estimator.estimate(MODEL, measurement, TABLE_2).parameters, truth, atol=1e-13)
    with pytest.raises(DataError, match="needs the direction of the vertical in each position"):
        calibrate(readings(measurement[0]), MODEL, Linear(comparison=Projection()))


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=repr)
def test_estimates_of_a_stack_are_those_of_its_members(estimator: Estimator) -> None:
    _, measurement = sensors(0.01, 6, noise=1e-4)
    whole = estimator.estimate(MODEL, measurement.reshape(2, 3, 18, 3), TABLE_2)
    assert whole.parameters.shape == (2, 3, 9)
    assert whole.residual.shape == (2, 3, 18)
    assert whole.converged.all()
    for k, member in enumerate(measurement):
        one = estimator.estimate(MODEL, member, TABLE_2)
        np.testing.assert_allclose(whole.parameters.reshape(6, 9)[k], one.parameters, atol=1e-9)
        np.testing.assert_allclose(whole.covariance.reshape(6, 9, 9)[k], one.covariance, rtol=1e-5)


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=repr)
def test_standard_errors_are_the_scatter_of_the_estimates(estimator: Estimator) -> None:
    count = 600 if estimator.loss.robust else 3000
    truth, measurement = sensors(1e-3, count, noise=1e-5)
    known = estimator.estimate(MODEL, measurement, TABLE_2, noise=np.full(18, 1e-5))
    scatter = (known.parameters - truth).std(axis=0)
    np.testing.assert_allclose(scatter, known.standard_errors.mean(axis=0), rtol=0.06 if count == 3000 else 0.12)
    estimated = estimator.estimate(MODEL, measurement, TABLE_2)
    mean = np.sqrt((estimated.standard_errors**2).mean(axis=0))
    # with nine residuals for nine parameters the robust ones can't tell their own accuracy well
    np.testing.assert_allclose((estimated.parameters - truth).std(axis=0), mean, rtol=0.06 if count == 3000 else 0.4)


def test_a_member_that_is_singular_leaves_the_others_alone() -> None:
    truth, measurement = sensors(0.01, 4)
    measurement[2] = measurement[2, 0]
    estimate = Iterated().estimate(MODEL, measurement)
    assert estimate.converged.tolist() == [True, True, False, True]
    assert np.isnan(estimate.parameters[2]).all()
    np.testing.assert_allclose(estimate.parameters[[0, 1, 3]], truth[[0, 1, 3]], atol=1e-10)


def test_positions_of_little_noise_count_more() -> None:
    rng = np.random.default_rng(1)
    truth, measurement = sensors(1e-3, 2000)
    noise = np.where(np.arange(18) < 12, 1e-6, 1e-3)
    noisy = measurement + noise[:, None] * rng.standard_normal(measurement.shape)
    weighted = Iterated().estimate(MODEL, noisy, noise=noise)
    np.testing.assert_allclose(
        (weighted.parameters - truth).std(axis=0), weighted.standard_errors.mean(axis=0), rtol=0.06
    )
    plain = Iterated().estimate(MODEL, noisy)
    assert (weighted.parameters - truth).std() < 0.1 * (plain.parameters - truth).std()


@pytest.mark.parametrize("loss", [Huber(), Bisquare()], ids=repr)
def test_a_robust_loss_is_not_misled_by_a_gross_error(loss: Loss) -> None:
    truth, measurement = sensors(0.01, 200, noise=1e-5)
    measurement[:, 4] *= 1.01
    error = Iterated(loss=loss).estimate(MODEL, measurement).parameters - truth
    misled = Iterated().estimate(MODEL, measurement).parameters - truth
    assert np.median(np.abs(error)) < 0.1 * np.median(np.abs(misled))


@pytest.mark.parametrize("loss", LOSSES, ids=repr)
def test_losses_weigh_by_their_influence(loss: Loss) -> None:
    check_loss(loss)


def test_usual_tunings_cost_five_percent() -> None:
    assert Huber().variance_factor == pytest.approx(1 / 0.95, abs=1e-3)
    assert Bisquare().variance_factor == pytest.approx(1 / 0.95, abs=1e-3)
    assert Squares().variance_factor == 1.0


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Huber(0.1), "tuning=0.1"),
        (lambda: Bisquare("wide"), "tuning='wide'"),
        (lambda: Iterated(comparison=3), "comparison=3: must be Magnitude"),
        (lambda: Linear(loss="huber"), "loss='huber': must be Squares"),
        (lambda: Iterated(tolerance=0.0), "tolerance=0.0"),
        (lambda: Iterated(iterations=True), "iterations=True"),
        (lambda: Unit(per_g=-1.0), "per_g=-1.0"),
        (lambda: Unit(name=""), "name=''"),
        (lambda: Unit(offset=float("nan")), "offset=nan"),
        (lambda: StaticIntervals(window_s=0.05), "each must be longer"),
        (lambda: StaticIntervals(factor=-1), "factor=-1: give a positive number"),
        (lambda: StaticIntervals(quiet=1.5), "quiet=1.5: give a share below 1"),
        (lambda: Iterated(loss=Huber()).estimate(MODEL, np.ones((9, 3))), "robust loss needs more positions"),
    ],
)
def test_options_that_make_no_sense_are_refused(build: object, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        build()  # type: ignore[operator]


# ---------------------------------------------------------------- one sensor


def test_intervals_cover_as_often_as_they_say() -> None:
    truth, measurement = sensors(0.01, 2000, noise=1e-4)
    estimate = Iterated().estimate(MODEL, measurement)
    first = calibrate(readings(measurement[0]), MODEL, Iterated(), Unit())
    factor = first.half_widths / first.estimate.standard_errors
    covered = np.abs(estimate.parameters - truth) < factor * estimate.standard_errors
    assert 0.935 < covered.mean() < 0.965
    assert (np.abs(covered.mean(axis=0) - 0.95) < 0.02).all()


@pytest.mark.parametrize("per_g", [None, 2048.0])
@pytest.mark.parametrize("offset", [0.0, 32768.0])
def test_counts_are_corrected_whether_their_scale_is_known_or_not(per_g: float | None, offset: float) -> None:
    truth, measurement = sensors(0.05, 1)
    counts = offset + 2048.0 * measurement[0]
    calibration = calibrate(readings(counts), MODEL, Iterated(), Unit("counts", per_g, offset))
    corrected = calibration.correction.apply(counts)
    np.testing.assert_allclose(np.linalg.norm(corrected, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(corrected, TABLE_2["specific_force"], atol=1e-10)
    if per_g is None:
        assert calibration.estimate.parameters[3:6].sum() == pytest.approx(0.0, abs=1e-12)
        sensitivity = calibration.unit.per_g * (1.0 + calibration.estimate.parameters[3:6])
        np.testing.assert_allclose(sensitivity, 2048.0 * (1.0 + truth[0, 3:6]), rtol=1e-10)
    else:
        np.testing.assert_allclose(calibration.estimate.parameters, truth[0], atol=1e-10)


def test_an_offset_that_nobody_mentioned_is_found() -> None:
    _, measurement = sensors(0.02, 1)
    counts = 32768.0 + 4096.0 * measurement[0]
    calibration = calibrate(readings(counts), MODEL, Iterated(), Unit("counts", None))
    np.testing.assert_allclose(calibration.correction.apply(counts), TABLE_2["specific_force"], atol=1e-10)


def test_sphere() -> None:
    rng = np.random.default_rng(0)
    directions = rng.standard_normal((3, 9, 3))
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    center, radius = fit_sphere(np.array([5.0, -2.0, 100.0]) + 3.0 * directions)
    np.testing.assert_allclose(center, [[5.0, -2.0, 100.0]] * 3, rtol=1e-9)
    np.testing.assert_allclose(radius, 3.0, rtol=1e-9)


def test_leverage_and_studentized_residuals_against_leaving_positions_out() -> None:
    _, measurement = sensors(1e-3, 1, noise=1e-4)
    calibration = calibrate(readings(measurement[0]), MODEL, Linear(comparison=Magnitude()), Unit())
    assert calibration.leverage.sum() == pytest.approx(9.0)
    residual, rows = MODEL.linearized(np.zeros(9), measurement[0], None)
    for k in range(18):
        others = np.arange(18) != k
        x, (squares,), *_ = np.linalg.lstsq(rows[others], residual[others], rcond=None)
        error = residual[k] - rows[k] @ x
        spread = np.sqrt(squares / 8 * (1 + rows[k] @ np.linalg.inv(rows[others].T @ rows[others]) @ rows[k]))
        assert calibration.studentized[k] == pytest.approx(error / spread, rel=1e-6)


@pytest.mark.parametrize("noise", [None, 1e-5])
def test_positions_are_called_outlying_by_mistake_as_rarely_as_the_confidence_says(noise: float | None) -> None:
    _, measurement = sensors(0.01, 300, noise=1e-5)
    flagged = [bool(calibrate(readings(one), MODEL, Iterated(), Unit(), noise).outlying) for one in measurement]
    assert 0.01 < np.mean(flagged) < 0.09


@pytest.mark.parametrize("noise", [None, 1e-5, "columns"])
def test_an_outlying_position_is_flagged_by_its_number(noise: float | str | None) -> None:
    measurement = sensors(0.01, 4, noise=1e-5)[1][3:]
    spread = {"deviations": np.full((18, 3), 1e-4), "counts": np.full(18, 100.0)}
    good = calibrate(readings(measurement[0], **spread), MODEL, Iterated(), Unit(), noise)
    assert good.outlying == []
    assert good.remarks() == []
    assert (good.chi_square is None) == (noise is None)
    measurement[0, 4] *= 1.002
    bad = calibrate(readings(measurement[0], **spread), MODEL, Iterated(), Unit(), noise)
    assert 5 in bad.outlying
    assert any("outlying: position" in remark for remark in bad.remarks())
    if noise is not None:
        assert bad.chi_square is not None
        assert bad.chi_square["probability"] < 1e-6
        assert any("times what the noise explains" in remark for remark in bad.remarks())
    robust = calibrate(readings(measurement[0]), MODEL, Iterated(loss=Bisquare()), Unit())
    assert 5 in robust.outlying


def test_six_faces_are_refused_for_nine_parameters_and_carry_six() -> None:
    truth = np.array([0.01, -0.02, 0.03, 0.004, -0.005, 0.006])
    measurement = SIX.readings(truth, Stimulus(specific_force=parts.FACES.astype(float)))
    with pytest.raises(SingularError, match="nonorthogonality_xy") as caught:
        calibrate(readings(measurement), MODEL, Iterated(), Unit())
    assert sorted(caught.value.inestimable) == [f"nonorthogonality_{pair}" for pair in ("xy", "xz", "zy")]
    calibration = calibrate(readings(measurement), SIX, Iterated(), Unit(), noise=1e-5)
    np.testing.assert_allclose(calibration.estimate.parameters, truth, atol=1e-12)
    assert calibration.chi_square is None  # nothing is left to test
    unknown = calibrate(readings(measurement), SIX, Iterated(), Unit())
    assert np.isnan(unknown.half_widths).all()
    assert "nothing tells the noise" in unknown.remarks()[0]


def test_parameters_that_positions_hardly_show_are_named() -> None:
    tilted = find_program("classical_12").settings_for(parts.FULL) + np.radians(
        0.3 * np.random.default_rng(0).standard_normal((12, 2))
    )
    measurement = parts.FULL.stimulus(tilted)["specific_force"]
    assert measurement is not None
    weak = calibrate(readings(measurement), MODEL, Iterated(), Unit(), noise=1e-5).remarks()
    assert "hardly show" in weak[0]
    assert "nonorthogonality" in weak[0]
    assert "bias" not in weak[0]


@pytest.mark.parametrize(
    ("means", "unit", "options", "message"),
    [
        (np.ones((1, 3)), Unit(), {}, "a single position"),
        (np.eye(3)[[0, 1, 2, 0]] * [[1], [1], [0], [1]], Unit(), {}, "position 3 reads 0, 0, 0"),
        (np.full((12, 3), 0.577), Unit(), {}, "all 12 positions read the same"),
        (
            9.81 * TABLE_2["specific_force"],
            Unit(),
            {},
            r"mean magnitude is 9.81, but 1 g should read 1 g; .*\(unit=Unit\(\"m/s\^2\", 9.80665\)\)",
        ),
        (TABLE_2["specific_force"], Unit("m/s^2", 9.81), {}, r"looks like g \(unit=Unit\(\)\)"),
        (4000 * TABLE_2["specific_force"], Unit(), {}, "looks like counts"),
        (TABLE_2["specific_force"], Unit(), {"noise": -1.0}, "noise=-1.0"),
        (TABLE_2["specific_force"], Unit(), {"noise": "columns"}, "noise='columns' needs standard deviations"),
        (TABLE_2["specific_force"], Unit(), {"confidence": 2.0}, "confidence=2.0"),
    ],
)
def test_readings_that_cannot_be_used_are_refused(
    means: Array, unit: Unit, options: dict[str, object], message: str
) -> None:
    with pytest.raises((DataError, ArgumentError), match=message):
        calibrate(readings(means), MODEL, Iterated(), unit, **options)  # type: ignore[arg-type]


def test_an_unknown_scale_must_be_estimated() -> None:
    with pytest.raises(ArgumentError, match="scale is not known"):
        calibrate(
            readings(TABLE_2["specific_force"]),
            ScalarAccel(groups=("bias",)),
            Iterated(),
            Unit("counts", None),  # type: ignore[arg-type]
        )


# ---------------------------------------------------------------- files


def write(folder: Path, text: str, name: str = "data.csv") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_a_file_with_everything(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        "# session 3\nposition;imu;ax;ay;az;sx;sy;sz;n;alpha1_deg;alpha2_deg\n"
        "up;1;0;0;1;.1;.1;.1;100;0;0\nside;1;1;0;0;.1;.2;.1;50;90;0\nup;2;0;0;2;.1;.1;.1;100;0;0\n",
    )
    found = read_readings(path, where={"imu": 1}, stand=parts.FULL)
    assert found.labels == ("up", "side")
    assert found.means.tolist() == [[0, 0, 1], [1, 0, 0]]
    assert found.deviations is not None
    assert found.deviations[1].tolist() == [0.1, 0.2, 0.1]
    assert found.counts is not None
    assert found.counts.tolist() == [100, 50]
    np.testing.assert_allclose(found.stimulus["specific_force"], [[0, 0, 1], [1, 0, 0]], atol=1e-15)
    groups = read_groups(path, ["imu"])
    assert {key: group.n for key, group in groups.items()} == {("1",): 2, ("2",): 1}
    assert found.select([1]).labels == ("side",)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty; a header names the columns"),
        ("ax,ay,az\n", "no positions below it"),
        ("ax,ay\n1,2\n", "no column 'az'; there are ax, ay; columns="),
        ("ax,ay,AZ\n1,2,3\n", r"no column 'az' \(did you mean AZ\?\)"),
        ("1,2,3\n4,5,6\n", "numbers without a header"),
        ("ax,ax,az\n1,2,3\n", "'ax' is there twice"),
        ("ax,ay,az\n1,2,3\n1,two,3\n", "row 3, column ay: 'two' is not a finite number"),
        ("ax,ay,az\n1,2,nan\n", "row 2, column az: 'nan'"),
        ("ax,ay,az\n1,,3\n", "row 2, column ay: empty"),
        ("ax,ay,az\n1,2\n", "row 2: number of fields 2, expected 3"),
        ("ax,ay,az,n\n1,2,3,0\n", "row 2, column n: 0; must be 1 sample or more"),
        ("ax,ay,az,sx,sy,sz\n1,2,3,1,-1,1\n", "row 2, column sy: -1"),
        ("ax,ay,az,eta_x,eta_y,eta_z\n1,2,3,1,1,1\n", "row 2, columns eta_x, eta_y, eta_z: the length"),
    ],
)
def test_faults_of_a_file_are_named_by_row_and_column(tmp_path: Path, text: str, message: str) -> None:
    path = write(tmp_path, text)
    with pytest.raises(DataError, match=message) as caught:
        read_readings(path)
    assert str(path) in str(caught.value)


def test_too_many_rows_are_taken_for_a_recording(tmp_path: Path) -> None:
    path = write(tmp_path, "ax,ay,az\n" + "0,0,1\n" * 20_001)
    with pytest.raises(DataError, match=r"static=StaticIntervals\(\)"):
        read_readings(path)


def recording(folder: Path, rate: float = 100.0, seconds: float = 5.0, times: bool = True) -> tuple[Path, Array]:
    """Positions held for 5 s with motion for 2 s between them."""
    rng = np.random.default_rng(3)
    directions = TABLE_2["specific_force"]
    assert directions is not None
    pieces = []
    for k, direction in enumerate(directions):
        pieces.append(np.tile(direction, (int(seconds * rate), 1)))
        share = np.linspace(0.0, 1.0, int(2 * rate))[:, None]
        moving = (1 - share) * direction + share * directions[(k + 1) % len(directions)]
        pieces.append(moving + 0.2 * rng.standard_normal(moving.shape))
    samples = np.concatenate(pieces)
    samples += 1e-3 * rng.standard_normal(samples.shape)
    t = np.arange(len(samples)) / rate
    rows = np.column_stack([t, samples]) if times else samples
    lines = [",".join(f"{value:.6f}" for value in row) for row in rows]
    header = "t_s,ax,ay,az" if times else "ax,ay,az"
    return write(folder, "\n".join([header, *lines, ""]), "raw.csv"), directions


@pytest.mark.parametrize("times", [True, False])
def test_static_intervals_of_a_recording(tmp_path: Path, times: bool) -> None:
    path, directions = recording(tmp_path, times=times)
    detector = StaticIntervals(rate_hz=None if times else 100.0)
    found = detector.find(path)
    assert len(found) == 18
    starts = np.array([interval.start_s for interval in found])
    np.testing.assert_allclose(starts, 7.0 * np.arange(18), atol=0.9)
    np.testing.assert_allclose([interval.mean for interval in found], directions, atol=3e-4)
    np.testing.assert_allclose([interval.deviation for interval in found], 1e-3, rtol=0.2)
    readings_ = detector.readings(path)
    assert readings_.n == 18
    assert not calibrate(readings_, MODEL, Iterated(), Unit(), noise="columns").outlying


def test_sums_of_a_recording_do_not_depend_on_how_it_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from acalx.files import CsvFile

    path, _ = recording(tmp_path)
    whole = StaticIntervals().find(path)
    blocks = CsvFile.blocks
    sizes: list[int] = []

    def small(self: CsvFile, columns: list[str], size: int = 0) -> object:
        for lines, values in blocks(self, columns, 333):
            sizes.append(len(values))
            yield lines, values

    monkeypatch.setattr(CsvFile, "blocks", small)
    pieces = StaticIntervals().find(path)
    assert max(sizes) == 333
    assert [(a.start_s, a.end_s, a.count) for a in pieces] == [(a.start_s, a.end_s, a.count) for a in whole]
    np.testing.assert_allclose([a.mean for a in pieces], [a.mean for a in whole], rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose([a.deviation for a in pieces], [a.deviation for a in whole], rtol=1e-9)


def test_a_recording_without_static_intervals_is_refused(tmp_path: Path) -> None:
    noise = np.random.default_rng(0).standard_normal((3000, 3)) * np.linspace(1.0, 9.0, 3000)[:, None]
    lines = [f"{k / 100},{x:.4f},{y:.4f},{z:.4f}" for k, (x, y, z) in enumerate(noise)]
    path = write(tmp_path, "t_s,ax,ay,az\n" + "\n".join(lines))
    with pytest.raises(DataError, match=r"no static intervals of 20 s .*change shortest_s=20.0 and factor=3.0"):
        StaticIntervals(shortest_s=20.0).find(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("ax,ay,az\n0,0,1\n", "no column t_s"),
        ("t_s,ax,ay,az\n0,0,0,1\n", "too short a recording"),
        ("t_s,ax,ay,az\n" + "1,0,0,1\n" * 50, "times in t_s that do not go on"),
        ("t_s,ax,ay,az\n" + "".join(f"{k / 100},0,0,1\n" for k in range(50)), "shorter than one window"),
        ("t_s,ax,ay,az\n" + "".join(f"{k / 100},0,0,1\n" for k in range(500)) + "5,0,x,1\n", "row 502, column ay: 'x'"),
        (
            "t_s,ax,ay,az\n" + "".join(f"{k / 100},0,0,1\n" for k in range(500)) + "5,0,1\n",
            "row 502: number of fields 3",
        ),
        (
            "t_s,ax,ay,az\n" + "".join(f"{k / 100},0,0,1\n" for k in range(500)) + "5,0,inf,1\n",
            "row 502, column ay: 'inf'",
        ),
    ],
)
def test_faults_of_a_recording_are_named(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(DataError, match=message):
        StaticIntervals().find(write(tmp_path, text))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "can't be read"),
        ("{}", "not a calibration.json"),
        ("[1", "not a calibration.json"),
        (json.dumps({"correction": {"matrix": [[1]], "offset": [0, 0, 0], "unit": "g"}}), "must be a square matrix"),
    ],
)
def test_a_correction_that_is_none_is_refused(tmp_path: Path, text: str | None, message: str) -> None:
    path = tmp_path / "calibration.json"
    if text is not None:
        path.write_text(text)
    with pytest.raises(DataError, match=message):
        read_correction(path)


# ---------------------------------------------------------------- real sensors


@needs_measured
def test_a_raw_recording_gives_what_its_static_positions_give() -> None:
    with XSENS.open() as file:
        listed = list(csv.DictReader(file))
    found = StaticIntervals().find(XSENS_RAW)
    assert abs(len(found) - len(listed)) <= 1
    for row in listed:  # each has its partner
        assert any(i.start_s < float(row["t_end_s"]) and i.end_s > float(row["t_start_s"]) for i in found)
    static = calibrate(read_readings(XSENS), MODEL, Iterated(), XSENS_COUNTS)
    raw = calibrate(StaticIntervals().readings(XSENS_RAW), MODEL, Iterated(), Unit("counts", None, 32768.0))
    assert static.entries()["residual_deviation_g"] < 0.13e-3
    assert raw.entries()["residual_deviation_g"] < 0.13e-3
    change = np.abs(raw.estimate.parameters - static.estimate.parameters)
    assert (change < 3.0 * static.estimate.standard_errors).all()


@needs_measured
def test_six_measured_positions_are_refused_for_nine_parameters_and_carry_six() -> None:
    six = read_readings(FERRARIS)
    with pytest.raises(SingularError) as caught:
        calibrate(six, MODEL, Iterated(), METERS)
    named = " ".join(caught.value.inestimable)
    assert len(caught.value.inestimable) == 3
    assert all(f"nonorthogonality_{pair}" in named for pair in ("xy", "xz", "zy"))
    calibration = calibrate(six, SIX, Iterated(), METERS, noise="columns")
    np.testing.assert_allclose(np.linalg.norm(calibration.correction.apply(six.means), axis=1), 1.0, atol=1e-9)
    assert (calibration.estimate.standard_errors < 1e-4).all()
