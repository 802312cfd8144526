"""The schematic of an axis, drawn from its declaration: bodies in a row, the elements between them, drives and sensors.

The ground is at the left. Links of neighbours lie between them; links of a later body to the ground hang below
it; links of bodies that are not neighbours run above. A sensor is an arrow from its reference to the measured body.
"""

import textwrap
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyBboxPatch, Patch

from symid.axis import GROUND, Axis, Body, EncoderRipple, PayloadChange, PendulumWeight, Sensor, Weight
from symid.report.figures import symbols
from symid.report.figures.colours import LIGHT, Palette
from symid.report.figures.drawn import Drawn, svg_of
from symid.report.figures.schematic_links import Link, links_of, marked, marks_of, parameter_text
from symid.report.figures.symbols import Line

_GAP, _LANE, _WALL = 1.75, 0.72, 0.28
_WIDTH, _RISE = 1.15, 0.33
_BELOW = 1.15
_INCH = 0.62
"""Inches of a unit of length."""
_NOTE, _LETTER = 0.34, 0.125
"""Height of a line of a note and width of a letter, in units of length."""


_LINES = {"position": "-", "velocity": "--", "acceleration": ":"}
"""Line style of a sensor's arrow by the quantity that it reads; others are dashed and dotted."""


@dataclass(frozen=True)
class _Box:
    """Box of a body or of the ground in the drawing."""

    centre: float
    width: float
    height: float
    round: bool = False

    def side(self, right: bool, y: float) -> float:
        """Horizontal position at which a line at a height meets the box."""
        half = self.width / 2
        if self.round:
            half = float(np.sqrt(max((self.height / 2) ** 2 - y**2, 0.0)))
        return self.centre + (half if right else -half)


def schematic_svg(axis: Axis) -> str:
    """The schematic as an SVG element for a page; the same text every time."""
    return svg_of(draw_schematic(axis), axis.name)


def draw_schematic(axis: Axis, palette: Palette = LIGHT) -> Drawn:
    """The schematic of an axis as a figure; each sign has the name of its element as group id.

    >>> from symid.axis import load_axis
    >>> (axes,) = draw_schematic(load_axis("rigid_1m")).axes
    >>> [text.get_text() for text in axes.texts if text.get_text()]
    ['motor', 'M', 'Fv', 'Fs', 'F', 'q']
    """
    with mpl.rc_context({**palette.style, "hatch.color": palette.ink, "hatch.linewidth": 0.7}):
        drawing = _Drawing(axis, palette)
        drawing.draw()
        return drawing.figure


class _Drawing:
    """Places the bodies, then draws the elements between them."""

    def __init__(self, axis: Axis, palette: Palette) -> None:
        self.axis, self.palette = axis, palette
        self.order = [GROUND.name, *(body.name for body in axis.bodies)]
        self.lanes: dict[tuple[str, str], list[Link]] = {}
        self.hanging: dict[str, list[Link]] = {}
        self.above: list[Link] = []
        for link in links_of(axis):
            self._sort(link)
        self.boxes = self._boxes()
        right = max(box.centre + box.width / 2 for box in self.boxes.values()) + 0.4
        if any(isinstance(element, PendulumWeight) for element in axis.elements):
            right += 1.0
        self.notes: list[str] = []
        for element in axis.imperfections:
            text, letters = f"{marks_of(axis, element)} {element.formula}", max(int(right / _LETTER), 20)
            self.notes += textwrap.wrap(text, letters, subsequent_indent="   ")
        bottom, top = self._heights()
        self.bottom = bottom
        figure = Drawn(figsize=(_INCH * (right + 0.2), _INCH * (top - bottom)))
        self.axes: Axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        self.axes.set(xlim=(-0.2, right), ylim=(bottom, top), aspect="equal")
        self.axes.axis("off")
        self.figure = figure

    def _sort(self, link: Link) -> None:
        """Between neighbours, to the ground below, or above the bodies."""
        first, second = (self.order.index(name) for name in (link.first, link.second))
        near, far = min(first, second), max(first, second)
        if far - near == 1:
            self.lanes.setdefault((self.order[near], self.order[far]), []).append(link)
        elif near == 0:
            self.hanging.setdefault(self.order[far], []).append(link)
        else:
            self.above.append(link)

    def _boxes(self) -> dict[str, _Box]:
        most = max((len(links) for links in self.lanes.values()), default=1)
        height = max(_LANE * most + 0.3, 1.1)
        boxes, x = {GROUND.name: _Box(_WALL / 2, _WALL, height + 0.4)}, _WALL
        for body in self.axis.bodies:
            hung = 0.85 * len(self.hanging.get(body.name, ()))
            width = max(height if body.turns else _WIDTH, hung)
            boxes[body.name] = _Box(x + _GAP + width / 2, width, height, body.turns)
            x += _GAP + width
        return boxes

    @property
    def _half(self) -> float:
        """Half the height of a body."""
        return max(box.height for name, box in self.boxes.items() if name != GROUND.name) / 2

    def _heights(self) -> tuple[float, float]:
        heavy = any(isinstance(e, (Weight, PendulumWeight)) for e in self.axis.elements)
        below = _BELOW + 0.45 if self.hanging else 0.75 if heavy else 0.35
        rows = len(self.above) + len(self.axis.sensors)
        return -self._half - below - _NOTE * len(self.notes), self._half + _LANE * rows + 0.55

    def draw(self) -> None:
        """Draw the whole axis into the figure."""
        ground = self.boxes[GROUND.name]
        symbols.wall(self.axes, (0.0, -ground.height / 2), _WALL, ground.height, self.palette)
        self._stroke([_WALL, _WALL], [-ground.height / 2, ground.height / 2])
        for body in self.axis.bodies:
            self._body(body)
        for (left, right), links in self.lanes.items():
            self._between(self.boxes[left], self.boxes[right], links)
        for name, links in self.hanging.items():
            self._below(self.boxes[name], links)
        for i, link in enumerate(self.above):
            self._over(link, self._half + _LANE * (i + 0.6))
        for i, sensor in enumerate(self.axis.sensors):
            self._sensor(sensor, self._half + _LANE * (len(self.above) + i + 0.55))
        self._weights()
        for i, line in enumerate(self.notes):
            y = self.bottom + _NOTE * (len(self.notes) - i - 0.4)
            self._text(-0.1, y, line, ha="left", gid="note", fontsize=7.5)

    def _body(self, body: Body) -> None:
        box = self.boxes[body.name]
        shape: Patch
        if body.turns:
            shape = Circle((box.centre, 0.0), box.height / 2)
            self.axes.add_patch(Circle((box.centre, 0.0), 0.05, facecolor=self.palette.ink, zorder=3))
        else:
            corner = (box.centre - box.width / 2 + 0.05, -box.height / 2 + 0.05)
            shape = FancyBboxPatch(corner, box.width - 0.1, box.height - 0.1, boxstyle="round,pad=0.05")
        shape.set(facecolor=self.palette.fill, edgecolor=self.palette.ink, linewidth=1.6)
        shape.set_gid(f"body {body.name}")
        self.axes.add_patch(shape)
        self._text(box.centre, 0.2, body.name, weight="bold")
        changes = (e for e in self.axis.imperfections if isinstance(e, PayloadChange) and e.body == body)
        marks = marks_of(self.axis, *changes)
        mass = parameter_text(body.inertia if body.turns else body.mass)
        self._text(box.centre, -0.2, marked(mass, marks), style="italic")

    def _between(self, left: _Box, right: _Box, links: list[Link]) -> None:
        for i, link in enumerate(links):
            y = _LANE * ((len(links) - 1) / 2 - i) - 0.1
            line = Line((left.side(True, y), y), (right.side(False, y), y))
            link.sign(self.axes, line, self.palette, link.name)
            self._text((line.begin[0] + line.end[0]) / 2, y + _RISE, link.label)

    def _below(self, box: _Box, links: list[Link]) -> None:
        for i, link in enumerate(links):
            x = box.centre + 0.85 * (i - (len(links) - 1) / 2) - 0.12
            top = -box.height / 2
            if box.round:
                top = -float(np.sqrt(max((box.height / 2) ** 2 - (x - box.centre) ** 2, 0.0)))
            line = Line((x, -box.height / 2 - _BELOW), (x, top))
            link.sign(self.axes, line, self.palette, link.name)
            self._text(x + 0.22, sum(p[1] for p in (line.begin, line.end)) / 2 + 0.3, link.label, ha="left")
        y, half = -box.height / 2 - _BELOW, 0.425 * len(links) + 0.1
        symbols.wall(self.axes, (box.centre - half, y - 0.2), 2 * half, 0.2, self.palette)
        self._stroke([box.centre - half, box.centre + half], [y, y])

    def _over(self, link: Link, y: float) -> None:
        first, second = sorted((self.boxes[link.first], self.boxes[link.second]), key=lambda b: b.centre)
        left, right = first.centre + 0.25, second.centre - 0.25
        link.sign(self.axes, Line((left, y), (right, y)), self.palette, link.name)
        for x in (left, right):
            self._stroke([x, x], [self._half - 0.02, y])
        self._text(left + 0.5, y + 0.2, link.label)

    def _sensor(self, sensor: Sensor, y: float) -> None:
        """An arrow to the body: solid for a position, dashed for a velocity, dotted for an acceleration.

        The force in a spring, or of a drive, is read between its two bodies: dashed and dotted.
        """
        style, colour = _LINES.get(sensor.quantity, "-."), self.palette.other
        at = sensor.joint
        first, second = (at.on, at) if isinstance(at, Body) else (at.first, at.second)
        (start, low), (end, high) = self._foot(first.name), self._foot(second.name)
        for x, foot in ((start, low), (end, high)):
            self.axes.plot([x, x], [foot, y + 0.08], color=colour, linewidth=0.7, zorder=1)
        look: Any = {"color": colour, "linewidth": 1.4, "linestyle": style, "gid": f"sensor {sensor.signal}"}
        self.axes.plot([start, end], [y, y], **look)
        arrow = {"arrowstyle": "-|>", "color": colour, "linewidth": 0, "shrinkA": 0, "shrinkB": 0}
        side = np.sign(end - start)
        self.axes.annotate("", (end, y), (end - 0.2 * side, y), arrowprops=arrow)
        own = [e for e in self.axis.imperfections if isinstance(e, EncoderRipple)]
        ripples = [e for e in own if e.signal == sensor.signal]
        label = marked(sensor.signal, marks_of(self.axis, *ripples))
        label = ", ".join(
            [label, *(parameter_text(x) for x in (sensor.gain, sensor.offset) if x is not None)]
        )
        self._text(end - 0.45 * side, y + 0.2, label, color=colour)

    def _foot(self, name: str) -> tuple[float, float]:
        """Start of the line of a sensor at a body or at the ground."""
        if name == GROUND.name:
            return _WALL, self.boxes[name].height / 2
        return self.boxes[name].centre, self._half

    def _weights(self) -> None:
        for element in self.axis.elements:
            if isinstance(element, (Weight, PendulumWeight)):
                box = self.boxes[element.body.name]
                x, y = box.centre + 0.36 * box.width, -box.height / 2 * (0.7 if box.round else 1.0)
                arrow = {"arrowstyle": "-|>", "color": self.palette.ink, "linewidth": symbols.LINE}
                note = self.axes.annotate("", (x, y - 0.5), (x, y), arrowprops=arrow)
                note.set_gid(f"weight of {element.body.name}")
                moment = f"{element.moment} g sin q" if isinstance(element, PendulumWeight) else "g"
                self._text(x + 0.1, y - 0.32, moment, ha="left")

    def _stroke(self, x: list[float], y: list[float]) -> None:
        self.axes.plot(x, y, color=self.palette.ink, linewidth=symbols.LINE)

    def _text(self, x: float, y: float, text: str, ha: str = "center", **look: Any) -> None:
        look = {"color": self.palette.ink, "fontsize": 8.5, "va": "center", "ha": ha, **look}
        self.axes.text(x, y, text, parse_math=False, **look)
