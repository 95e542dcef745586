"""Parallel, serial, joint and 16-position programs of an inertial platform, after Wang et al. (2016)."""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from string import Template

import numpy as np
from choices import MOST
from drawings import draw_relative_errors
from landscapes import figures_2_and_3, inferred

from acalx.bounds import bound
from acalx.criteria import Criterion, D, Target
from acalx.models import Platform
from acalx.numerics.arrays import Array
from acalx.optimizers import Gradient, Optimizer, Traversal
from acalx.problem import Problem
from acalx.programs import find_program
from acalx.programs.sequences import regular_sequences
from acalx.quantities.information import Information
from acalx.recording import RunDirectory
from acalx.reporting.tables import markdown, program_table
from acalx.schemes import Composed, Joint, Parallel, Scheme, Serial
from acalx.simulation import Campaign, ErrorSources, default_estimator, run_campaign
from acalx.stands import PlatformGimbals

HERE = Path(__file__).resolve().parent
STAND = PlatformGimbals()
# Determinants are in unit inputs; standard errors and simulations with the noise of the paper.
UNIT, SENSOR = Platform(), Platform(gyro_noise_deg_h=0.001, accel_noise_g=1e-6 / 9.80665)
GYROS, ACCELS = Platform(sensors=["gyros"]), Platform(sensors=["accels"])
GROUPS = ("gyro_bias", "gyro_first_order", "gyro_second_order", "gyro_misalignment")
SEED, RUNS = 0, 4000
INSTALLATION = (10.0, 1.0)  # of the gimbal axes, arc seconds: mean and standard deviation; known
ARC_SECOND = np.radians(1.0 / 3600.0)
EARTH_RATE_DEG_H = 15.041
# Magnitudes of the true coefficients, in their units; each has a random sign.
MAGNITUDES = {
    "gyro_bias": (0.01, 0.1),
    "gyro_first_order": (0.05, 0.5),
    "gyro_second_order": (0.005, 0.05),
    "gyro_misalignment": (10 * ARC_SECOND * EARTH_RATE_DEG_H, 60 * ARC_SECOND * EARTH_RATE_DEG_H),
    "accel_bias": (1e-5, 1e-4),
    "accel_scale": (1e-5, 1e-4),
    "accel_misalignment": (10 * ARC_SECOND, 60 * ARC_SECOND),
}
# How groups are written in tables: a factor and a unit.
WRITTEN = {
    "gyro_bias": (1e3, "1e-3 deg/h"),
    "gyro_first_order": (1e3, "1e-3 deg/h/g"),
    "gyro_second_order": (1e3, "1e-3 deg/h/g^2"),
    "gyro_misalignment": (1.0 / EARTH_RATE_DEG_H / ARC_SECOND, "arc seconds"),
    "accel_bias": (1e6, "1e-6 g"),
    "accel_scale": (1e6, "1e-6"),
    "accel_misalignment": (1.0 / ARC_SECOND, "arc seconds"),
}


def design(scheme: Scheme, optimizer: Optimizer, n: int, criterion: Criterion | None = None) -> Composed:
    """A program of at most n positions, always from the same seed."""
    return scheme.solve(Problem(STAND, UNIT, criterion or D(), n), optimizer, np.random.default_rng(SEED))


def angles(name: str) -> Array:
    """Settings (n, 2) of a program by name."""
    return find_program(name).settings_for(STAND)


@cache
def programs() -> dict[str, Array]:
    """All that is compared, settings (n, 2) by name."""
    sequences, gradient = Traversal(), Gradient(starts=24)
    each = {"gyros": MOST, "accels": MOST}
    return {
        "parallel, sequences of up to 16": design(Parallel(each), sequences, 2 * MOST).result.best.settings,
        "parallel, 13 in all": design(Parallel(), sequences, 13).result.best.settings,
        "serial, sequences of up to 16": design(Serial(positions=each), sequences, 2 * MOST).result.best.settings,
        "serial, 13 in all": design(Serial(), sequences, 13).result.best.settings,
        "joint, a sequence of up to 16": design(Joint(), sequences, MOST).result.best.settings,
        "joint, free, 13": design(Joint(), gradient, 13).result.best.settings,
        "joint, free, 16": design(Joint(), gradient, 16).result.best.settings,
        "16 positions, in turn": angles("platform_turn_16"),
        "16 positions, 4 by 4": angles("platform_raster_16"),
        "16 positions, facts": angles("platform_reference_16"),
    }


def log_dets(settings: Array) -> tuple[float, float]:
    """log det of the information of all gyros and of all accelerometers, in unit inputs."""
    stimulus = STAND.stimulus(settings)
    return float(GYROS.information(stimulus).log_det), float(ACCELS.information(stimulus).log_det)


def relative_errors(settings: Array) -> Array:
    """Root mean square error of each of the 36 coefficients over that of the true ones, (36,), simulated."""
    sources = ErrorSources(MAGNITUDES, noise=1.0, setting_rad=0.0, gravity=0.0, installation_arcsec=INSTALLATION)
    campaign = Campaign(SENSOR, STAND, settings, sources, SEED)
    return run_campaign(campaign, default_estimator(SENSOR), RUNS).relative_errors


def comparison() -> dict[str, str]:
    """Positions and determinants."""
    rows = [["program", "N", "log det gyros", "accels", "all 36", "all 36, per measurement", "efficiency"]]
    least = bound(Problem(STAND, UNIT, D(), 16)).loss  # log det K; per measurement the same for every N
    most, proved = -least - 36 * np.log(16), []
    for name, settings in programs().items():
        gyros, accels = log_dets(settings)
        n = len(settings)
        each = gyros + accels - 36 * np.log(n)
        cells = [f"{gyros:.2f}", f"{accels:.2f}", f"{gyros + accels:.2f}", f"{each:.2f}"]
        efficiency = f"{np.exp((each - most) / 36):.4f}"
        rows.append([name, str(n), *cells, efficiency])
        if name.startswith("joint, free"):
            proved.append(efficiency)
    return {"comparison": markdown(rows), "joint_efficiency": " and ".join(proved)}


def standard_errors() -> str:
    """Largest one of each group, with the noise of the paper."""
    rows = [["program", "N", *(f"{group.replace('_', ' ')}, {unit}" for group, (_, unit) in WRITTEN.items())]]
    for name, settings in programs().items():
        information = SENSOR.information(STAND.stimulus(settings))
        cells = [f"{float(information.theta(group)) * factor:.3g}" for group, (factor, _) in WRITTEN.items()]
        rows.append([name, str(len(settings)), *cells])
    return markdown(rows)


def simulated(errors: Mapping[str, Array]) -> str:
    """Mean and largest relative error of each group, in percent."""
    groups = SENSOR.information(STAND.stimulus(angles("platform_turn_16"))).groups
    rows = [["program", "N", *(group.replace("_", " ") for group in groups)]]
    for name, each in errors.items():
        percent = 100.0 * each
        cells = [f"{percent[members].mean():.2f} ({percent[members].max():.2f})" for members in groups.values()]
        rows.append([name, str(len(programs()[name])), *cells])
    return markdown(rows)


def regular(rule: str) -> Information:
    """Information of the gyros of all 16-position sequences of full rank, in unit inputs."""
    sequences = np.array(list(itertools.product(range(0, 180, 5), (45, 90), (45, 90))), dtype=float)
    starts = np.repeat(sequences[:, :1], 2, axis=1)
    settings = np.radians(regular_sequences(rule, starts, sequences[:, 1:], 16))
    information = GYROS.information(STAND.stimulus(settings))
    return information.select(~information.singular)


def thetas_of(information: Information) -> Array:
    """Largest standard errors (..., 4) of each gyro group."""
    return np.stack([information.theta(group) for group in GROUPS], axis=-1)


def by_group(wanted: Array, n: int) -> tuple[Array, float, float]:
    """Program for the gyro groups: settings, the largest share of what is wanted, its proved bound."""
    target = Target(dict(zip(GROUPS, wanted.tolist(), strict=True)))
    best = design(Joint(), Gradient(starts=8), n, target).result.best
    least = bound(Problem(STAND, GYROS, target, n)).loss  # the accelerometers have no part in it
    shares = thetas_of(UNIT.information(STAND.stimulus(best.settings))) / wanted
    return best.settings, float(shares.max()), float(np.exp(0.5 * least))


def groups_of_gyros() -> dict[str, str]:
    """Whether a program is as good as every regular sequence in every gyro group."""
    lowest = {rule: thetas_of(regular(rule)) for rule in ("turn", "raster")}
    counts = {rule: str(len(thetas)) for rule, thetas in lowest.items()}
    both = np.concatenate(list(lowest.values()))
    least = {"by turns": lowest["turn"].min(0), "by lines": lowest["raster"].min(0), "both": both.min(0)}
    rows = [["rule", *(group.removeprefix("gyro_").replace("_", " ") for group in GROUPS), "largest share", "bound"]]
    chosen = {}
    for rule, wanted in least.items():
        settings, share, bound = by_group(wanted, 16)
        chosen[rule] = settings
        cells = [f"{low:.4f}" for low in wanted]
        rows.append([rule, *cells, f"{share:.4f}", f"{bound:.4f}"])
    sixteen = thetas_of(UNIT.information(STAND.stimulus(chosen["by turns"])))
    _, share, bound = by_group(sixteen, 13)
    thetas = {n: thetas_of(UNIT.information(STAND.stimulus(programs()[f"joint, free, {n}"]))) for n in (13, 16)}
    usual = np.median(regular("turn").standard_deviations[:, misalignments()].mean(axis=1))
    against = {}
    for name, settings in programs().items():
        deviations = GYROS.information(STAND.stimulus(settings)).standard_deviations[misalignments()]
        against[name] = f"{deviations.mean() / usual:.2f}"
    return {
        "usual_13": against["joint, free, 13"],
        "usual_parallel": against["parallel, 13 in all"],
        "usual_long": against["parallel, sequences of up to 16"],
        "regular_turn": counts["turn"],
        "regular_raster": counts["raster"],
        "by_group": markdown(rows),
        "d_shares": ", ".join(f"{value:.4f}" for value in thetas[16] / least["by turns"]),
        "thirteen": f"{100 * (share - 1):.1f} %",
        "thirteen_bound": f"{100 * (bound - 1):.1f} %",
        "d_thirteen": ", ".join(f"{100 * value:.1f} %" for value in thetas[13] / thetas[16] - 1),
        "target": ", ".join(f"{group}: {value:.6f}" for group, value in zip(GROUPS, least["by turns"], strict=True)),
    }


def positions(directory: Path) -> str:
    """The positions of the programs that were designed, with a file for each."""
    record, texts = RunDirectory(directory / "programs", []), []
    for name, settings in programs().items():
        if not name.startswith("16"):
            file = name.replace(",", "").replace(" ", "_")
            record.write_program(STAND, settings, name=f"{file}.csv")
            texts.append(f"{name} (`programs/{file}.csv`):\n\n```text\n{program_table(STAND, settings)}\n```")
    return "\n\n".join(texts)


def reproduce(directory: Path) -> None:
    """Write the page, the figures and the programs."""
    directory.mkdir(parents=True, exist_ok=True)
    errors = {name: relative_errors(settings) for name, settings in programs().items()}
    shown = ("parallel, 13 in all", "serial, 13 in all", "joint, free, 13", "16 positions, in turn")
    draw_relative_errors({name: errors[name] for name in shown}, SENSOR.parameters, directory)
    of = {name: 100 * np.mean([each[k] for k in misalignments()]) for name, each in errors.items()}
    weakest = {name: SENSOR.parameters[int(each.argmax())].group for name, each in errors.items()}
    parts = comparison() | figures_2_and_3(directory) | inferred() | groups_of_gyros()
    parts |= {
        "standard_errors": standard_errors(),
        "simulated": simulated(errors),
        "runs": str(RUNS),
        "weakest": str(sum(group == "gyro_misalignment" for group in weakest.values())),
        "of": str(len(weakest)),
        "joint_13": f"{of['joint, free, 13']:.2f}",
        "joint_16": f"{of['joint, free, 16']:.2f}",
        "parallel": f"{of['parallel, 13 in all']:.2f}",
        "turn_16": f"{of['16 positions, in turn']:.2f}",
        "long": f"{of['parallel, sequences of up to 16']:.2f}",
        "readings": f"{(of['joint, free, 13'] / 5) ** 2:.0f}",
        "raster_16": f"{of['16 positions, 4 by 4']:.2f}",
        "ratio_13": f"{of['joint, free, 13'] / of['16 positions, in turn']:.2f}",
        "ratio_16": f"{of['joint, free, 16'] / of['16 positions, in turn']:.2f}",
        "positions": positions(directory),
    }
    page = Template((HERE / "page.md").read_text(encoding="utf-8")).substitute(parts)
    (directory / "README.md").write_text(page, encoding="utf-8")


def misalignments() -> list[int]:
    """Numbers of the misalignments of the gyros."""
    return [k for k, parameter in enumerate(SENSOR.parameters) if parameter.group == "gyro_misalignment"]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--to", type=Path, default=HERE, metavar="DIRECTORY", help="default: beside this script")
    reproduce(parser.parse_args().to)
