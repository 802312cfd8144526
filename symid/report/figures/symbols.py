"""Signs of mechanical elements, drawn along a line from one end to the other."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon, Rectangle

from symid.arrays import FloatArray
from symid.report.figures.colours import Palette

_HALF = 0.14
"""Half the height of a sign."""
_LENGTH = 0.62
"""Length of a sign; the rest of the line is straight."""
LINE = 1.3


Points = Sequence[tuple[float, float]]
"""Points along and across a line."""


@dataclass(frozen=True)
class Line:
    """A straight line between two elements on which a sign is drawn."""

    begin: tuple[float, float]
    end: tuple[float, float]

    @property
    def length(self) -> float:
        """Distance between its ends."""
        return float(np.hypot(*np.subtract(self.end, self.begin)))

    def points(self, local: Points) -> FloatArray:
        """Points given along and across the line, from its middle."""
        along = np.subtract(self.end, self.begin) / self.length
        across = np.array([-along[1], along[0]])
        middle = np.add(self.begin, self.end) / 2
        return np.array([middle + u * along + w * across for u, w in local])


Sign = Callable[[Axes, Line, Palette, str], None]


def _stroke(axes: Axes, line: Line, palette: Palette, name: str, *parts: Points) -> None:
    for points in parts:
        x, y = line.points(points).T
        axes.plot(x, y, color=palette.ink, linewidth=LINE, gid=name, solid_capstyle="butt", zorder=2)


def _leads(line: Line, half: float = _LENGTH / 2) -> tuple[Points, Points]:
    """The straight parts on both sides of a sign."""
    end = line.length / 2
    return [(-end, 0.0), (-half, 0.0)], [(half, 0.0), (end, 0.0)]


def _filled(axes: Axes, line: Line, palette: Palette, name: str, corners: Points) -> None:
    look: Any = {
        "facecolor": palette.fill,
        "edgecolor": palette.ink,
        "linewidth": LINE,
        "gid": name,
        "zorder": 3,
    }
    axes.add_patch(Polygon(line.points(corners), **look))


def spring(axes: Axes, line: Line, palette: Palette, name: str) -> None:
    """Symbol of a spring: a zigzag line."""
    teeth = 8
    u = np.linspace(-_LENGTH / 2, _LENGTH / 2, teeth + 2)
    w = [0.0, *(_HALF * (-1) ** k for k in range(teeth)), 0.0]
    _stroke(axes, line, palette, name, *_leads(line), list(zip(u.tolist(), w, strict=True)))


def damper(axes: Axes, line: Line, palette: Palette, name: str) -> None:
    """A piston in a cylinder that is open on one side."""
    cup = [(0.2, _HALF), (-0.16, _HALF), (-0.16, -_HALF), (0.2, -_HALF)]
    end = line.length / 2
    parts = [[(-end, 0.0), (-0.16, 0.0)], cup, [(0.04, 0.1), (0.04, -0.1)], [(0.04, 0.0), (end, 0.0)]]
    _stroke(axes, line, palette, name, *parts)


def friction(axes: Axes, line: Line, palette: Palette, name: str) -> None:
    """A shoe that slides on a rail."""
    end = line.length / 2
    rail = [(-end, 0.0), (-0.24, 0.0), (-0.24, -_HALF), (0.3, -_HALF)]
    _stroke(axes, line, palette, name, rail, [(0.1, 0.04), (end, 0.04)])
    shoe = [(-0.1, -_HALF + 0.02), (0.14, -_HALF + 0.02), (0.14, 0.12), (-0.1, 0.12)]
    _filled(axes, line, palette, name, shoe)


def play(axes: Axes, line: Line, palette: Palette, name: str) -> None:
    """A tongue in a fork with room on both sides."""
    end = line.length / 2
    fork = [(0.2, _HALF), (-0.2, _HALF), (-0.2, -_HALF), (0.2, -_HALF)]
    _stroke(axes, line, palette, name, [(-end, 0.0), (-0.2, 0.0)], fork)
    _stroke(axes, line, palette, name, [(0.2, _HALF), (0.2, 0.06)], [(0.2, -_HALF), (0.2, -0.06)])
    _stroke(axes, line, palette, name, [(0.0, 0.09), (0.0, -0.09)], [(0.0, 0.0), (end, 0.0)])


def law(axes: Axes, line: Line, palette: Palette, name: str) -> None:
    """Any other law: a box with a bent curve in it."""
    _stroke(axes, line, palette, name, *_leads(line, 0.2))
    _filled(axes, line, palette, name, [(-0.2, -_HALF), (0.2, -_HALF), (0.2, _HALF), (-0.2, _HALF)])
    u = np.linspace(-0.15, 0.15, 25)
    x, y = line.points(list(zip(u.tolist(), (0.1 * np.tanh(u / 0.05)).tolist(), strict=True))).T
    axes.plot(x, y, color=palette.ink, linewidth=LINE, zorder=4)


def drive(axes: Axes, line: Line, palette: Palette, name: str) -> None:
    """A circle that pushes both ends apart."""
    _stroke(axes, line, palette, name)
    end, radius = line.length / 2, 0.17
    (centre,) = line.points([(0.0, 0.0)])
    look: Any = {
        "facecolor": palette.paper,
        "edgecolor": palette.model,
        "linewidth": 1.8,
        "gid": name,
        "zorder": 3,
    }
    axes.add_patch(Circle(tuple(centre), radius, **look))
    for side in (-1.0, 1.0):
        tip, start = line.points([(side * end, 0.0), (side * radius, 0.0)])
        arrow = {"arrowstyle": "-|>", "color": palette.model, "linewidth": 1.8, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", tip, start, arrowprops=arrow, zorder=3)


def gear(axes: Axes, line: Line, palette: Palette, name: str) -> None:
    """A rigid transmission: two lines."""
    end = line.length / 2
    _stroke(axes, line, palette, name, [(-end, 0.05), (end, 0.05)], [(-end, -0.05), (end, -0.05)])
    _stroke(axes, line, palette, name, [(-0.1, -0.13), (0.1, 0.13)])


def wall(axes: Axes, corner: tuple[float, float], width: float, height: float, palette: Palette) -> None:
    """The ground: a hatched strip."""
    look: Any = {"facecolor": palette.paper, "edgecolor": palette.ink, "linewidth": 0, "gid": "ground"}
    axes.add_patch(Rectangle(corner, width, height, hatch="////", **look))
