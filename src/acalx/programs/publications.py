"""The positions of published and classical calibration programs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from acalx.numerics.arrays import Array
from acalx.programs.sequences import regular_sequences

__all__ = ["PUBLISHED", "Publication"]

_PAPER = "Egorov, Kiryachenko, Popov, Giroskopiya i Navigatsiya 29(2), 2021, 47-58"
_DERIVED = "coordinates derived from the printed figures"
_CONSTRUCTED = "coordinates by construction, not printed there"
_WANG = "Wang, Wang, Shen, Qin, J. Chin. Inert. Technol. 24(5), 2016, 583-588"
_PRACTICE = "common laboratory practice"
_BLIND = "a scalar calibration can't show non-orthogonality"


@final
@dataclass(frozen=True)
class Publication:
    """Where a program comes from and what its positions are.

    Parameters
    ----------
    title : str
        One line for a table.
    source : str
        Who printed it, or how its coordinates were found.
    directions : function without arguments to array (n, 3), optional
        The vertical in sensor axes, any length. Either this or the angles.
    angles_deg : mapping of str to n numbers, degrees, optional
        Angles of each setting of a stand, as printed.
    """

    title: str
    source: str
    directions: Callable[[], Array] | None = None
    angles_deg: Mapping[str, tuple[float, ...]] | None = None


def _signed(x: float, y: float, z: float) -> Array:
    """A point and its images under every change of sign."""
    points = [(i, j, k) for i in {x, -x} for j in {y, -y} for k in {z, -z}]
    return np.array(sorted(points, reverse=True)) + 0.0  # no negative zeros


def _cycled(points: Array) -> Array:
    """Points and their images under the rotations x to y to z to x."""
    return np.concatenate([np.roll(points, k, axis=1) for k in range(3)])


def _faces() -> Array:
    return np.concatenate([np.eye(3), -np.eye(3)]) + 0.0


def _edges() -> Array:
    return _cycled(_signed(1, 1, 0))


def _rotations(steps: int) -> Array:
    """Equal steps of one turn about x, then about y, then about z."""
    turn = 2.0 * np.pi * np.arange(steps) / steps
    about_x = np.stack([np.zeros(steps), np.sin(turn), np.cos(turn)], axis=-1)
    # Exact zeros: a remainder of 1e-16 would pass for a non-orthogonality that shows.
    return _cycled(np.round(about_x, 15) + 0.0)


def _axes_and_vertices() -> Array:
    return np.concatenate([_faces(), [(1, 1, 1), (1, -1, -1), (-1, 1, -1)]])


def _axes_and_edges() -> Array:
    return np.concatenate([_faces(), [(1, 1, 0), (1, 0, 1), (0, 1, 1)]])


def _faces_and_edges() -> Array:
    return np.concatenate([_faces(), _edges() / np.sqrt(2.0)])


def _icosahedron() -> Array:
    return _cycled(_signed(0, 1, (1 + 5**0.5) / 2))


def _dodecahedron() -> Array:
    golden = (1 + 5**0.5) / 2
    return np.concatenate([_signed(1, 1, 1), _cycled(_signed(0, 1 / golden, golden))])


def _regular(rule: str, start: float, *steps: float) -> Mapping[str, tuple[float, ...]]:
    """Sixteen positions of a platform, with both angles from the same start."""
    angles = regular_sequences(rule, np.full(2, start), np.array(steps), 16) % 360.0
    return {"gamma": tuple(angles[:, 0].tolist()), "alpha": tuple(angles[:, 1].tolist())}


def _degrees(printed: str) -> tuple[float, ...]:
    return tuple(float(angle) for angle in printed.split())


PUBLISHED: Mapping[str, Publication] = {
    "egorov_2021_table_1": Publication(
        "9 positions optimized for D",
        f"{_PAPER}, Table 1",
        angles_deg={
            "alpha1": _degrees("22.2 59.4 144.6 151.3 253.1 323.4 333.0 347.5 355.7"),
            "alpha2": _degrees("351.7 78.5 9.5 93.7 292.8 312.3 221.8 53.1 128.4"),
        },
    ),
    "egorov_2021_table_2": Publication(
        "18 positions optimized for D",
        f"{_PAPER}, Table 2",
        angles_deg={
            "alpha1": _degrees(
                "7.1 11.7 23.0 30.5 34.1 39.2 80.6 122.6 159.9 206.2 267.1 309.6 318.7 322.1 332.0 341.3 341.8 360.0"
            ),
            "alpha2": _degrees(
                "145.4 266.1 75.1 351.1 236.6 330.4 202.9 282.8 5.2 195.7 317.6 90.8 230.0 328.8 197.3 118.8 293.8 46.7"
            ),
        },
    ),
    "axes_and_vertices_9": Publication(
        "6 faces and 3 vertices of a cube",
        f"reference [7] of {_PAPER}; {_DERIVED}",
        _axes_and_vertices,
    ),
    "axes_and_edges_9": Publication(
        "6 faces and 3 edge midpoints of a cube",
        f"references [4,5] of {_PAPER}; {_DERIVED}",
        _axes_and_edges,
    ),
    "faces_and_edges_18": Publication(
        "6 faces and 12 edge midpoints of a cube",
        f"references [4,16] of {_PAPER}; {_DERIVED}",
        _faces_and_edges,
    ),
    "edges_12": Publication(
        "12 edge midpoints of a cube",
        f"the edges of references [4,16] of {_PAPER}, without the faces",
        _edges,
    ),
    "rotations_12": Publication(
        f"4 steps of 90 degrees about each of 3 axes; {_BLIND}",
        f"the rotations of Figure 2 of {_PAPER}, in the largest steps; {_CONSTRUCTED}",
        lambda: _rotations(4),
    ),
    "rotations_18": Publication(
        "6 steps of 60 degrees about each of 3 axes",
        f"reference [6] of {_PAPER}; {_DERIVED}",
        lambda: _rotations(6),
    ),
    "rotations_24": Publication(
        "8 steps of 45 degrees about each of 3 axes",
        f"Figure 2 of {_PAPER}; {_CONSTRUCTED}",
        lambda: _rotations(8),
    ),
    "rotations_36": Publication(
        "12 steps of 30 degrees about each of 3 axes",
        f"Figure 2 of {_PAPER}; {_CONSTRUCTED}",
        lambda: _rotations(12),
    ),
    "icosahedron_12": Publication(
        "12 vertices of an icosahedron; no 12 positions have a smaller D",
        f"Figure 2 of {_PAPER}; {_CONSTRUCTED}",
        _icosahedron,
    ),
    "dodecahedron_20": Publication(
        "20 vertices of a dodecahedron; no 20 positions have a smaller D",
        f"Figure 2 of {_PAPER}; {_CONSTRUCTED}",
        _dodecahedron,
    ),
    "classical_6": Publication(f"6 faces of a cube; {_BLIND}", _PRACTICE, _faces),
    "classical_12": Publication(
        f"4 orientations, 90 degrees apart, about each of 3 horizontal axes; {_BLIND}",
        f"{_PRACTICE}; the same as rotations_12",
        lambda: _rotations(4),
    ),
    "classical_24": Publication(
        "8 orientations, 45 degrees apart, about each of 3 horizontal axes",
        f"{_PRACTICE}; the same as rotations_24",
        lambda: _rotations(8),
    ),
    "classical_36": Publication(
        "12 orientations, 30 degrees apart, about each of 3 horizontal axes",
        f"{_PRACTICE}; the same as rotations_36",
        lambda: _rotations(12),
    ),
    "platform_reference_16": Publication(
        "16 positions of a platform on a grid of 45 degrees",
        "found by exchange for D with second-order terms IS and SS, not published",
        angles_deg={
            "gamma": _degrees("0 45 45 45 90 90 135 135 135 180 225 270 270 270 270 315"),
            "alpha": _degrees("45 90 225 315 0 90 90 180 270 315 180 0 90 225 315 180"),
        },
    ),
    "platform_grid_16": Publication(
        "4 outer by 4 inner positions of a platform, 90 degrees apart; not enough for most second-order terms",
        _PRACTICE,
        angles_deg=_regular("raster", 0.0, 90.0, 90.0),
    ),
    "platform_turn_16": Publication(
        "16 positions of a platform, the axes in turn by 90 and 45 degrees from 110 degrees",
        f"the best for D by turns of the starts and steps of {_WANG}; found by optimizer=traversal, not printed there",
        angles_deg=_regular("turn", 110.0, 90.0, 45.0),
    ),
    "platform_raster_16": Publication(
        "4 outer by 4 inner positions of a platform, 90 degrees apart, from 20 degrees",
        f"the best for D by lines of the starts and steps of {_WANG}; found by optimizer=traversal, not printed there",
        angles_deg=_regular("raster", 20.0, 90.0, 90.0),
    ),
}
