"""Calibrates and validates real sensors and writes the page of results."""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from string import Template

import numpy as np
from drawings import draw_efficiency, draw_sessions

from acalx.commands.explain import as_override
from acalx.criteria import D
from acalx.estimation import (
    Calibration,
    Iterated,
    Readings,
    SingularError,
    StaticIntervals,
    Unit,
    calibrate,
    read_groups,
    read_readings,
)
from acalx.models import ScalarAccel
from acalx.numerics.arrays import Array
from acalx.programs import published_for
from acalx.quantities.parameter import parameter_groups
from acalx.quantities.stimulus import Stimulus
from acalx.reporting.tables import markdown
from acalx.stands import TwoAxis
from acalx.validation.comparison import compare_programs, directions_of
from acalx.validation.splits import Validation, held_out, random_splits, validate_splits
from acalx.validation.subsets import best_positions, efficiency, random_positions

HERE = Path(__file__).resolve().parent
MODEL, ESTIMATOR = ScalarAccel(), Iterated()
MIMU_COUNTS, METERS = Unit("counts", 2048.0), Unit("m/s^2", 9.80665)
SPLITS, SUBSETS, TURNS = 500, 500, 50
TRIADS, SESSIONS = 8, 9


@dataclass(frozen=True)
class Data:
    """The data sets of a directory."""

    directory: Path

    def read(self, name: str) -> Readings:
        """One sensor in one file."""
        return read_readings(self.directory / f"{name}_static.csv")

    @cached_property
    def mimu(self) -> dict[tuple[str, ...], Readings]:
        """The triads of the array by session and number."""
        return read_groups(self.directory / "mimu4444_static.csv", ["experiment", "imu"])

    @cached_property
    def calibrations(self) -> dict[tuple[str, ...], Calibration]:
        """Each of them calibrated on all its positions."""
        return {key: calibrate(readings, MODEL, ESTIMATOR, MIMU_COUNTS) for key, readings in self.mimu.items()}


def split(readings: Readings, unit: Unit, rng: np.random.Generator) -> Validation:
    """Random splits into two thirds for the calibration and one for the test."""
    train, test = random_splits(readings.n, 2 / 3, SPLITS, rng)
    return validate_splits(readings, train, test, MODEL, ESTIMATOR, unit)


def tested(readings: Readings, chosen: np.ndarray) -> Validation:
    """Calibrated on chosen positions (s, n), tested on the others."""
    rest = np.array([np.setdiff1d(np.arange(readings.n), row) for row in chosen])
    return validate_splits(readings, chosen, rest, MODEL, ESTIMATOR, MIMU_COUNTS)


def calibrations(data: Data) -> dict[str, str]:
    """All the sensors: noise, and what is left on positions held out."""
    rng = np.random.default_rng(0)
    rows = [["sensor", "positions", "noise mg", "R^2 held out", "rms held out mg"]]
    splits = [split(readings, MIMU_COUNTS, rng) for readings in data.mimu.values()]
    shares = [float(np.median(one.r_squared)) for one in splits]
    rms = [1e3 * float(np.median(one.rms)) for one in splits]
    noises = [1e3 * calibration.noise for calibration in data.calibrations.values()]
    for title, take in (("best", np.min), ("median", np.median), ("worst", np.max)):
        share = 1.0 - take(1.0 - np.array(shares))
        rows.append([f"mimu4444, {title} of 72", "20", f"{take(noises):.3f}", f"{share:.5f}", f"{take(rms):.3f}"])
    worst = 1.0
    for k in range(5):
        readings = data.read(f"mikoff_mpu9150_{k}")
        found = split(readings, METERS, rng)
        noise = calibrate(readings, MODEL, ESTIMATOR, METERS).noise
        share = float(np.median(found.r_squared))
        worst = min(worst, share)
        cells = [f"{1e3 * noise:.3f}", f"{share:.5f}", f"{1e3 * np.median(found.rms):.3f}"]
        rows.append([f"mpu9150, {k}", str(readings.n), *cells])
    readings, counts = data.read("imu_tk_xsens"), Unit("counts", None)
    found = split(readings, counts, rng)
    noise = calibrate(readings, MODEL, ESTIMATOR, counts).noise
    cells = [f"{1e3 * noise:.3f}", f"{np.median(found.r_squared):.5f}", f"{1e3 * np.median(found.rms):.3f}"]
    rows.append(["xsens", str(readings.n), *cells])
    return {
        "calibrations": markdown(rows),
        "splits": str(SPLITS),
        "mimu_r_squared": f"{np.median(shares):.5f}",
        "mimu_worst": f"{min(shares):.4f}",
        "mikoff_worst": f"{worst:.5f}",
        "within_rms": f"{np.median(rms):.2f}",
    }


def recording(data: Data) -> dict[str, str]:
    """The raw recording against the prepared positions, and the six positions that are too few."""
    static = calibrate(data.read("imu_tk_xsens"), MODEL, ESTIMATOR, Unit("counts", None))
    found = StaticIntervals().readings(data.directory / "imu_tk_xsens_raw.csv")
    raw = calibrate(found, MODEL, ESTIMATOR, Unit("counts", None, 32768.0))
    change = np.abs(raw.estimate.parameters - static.estimate.parameters) / static.estimate.standard_errors
    spread = [1e3 * float(np.std(one.estimate.residual)) for one in (static, raw)]
    six = data.read("imucal_ferraris")
    missing = "nothing is missing"
    try:
        calibrate(six, MODEL, ESTIMATOR, METERS)
    except SingularError as error:
        missing = error.said(as_override).removeprefix(f"{six.name}: ")
    return {
        "raw": (
            f"{raw.readings.n} static intervals were found, {static.readings.n} were prepared;\n"
            f"  no parameter differs by more than {change.max():.2f} standard errors, and the residuals have "
            f"standard deviations of {spread[1]:.3f} and\n  {spread[0]:.3f} mg."
        ),
        "ferraris": missing,
    }


def choice(data: Data, directory: Path) -> dict[str, str]:
    """Whether the choice of positions shows on the positions that were not chosen."""
    rng = np.random.default_rng(1)
    shares: dict[int, list[Array]] = {10: [], 12: []}
    errors: dict[int, list[Array]] = {10: [], 12: []}
    best: dict[int, list[tuple[float, float]]] = {10: [], 12: []}
    for key, readings in data.mimu.items():
        vertical = directions_of(data.calibrations[key])
        for n in (10, 12):
            chosen = random_positions(readings.n, n, SUBSETS, rng)
            shares[n].append(efficiency(vertical[chosen], MODEL))
            errors[n].append(1e3 * tested(readings, chosen).rms)
            optimal = best_positions(Stimulus(specific_force=vertical), n, MODEL, D(), rng)
            rms = float(tested(readings, optimal[None]).rms[0])
            best[n].append((float(efficiency(vertical[optimal], MODEL)), 1e3 * rms))
    rows = [["positions", "D-efficiency, rms mg: D-optimal", "random", "D-optimal is better for"]]
    parts = {}
    for n in (10, 12):
        share, rms_of = np.array(best[n]).T
        random = np.median(errors[n], axis=1)
        better = int((rms_of < random).sum())
        rows.append(
            [
                str(n),
                f"{np.median(share):.3f}, {np.median(rms_of):.3f}",
                f"{np.median(shares[n]):.3f}, {np.median(random):.3f}",
                f"{better} of {len(random)}",
            ]
        )
        parts |= {
            f"designed_{n}": f"{np.median(rms_of):.3f}",
            f"random_{n}": f"{np.median(random):.3f}",
            f"beaten_{n}": str(better),
        }
    share, error = np.concatenate(shares[10]), np.concatenate(errors[10])
    draw_efficiency(share, error, np.array(best[10]), directory)
    fifths, ratio = by_fifths(share, error)
    ranks = [np.argsort(np.argsort(values)) for values in (share, error)]
    return parts | {
        "subsets": str(SUBSETS),
        "chosen": markdown(rows),
        "fifths": fifths,
        "ratio": f"{ratio:.1f}",
        "spearman": f"{np.corrcoef(ranks)[0, 1]:.2f}",
    }


def by_fifths(share: Array, error: Array) -> tuple[str, float]:
    """Median errors of fifths by efficiency, and how many times the first is the last."""
    edges = np.quantile(share, np.linspace(0.0, 1.0, 6))
    rows = [["D-efficiency", "median rms mg", "nine of ten below, mg"]]
    medians = []
    for low, high in pairwise(edges):
        inside = error[(share >= low) & (share <= high)]
        medians.append(float(np.median(inside)))
        rows.append([f"{low:.2f} to {high:.2f}", f"{medians[-1]:.3f}", f"{np.quantile(inside, 0.9):.3f}"])
    return markdown(rows), medians[0] / medians[-1]


def programs(data: Data) -> dict[str, str]:
    """Published programs by the nearest measured positions, medians over the triads."""
    stand, rng = TwoAxis(), np.random.default_rng(2)
    wanted = {}
    for name, program in published_for(stand).items():
        force = stand.stimulus(program.settings_for(stand))["specific_force"]
        assert force is not None  # a two-axis table always gives it
        wanted[name] = force
    found: dict[str, list[tuple[float, ...]]] = {}
    numbers = {}
    for calibration in data.calibrations.values():
        for row in compare_programs(calibration, wanted, D(), ESTIMATOR, rng, random=100, turns=TURNS):
            found.setdefault(row.name, []).append((row.angle_deg, row.efficiency, row.r_squared, 1e3 * row.rms))
            numbers[row.name] = row.n
    rows = [["calibrated on", "positions", "angle deg", "D-efficiency", "R^2", "rms mg"]]
    for name in sorted(found, key=lambda name: numbers[name]):
        angle, share, r_squared, rms = np.median(found[name], axis=0)
        cells = ["-" if np.isnan(angle) else f"{angle:.1f}", f"{share:.2f}", f"{r_squared:.5f}", f"{rms:.3f}"]
        rows.append([name, str(numbers[name]), *cells])
    return {"programs": markdown(rows), "turns": str(TURNS)}


def sessions(data: Data, directory: Path) -> dict[str, str]:
    """How much parameters change from session to session, against their standard errors."""
    shape = (SESSIONS, TRIADS, 9)
    keys = [(str(session + 1), str(triad + 1)) for session in range(SESSIONS) for triad in range(TRIADS)]
    found = [data.calibrations[key] for key in keys]
    parameters = np.array([one.estimate.parameters for one in found]).reshape(shape)
    errors = np.array([one.estimate.standard_errors for one in found]).reshape(shape)
    rows = [["", "predicted", "between sessions", "ratio", "median step"]]
    ratios = {}
    for group, members in parameter_groups(MODEL.parameters).items():
        predicted = float(np.median(errors[..., members]))
        between = float(np.sqrt(parameters[..., members].var(axis=0, ddof=1).mean()))
        ratios[group] = between / predicted
        unit = {"bias": "mg", "scale": "1e-3", "nonorthogonality": "mrad"}[group]
        step = float(np.median(np.abs(np.diff(parameters[..., members], axis=0))))
        cells = [f"{1e3 * predicted:.3f}", f"{1e3 * between:.3f}", f"{ratios[group]:.1f}", f"{1e3 * step:.3f}"]
        rows.append([f"{group}, {unit}", *cells])
    following = [
        held_out(data.mimu[key], data.mimu[(str(int(key[0]) + 1), key[1])], MODEL, ESTIMATOR, MIMU_COUNTS).rms[0]
        for key in keys
        if int(key[0]) < SESSIONS
    ]
    draw_sessions(1e3 * parameters[..., :3], directory)
    return {
        "sessions": markdown(rows),
        "bias_ratio": f"{ratios['bias']:.0f}",
        "coverage": f"{100 * coverage(found):.1f}",
        "next_rms": f"{1e3 * np.median(following):.2f}",
    }


def coverage(found: list[Calibration]) -> float:
    """Share of the positions within the 95 % interval that the others of their session give them."""
    from scipy.special import stdtrit

    inside = [np.abs(one.studentized) < stdtrit(one.estimate.freedom - 1, 0.975) for one in found]
    return float(np.mean(inside))


def write(data: Data, directory: Path) -> None:
    """The page and the figures."""
    directory.mkdir(parents=True, exist_ok=True)
    parts: Mapping[str, str] = (
        calibrations(data) | recording(data) | choice(data, directory) | programs(data) | sessions(data, directory)
    )
    page = Template((HERE / "page.md").read_text(encoding="utf-8")).substitute(parts)
    (directory / "README.md").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    default = Path(os.environ.get("ACALX_DATA", HERE.parents[2] / "shared" / "data")) / "measured"
    parser.add_argument("--data", type=Path, default=default, metavar="DIRECTORY", help="where the measurements are")
    parser.add_argument("--to", type=Path, default=HERE, metavar="DIRECTORY", help="default: beside this script")
    arguments = parser.parse_args()
    if not arguments.data.is_dir():
        parser.error(f"no measurements in {arguments.data}: give --data DIRECTORY; the page says where they come from")
    write(Data(arguments.data), arguments.to)
