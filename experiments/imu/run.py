"""Designs, simulates and compares programs for an inertial measurement unit, and writes the page."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from string import Template

import numpy as np
from drawings import draw_drift, draw_standard_errors
from found import array_parts, gyro_parts, visited_parts
from programs import GROUPS, MODEL, STAND, Accuracy, Programs, needed_without_arms, plain, save, targeted
from recipes import RECIPES
from sessions import Sessions
from simulations import simulated

from acalx.quantities.parameter import parameter_groups
from acalx.reporting.tables import markdown

HERE = Path(__file__).resolve().parent
# In the units of the groups, for every parameter of a group.
WANTED = {
    "accel_bias": 50.0,
    "accel_scale": 50.0,
    "accel_misalignment": 50.0,
    "accel_quadratic": 100.0,
    "accel_arm": 1000.0,
    "gyro_bias": 10.0,
    "gyro_scale": 50.0,
    "gyro_misalignment": 50.0,
    "gyro_g_sensitivity": 20.0,
}


def headed(group: str) -> str:
    """A group with its unit."""
    return f"{GROUPS[group].title}, {GROUPS[group].unit}"


def titled(name: str) -> str:
    """A program as tables call it."""
    return RECIPES[name].title if name in RECIPES else name.replace("_", " ")


def errors(programs: Programs) -> dict[str, str]:
    """Standard errors by group, each recipe beside the joint program of as many positions."""
    head = [""]
    for recipe, joint in programs.pairs:
        head += [f"{titled(recipe.name)}, {recipe.n}", f"joint, {joint.n}"]
    rows = [head]
    for group in GROUPS:
        rows.append([headed(group), *(one.cell(group) for pair in programs.pairs for one in pair)])
    last = programs.pairs[-1]
    ratio = last[0].of("gyro_scale")[0] / last[1].of("gyro_scale")[0]
    return {"errors": markdown(rows), "rates_ratio": f"{ratio:.1f}", "rates_squared": f"{ratio**2:.1f}"}


def sizes(programs: Programs) -> dict[str, str]:
    """Standard errors of joint programs by their number of positions."""
    rows = [["", *map(str, programs.by_size)]]
    rows += [[headed(group), *(one.cell(group) for one in programs.by_size.values())] for group in GROUPS]
    return {"sizes": markdown(rows)}


def weak(programs: Programs) -> dict[str, str]:
    """What each recipe can't see by acalx, and what it leaves as it was known before."""
    rows = [["recipe", "can't be seen at all", "left as it was known before"]]
    parts = {}
    for name, one in programs.recipes.items():
        information = MODEL.information(STAND.stimulus(one.settings))
        unseen = "; ".join(information.inestimable(0.05)) or "-"
        left = []
        for group, members in parameter_groups(MODEL.parameters).items():
            hidden = [MODEL.parameters[k].name for k in members if not one.shown[k]]
            if len(hidden) == len(members):
                left.append(f"all {len(members)} of {group}")
            else:
                left += hidden
        rows.append([titled(name), unseen, "; ".join(left)])
        if not information.singular:
            parts[f"formal_{one.n}"] = f"{information.theta('accel_arm'):.1f}"
    return {"weak": markdown(rows), **parts}


def kinds(programs: Programs) -> dict[str, str]:
    """What the joint programs are made of."""
    head = ["positions", "at rest", "outer axis turns", "inner axis turns", "both turn", "D-efficiency", "made plain"]
    rows = [head]
    for n, one in programs.by_size.items():
        efficiencies = (programs.efficiency(settings) for settings in (one.settings, plain(one.settings)))
        counts = (str(count) for count in programs.kinds(one.settings))
        rows.append([str(n), *counts, *(f"{100 * share:.1f} %" for share in efficiencies)])
    table = [["outer deg", "inner deg", "outer deg/s", "inner deg/s"]]
    for row in STAND.axes.written(plain(programs.joint[24].settings)):
        table.append([f"{value:.0f}" for value in np.round(row) + 0.0])
    rest, *_ = programs.kinds(programs.joint[24].settings)
    both = programs.kinds(programs.joint[24].settings)[-1]
    return {
        "kinds": markdown(rows),
        "plain": markdown(table),
        "rest_24": str(rest),
        "both_24": str(both),
        "turning_24": str(24 - rest),
        "plain_24": next(row[-1] for row in rows if row[0] == "24"),
    }


def needed(programs: Programs) -> dict[str, str]:
    """Positions for given standard errors."""
    columns: list[Accuracy] = [*programs.recipes.values(), programs.joint[24]]
    head = ["", "wanted", *(titled(one.name) for one in columns), "joint, no arms estimated"]
    rows, most = [head], [0] * len(columns)
    bare = needed_without_arms(WANTED)
    for group, wanted in WANTED.items():
        counts = [one.needed(group, wanted) for one in columns]
        most = [max(a, b) if b is not None else a for a, b in zip(most, counts, strict=True)]
        cells = ["never" if count is None else str(count) for count in counts]
        rows.append([headed(group), f"{wanted:g}", *cells, str(bare[group]) if group in bare else "-"])
    rows.append(["all that it shows", "", *map(str, most), str(max(bare.values()))])
    return {
        "needed": markdown(rows),
        "needed_six": str(most[0]),
        "needed_rates": str(most[2]),
        "needed_joint": str(most[3]),
        "needed_bare": str(max(bare.values())),
        "targeted": str(targeted(WANTED)),
    }


def without_arms(programs: Programs) -> dict[str, str]:
    """D-efficiency where the lever arms are not estimated."""
    rows = [["program", "positions", "D-efficiency"]]
    for name, n, share in programs.without_arms:
        rows.append([titled(name), str(n), f"{100 * share:.1f} %" if share else "singular"])
    return {"without_arms": markdown(rows)}


def measurements(directory: Path | None, to: Path) -> str:
    """The part of the page on real sensors; a sentence where there are no data."""
    if directory is None or not directory.is_dir():
        place = "here" if directory is None else f"in {directory}"
        return f"There are no measurements {place}: give --data DIRECTORY, and this part is written."
    sessions = Sessions(directory)
    first = [sessions.mimu[session, 1] for session in range(1, 10)]
    rates = [one.gyro.means[:, 0] / 16.4 for one in first]
    draw_drift([one.times for one in first], rates, first[0].vertical[:, 1], to)
    parts = visited_parts(sessions) | gyro_parts(sessions) | array_parts(sessions)
    return Template((HERE / "measured.md").read_text(encoding="utf-8")).substitute(parts).rstrip()


def write(data: Path | None, directory: Path) -> None:
    """The page, the figures and the joint programs."""
    directory.mkdir(parents=True, exist_ok=True)
    programs = Programs()
    save(list(programs.by_size.values()), directory / "programs")
    save([Accuracy("joint_24_plain", plain(programs.joint[24].settings))], directory / "programs")
    draw_standard_errors(programs.pairs, directory)
    alone, wrong, figures = simulated(programs.all)
    parts = {
        **errors(programs),
        **sizes(programs),
        **weak(programs),
        **kinds(programs),
        **needed(programs),
        **without_arms(programs),
        **figures,
        "simulated": markdown([[titled(row[0]), *row[1:]] for row in alone]),
        "wrong": markdown([[titled(row[0]), *row[1:]] for row in wrong]),
        "measured": measurements(data, directory),
    }
    page = Template((HERE / "page.md").read_text(encoding="utf-8")).substitute(parts)
    (directory / "README.md").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    default = Path(os.environ["ACALX_DATA"]) / "measured" if "ACALX_DATA" in os.environ else None
    parser.add_argument("--data", type=Path, default=default, metavar="DIRECTORY", help="where the measurements are")
    parser.add_argument("--to", type=Path, default=HERE, metavar="DIRECTORY", help="default: beside this script")
    arguments = parser.parse_args()
    write(arguments.data, arguments.to)
