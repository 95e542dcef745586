"""Figure 1: how the two angles of the table put the vertical into the axes of the sensor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from acalx.numerics.arrays import Array
from acalx.reporting.figures import INK, PALE, SERIES, new_figure, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ALPHA_1, ALPHA_2 = np.radians(27.0), np.radians(36.0)  # of the attitude that is drawn
OUTER, INNER, VERTICAL = SERIES[1], SERIES[2], SERIES[0]
LIGHT = np.array([0.35, 0.55, 0.76])
BLUE, GREEN, STONE = (0.55, 0.71, 0.82), (0.70, 0.81, 0.66), (0.85, 0.86, 0.88)
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class View:
    """Where a scene is looked at from: azimuth and height of the eye, in degrees."""

    azimuth: float
    height: float

    @property
    def toward(self) -> Array:
        """Unit vector (3,) to the eye."""
        azimuth, height = np.radians([self.azimuth, self.height])
        return np.array([np.cos(height) * np.cos(azimuth), np.cos(height) * np.sin(azimuth), np.sin(height)])

    def seen(self, points: Array) -> Array:
        """Where points (..., 3) are on the paper, (..., 2)."""
        azimuth = np.radians(self.azimuth)
        right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        return np.asarray(points) @ np.stack([right, np.cross(self.toward, right)], axis=1)


def sensor_axes(alpha_1: float, alpha_2: float) -> Array:
    """Unit vectors of the sensor's axes x, y and z in the room, rows of (3, 3).

    The outer axis is level, along y at the start; it raises x by alpha 1. The inner axis is x; it turns y
    and z by alpha 2. So the vertical in sensor axes is the last column.
    """
    x = np.array([np.cos(alpha_1), 0.0, np.sin(alpha_1)])
    y, z = np.array([0.0, 1.0, 0.0]), np.array([-np.sin(alpha_1), 0.0, np.cos(alpha_1)])
    cosine, sine = np.cos(alpha_2), np.sin(alpha_2)
    return np.stack([x, cosine * y + sine * z, cosine * z - sine * y])


@dataclass(frozen=True)
class Box:
    """A block: its center (3,), the directions of its edges, rows of (3, 3), half their lengths (3,), and its color."""

    center: Array
    edges: Array
    halves: Sequence[float]
    color: tuple[float, float, float]

    def faces(self, view: View) -> list[tuple[Array, tuple[float, float, float]]]:
        """The sides that are seen: corners (4, 3) and color in the light."""
        out = []
        spans = self.edges * np.asarray(self.halves)[:, None]
        for k in range(3):
            one, other = spans[(k + 1) % 3], spans[(k + 2) % 3]
            for sign in (1.0, -1.0):
                normal = sign * self.edges[k]
                if normal @ view.toward <= 0:
                    continue
                middle = self.center + sign * spans[k]
                corners = np.stack([middle + a * one + b * other for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))])
                shade = 0.78 + 0.22 * float(normal @ LIGHT)
                r, g, b = (min(1.0, shade * part) for part in self.color)
                out.append((corners, (r, g, b)))
        return out


def table(axes_in_room: Array) -> list[Box]:
    """The blocks of the stand: posts, outer frame, inner shaft, sensor."""
    x, y, z = axes_in_room
    level, side = np.eye(3), np.array([0.0, 1.0, 0.0])
    across = np.cross(x, side)  # square to the outer frame
    frame = np.stack([x, side, across])
    boxes = [Box(np.array([0.0, 0.0, -1.32]), level, (0.62, 1.75, 0.06), STONE)]
    for sign in (1.0, -1.0):
        boxes += [
            Box(np.array([0.0, sign * 1.55, -0.53]), level, (0.16, 0.08, 0.73), STONE),
            Box(sign * 1.35 * side, frame, (0.05, 0.16, 0.05), BLUE),
            Box(sign * 1.10 * side, frame, (1.11, 0.09, 0.09), BLUE),
            Box(sign * 1.02 * x, frame, (0.09, 1.01, 0.09), BLUE),
            Box(sign * 0.68 * x, np.stack([x, y, z]), (0.28, 0.05, 0.05), GREEN),
        ]
    return [*boxes, Box(np.zeros(3), np.stack([x, y, z]), (0.40, 0.40, 0.40), GREEN)]


@dataclass(frozen=True)
class Scene:
    """Axes without a frame on which lines, arrows and labels are put by their places in space."""

    axes: Axes
    view: View

    def line(self, points: Array, color: str, **style: Any) -> None:
        """A line through points (n, 3)."""
        self.axes.plot(*self.view.seen(points).T, color=color, **style)

    def arrow(self, start: Array, end: Array, color: str, width: float = 1.8, zorder: float = 50) -> None:
        """A straight arrow from a point to another, (3,) each."""
        style: dict[str, Any] = {"arrowstyle": "-|>,head_width=0.28,head_length=0.6", "shrinkA": 0, "shrinkB": 0}
        style |= {"color": color, "linewidth": width, "mutation_scale": 12}
        self.axes.annotate("", self.view.seen(end), self.view.seen(start), arrowprops=style, zorder=zorder)

    def label(self, point: Array, text: str, color: str = INK, size: float = 13) -> None:
        """Text about a point (3,)."""
        x, y = self.view.seen(point)
        self.axes.text(x, y, text, color=color, fontsize=size, ha="center", va="center", zorder=60)

    def path(self, points: Array, color: str, width: float = 2.0) -> None:
        """A curve through points (n, 3) that ends in an arrow."""
        self.line(points[:-3], color, linewidth=width, zorder=50, solid_capstyle="round")
        self.arrow(points[-5], points[-1], color, width)

    def turn(self, center: Array, one: Array, other: Array, span: tuple[float, float], color: str) -> None:
        """An arrow that turns from `one` to `other`, vectors (3,) square to each other, over angles in rad."""
        angles = np.linspace(*span, 60)[:, None]
        self.path(center + np.cos(angles) * one + np.sin(angles) * other, color)

    def on_sphere(self, path: Array, color: str, width: float) -> None:
        """A curve (n, 3) on the unit sphere, solid on the near side and dashed on the far one."""
        near = (path @ self.view.toward >= 0)[:, None]
        places = self.view.seen(path)
        self.axes.plot(*np.where(near, places, np.nan).T, color=color, linewidth=width)
        dashed = (0, (2, 3))
        self.axes.plot(*np.where(near, np.nan, places).T, color=color, linewidth=0.7 * width, linestyle=dashed)


def draw_stand(axes: Axes) -> None:
    """The table, tilted by alpha 1 and turned by alpha 2, with the sensor's axes and the vertical."""
    from matplotlib.patches import Polygon

    scene = Scene(axes, View(141.0, 22.0))
    view = scene.view
    in_room = sensor_axes(ALPHA_1, ALPHA_2)
    ground, *blocks = table(in_room)
    for order, block in enumerate((ground, *sorted(blocks, key=lambda one: float(one.center @ view.toward)))):
        for corners, color in block.faces(view):
            style: dict[str, Any] = {"edgecolor": INK, "linewidth": 0.6, "joinstyle": "round", "zorder": 2 + order}
            axes.add_patch(Polygon(view.seen(corners), facecolor=color, **style))
        if block.center @ block.center == 0:  # the sensor: what points away from the eye begins behind it
            behind = 1.5 + order
    x, y, z = in_room
    side, level = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    upright = np.cross(x, side)
    scene.line(np.stack([1.63 * side, 2.15 * side]), OUTER, linestyle="-.", linewidth=1.3, zorder=40)
    scene.line(np.stack([-1.63 * side, -2.15 * side]), OUTER, linestyle="-.", linewidth=1.3, zorder=1)
    scene.turn(1.95 * side, 0.30 * level, 0.30 * UP, (-0.9, 3.4), OUTER)
    scene.label(2.0 * side + 0.55 * level + 0.12 * UP, r"$\alpha_1$", OUTER, 17)
    # how far the inner axis is from level
    scene.line(np.stack([1.5 * level, 2.4 * level]), INK, linestyle=":", linewidth=1.2, zorder=40)
    scene.turn(np.zeros(3), 2.2 * level, 2.2 * UP, (0.0, ALPHA_1), OUTER)
    scene.label(2.42 * (np.cos(ALPHA_1 / 2) * level + np.sin(ALPHA_1 / 2) * UP), r"$\alpha_1$", OUTER, 15)
    scene.line(np.stack([-1.12 * x, -1.6 * x]), INNER, linestyle="-.", linewidth=1.3, zorder=40)
    scene.label(-1.56 * x + 0.5 * side, "inner axis", INNER, 10)
    scene.label(-2.2 * side + 0.16 * UP, "outer axis,\nlevel", OUTER, 10)
    scene.turn(1.55 * x, 0.30 * side, 0.30 * upright, (-2.2, 2.2), INNER)
    scene.label(1.55 * x + 0.55 * upright, r"$\alpha_2$", INNER, 17)
    for unit, name, begin, end in ((x, "x", 1.11, 2.45), (y, "y", 0.4, 1.15), (z, "z", 0.4, 1.15)):
        away = unit @ view.toward < 0 and name != "x"
        scene.arrow(begin * unit, end * unit, INK, zorder=behind if away else 50)
        scene.label((end + 0.16) * unit, f"${name}$")
    scene.arrow(np.zeros(3), 1.7 * UP, VERTICAL, 2.6)
    scene.label(1.86 * UP, r"vertical $\eta$", VERTICAL, 12)
    axes.set_xlim(-2.25, 2.25)
    axes.set_ylim(-1.9, 2.05)


def draw_sphere(axes: Axes) -> None:
    """The vertical in sensor axes: where the two angles put it, and the circles along which each moves it."""
    scene = Scene(axes, View(38.0, 22.0))
    outline = np.linspace(0.0, 2.0 * np.pi, 241)
    axes.fill(np.cos(outline), np.sin(outline), color="#f4f6f9", zorder=0)
    axes.plot(np.cos(outline), np.sin(outline), color=INK, linewidth=1.2)
    turn = np.linspace(-np.pi, np.pi, 361)
    for degrees in range(-60, 61, 30):
        scene.on_sphere(_vertical(np.full_like(turn, np.radians(degrees)), turn), PALE, 0.7)
    for degrees in range(0, 180, 30):
        scene.on_sphere(_vertical(turn, np.full_like(turn, np.radians(degrees))), PALE, 0.7)
    scene.on_sphere(_vertical(np.full_like(turn, ALPHA_1), turn), INNER, 1.6)
    scene.on_sphere(_vertical(turn, np.full_like(turn, ALPHA_2)), OUTER, 1.6)
    for unit, name in zip(np.eye(3), "xyz", strict=True):
        scene.arrow(np.zeros(3), 1.45 * unit, INK)
        scene.label(1.6 * unit, f"${name}$")
    share = np.linspace(0.0, 1.0, 60)
    scene.path(_vertical(0.0 * share, ALPHA_2 * share), INNER, 3.0)
    scene.path(_vertical(ALPHA_1 * share, np.full_like(share, ALPHA_2)), OUTER, 3.0)
    tip = _vertical(np.array(ALPHA_1), np.array(ALPHA_2))
    scene.arrow(np.zeros(3), tip, VERTICAL, 2.6)
    halfway = np.array(0.5 * ALPHA_2)
    scene.label(1.3 * _vertical(np.array(-0.08), halfway), r"$\alpha_2$", INNER, 17)
    scene.label(_vertical(np.array(0.5 * ALPHA_1), np.array(ALPHA_2 + 0.22)), r"$\alpha_1$", OUTER, 17)
    scene.label(0.42 * tip + np.array([-0.09, 0.11, 0.0]), r"$\eta$", VERTICAL, 15)
    axes.set_xlim(-1.8, 1.8)
    axes.set_ylim(-1.5, 1.66)


def _vertical(alpha_1: Array, alpha_2: Array) -> Array:
    """The vertical in sensor axes, (..., 3), as of `acalx.TwoAxis`."""
    level = np.cos(alpha_1)
    return np.stack([np.sin(alpha_1) + 0.0 * alpha_2, level * np.sin(alpha_2), level * np.cos(alpha_2)], axis=-1)


def draw_figure_1(directory: Path) -> None:
    """The stand beside the sphere of the vertical."""
    figure, (left, right) = new_figure(10.4, 5.2, columns=2)
    draw_stand(left)
    draw_sphere(right)
    left.set_title(
        r"The table raises the inner axis by $\alpha_1$ and turns the sensor about it by $\alpha_2$", fontsize=10
    )
    right.set_title(r"The vertical $\eta$ in sensor axes", fontsize=10)
    formulas = r"$x = \sin\alpha_1$     $y = \cos\alpha_1\,\sin\alpha_2$     $z = \cos\alpha_1\,\cos\alpha_2$"
    right.text(0.0, -1.42, formulas, ha="center", fontsize=12, color=INK)
    for axes in (left, right):
        axes.set_aspect("equal")
        axes.axis("off")
    save(figure, directory, "figure_1")


if __name__ == "__main__":
    draw_figure_1(Path(__file__).resolve().parent)
