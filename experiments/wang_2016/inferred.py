"""Searches all that had to be inferred of Wang et al. (2016) for the choices that give what it prints.

The second-order terms of the gyros, the naming of their axes, the rule by which the angles change and the
sense in which they turn, whether the attitude at the start is a position, the azimuth of the outer axis and
the gyro by which programs are judged: all combinations, in half a minute. Writes `inferred.csv`, a row a
way of turning, and `nearest.csv`, the choices that come nearest.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from choices import (
    AZIMUTHS,
    JUDGES,
    MOST,
    PARALLEL,
    SERIAL,
    WAYS,
    Found,
    Landscape,
    Way,
    accel_rows,
    best_of,
    felt,
    found,
    gyro_rows,
    log_det,
    members,
    search,
    sequences,
)

from acalx.numerics.arrays import Array

HERE = Path(__file__).resolve().parent
EAST = 90  # azimuth of the outer axis where the platform starts east, north, up
ROWS = 4  # of nearest.csv: with the outer axis east, with any other azimuth, and with gyros that are equal
ALIKE = 0.005  # log det of gyros that are equal differ by less
# The noise that the paper prints, in deg/h, and the misalignments that this study assumes, in rad.
NOISE_DEG_H, EARTH_RATE_DEG_H = 0.001, 15.041
MISALIGNMENTS = np.radians(np.array([10.0, 60.0]) / 3600.0)


def order(one: Found) -> tuple[object, ...]:
    """The nearest first: by positions, then by how equal the gyros are, then as the choices are listed."""
    azimuth, judge = AZIMUTHS.index(one.azimuth), JUDGES.index(one.judge)
    return one.distance, round(one.apart, 6), azimuth, judge, WAYS.index(one.way), one.pairs


def parallel_program(one: Found) -> Array:
    """Settings (n, 2) in rad of the joined program: the gyros' positions, then the accelerometers' that they lack."""
    landscape = Landscape(one.way, one.azimuth)
    values = landscape.values(one.pairs, one.judge)
    _, gyros = best_of(values)
    _, accels = best_of(landscape.accels)
    joined = (
        np.concatenate([landscape.settings[i, : one.gyros], landscape.settings[j, : one.accels][~served]])
        for i in gyros
        for j in accels
        for served in [landscape.served(landscape.force[i, : one.gyros], landscape.force[j, : one.accels])]
    )
    return min(joined, key=len)


def misalignment_percent(one: Found) -> float:
    """Error of the gyros' misalignments by the parallel program, over their size, mean of six; inf if not seen."""
    force, rate = felt(parallel_program(one), one.azimuth)
    low, high = MISALIGNMENTS
    size = EARTH_RATE_DEG_H * np.sqrt((low * low + low * high + high * high) / 3.0)  # of a uniform magnitude
    errors = []
    for axis, pair in enumerate(one.pairs):
        rows = gyro_rows(force, rate, axis)[:, members(pair)]
        if np.linalg.matrix_rank(rows, tol=1e-6) < rows.shape[1]:
            return float("inf")
        errors.append(NOISE_DEG_H * np.sqrt(np.diag(np.linalg.inv(rows.T @ rows))[-2:]))
    return float(100.0 * np.mean(errors) / size)


def extended(one: Found) -> tuple[int, int]:
    """Positions of two other serial programs: accelerometers first, and gyros first with at least one position more.

    What is there stays, and each of the 144 sequences is put behind it; the second kind's determinant per
    measurement decides.
    """
    landscape = Landscape(one.way, one.azimuth)
    _, gyros = best_of(landscape.values(one.pairs, one.judge))
    _, accels = best_of(landscape.accels)
    begun = felt(landscape.settings[accels[0], : one.accels], one.azimuth)
    behind = felt(sequences(one.way._replace(home=False)), one.azimuth)
    after_accels = [
        _extension(
            gyro_rows(*begun, axis)[:, members(one.pairs[axis])],
            gyro_rows(*behind, axis)[..., members(one.pairs[axis])],
        )
        for axis in (range(3) if one.judge == "all" else ["XYZ".index(one.judge)])
    ]
    after_gyros = _extension(accel_rows(landscape.force[gyros[0], : one.gyros]), accel_rows(behind[0]))
    return one.accels + 1 + best_of(sum(after_accels))[0], one.gyros + 1 + best_of(after_gyros)[0]


def _extension(held: Array, behind: Array) -> Array:
    """log det (s, k) per measurement of rows that stay, (l, p), with the first 1 to k of sequences (s, 16, p)."""
    more = MOST - len(held)
    sums = np.cumsum(behind[:, :more, :, None] * behind[:, :more, None, :], axis=1)
    return log_det((held.T @ held + sums) / (len(held) + np.arange(1, more + 1))[:, None, None])


def turned(way: Way) -> dict[str, str]:
    """A way of turning, as columns of a table."""
    sense, start = "against" if way.against else "along", "yes" if way.home else "no"
    return {"rule": way.rule, "inner angle": sense, "start counted": start}


def row_of(one: Found) -> dict[str, str]:
    """Choices and what they give, as columns of a table."""
    names = (" ".join(pair) for pair in one.pairs)
    pairs = {f"{axis} gyro": name for axis, name in zip("XYZ", names, strict=True)}
    after_accels, after_gyros = extended(one)
    figures = {
        "gyros": str(one.gyros),
        "accels": str(one.accels),
        "parallel": str(one.parallel),
        "serial": str(one.serial),
        "serial, accels first": str(after_accels),
        "serial, one more": str(after_gyros),
        "log det apart": f"{one.apart:.2f}",
        "misalignments %": f"{misalignment_percent(one):.1f}",
    }
    return turned(one.way) | {"azimuth": str(one.azimuth), **pairs, "judged by": one.judge} | figures


def again(row: dict[str, str]) -> Found | None:
    """What the traversal gives by the choices of a row of nearest.csv, computed anew."""
    way = Way(row["rule"], row["inner angle"] == "against", row["start counted"] == "yes")
    first, second, third = (tuple(row[f"{axis} gyro"].split()) for axis in "XYZ")
    return found(Landscape(way, int(row["azimuth"])), (first, second, third), row["judged by"])


def by_way(every: Sequence[Found]) -> list[dict[str, str]]:
    """For each way of turning: how many choices give each printed figure, and the nearest."""
    rows = []
    for way in dict.fromkeys(one.way for one in every):
        some = [one for one in every if one.way == way]
        counts = {
            "choices": len(some),
            f"parallel {PARALLEL}": sum(one.parallel == PARALLEL for one in some),
            f"serial {SERIAL}": sum(one.serial == SERIAL for one in some),
            "both": sum(one.distance == 0 for one in some),
            "gyros equal": sum(one.apart < ALIKE for one in some),
        }
        counts["fewest, added up"] = min(one.gyros + one.accels for one in some)
        least = min(some, key=order)
        nearest = {"nearest: parallel": str(least.parallel), "serial": str(least.serial)}
        rows.append(turned(way) | {name: str(count) for name, count in counts.items()} | nearest)
    return rows


def nearest(every: Iterable[Found]) -> list[dict[str, str]]:
    """The nearest choices with the outer axis east, those with another azimuth, and those by which gyros are equal."""
    ordered = sorted(every, key=order)
    east = [one for one in ordered if one.azimuth == EAST][:ROWS]
    others = [one for one in ordered if one.azimuth != EAST][:ROWS]
    alike = {one.way: one for one in reversed(ordered) if one.apart < ALIKE}  # the nearest of each way
    alike_ways = sorted(alike.values(), key=order)[:ROWS]
    return [row_of(one) for one in (*east, *others, *alike_ways)]


def write(file: Path, rows: Sequence[dict[str, Any]]) -> None:
    """Rows with the same columns, as CSV."""
    with file.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def read(name: str) -> list[dict[str, str]]:
    """The rows of a kept table."""
    with (HERE / name).open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--to", type=Path, default=HERE, metavar="DIRECTORY", help="default: beside this script")
    directory = parser.parse_args().to
    directory.mkdir(parents=True, exist_ok=True)
    everything = list(search())
    write(directory / "inferred.csv", by_way(everything))
    write(directory / "nearest.csv", nearest(everything))
