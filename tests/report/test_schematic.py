"""The schematic: everything that is declared is drawn once, nothing lies on a label, and both backgrounds work."""

from itertools import combinations
from pathlib import Path

import pytest
from axes import gantry
from axes.catalogue import cases
from axes.effects import EFFECTS, with_effect
from command_line import run
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from symid import (
    ActuatorDelay,
    ActuatorLag,
    EncoderRipple,
    ForceConstantRipple,
    ForceLimit,
    FrictionDrift,
    FrictionTrend,
    GainAsymmetry,
    GainNonlinearity,
    LoadDependentFriction,
    PayloadChange,
    PeriodicForce,
    PreslidingFriction,
    chain,
    load_axis,
)
from symid.axis import axis_names
from symid.report.figures.colours import DARK, LIGHT, Palette
from symid.report.figures.schematic import draw_schematic

AXES = {
    **{name: load_axis(name) for name in axis_names()},
    **{name: case.declared for name, case in cases().items()},
    **{f"with_{name}": with_effect(name) for name in EFFECTS},
    "chain_5m4s": chain("chain_5m4s", 5),
}


_RIGID = load_axis("rigid_1m")
_TWO = load_axis("ballscrew_2m1s")
IMPERFECT = {
    "imperfect_drive": _RIGID.with_effect(
        ActuatorDelay(0.001),
        ActuatorLag(0.002),
        ForceLimit(250.0),
        GainAsymmetry(0.1),
        GainNonlinearity(0.01, power=2),
    ),
    "imperfect_joint": _RIGID.with_effect(
        PeriodicForce(_RIGID.bodies[0], 5.0, -3.0, frequency=11.0),
        FrictionDrift(_RIGID.bodies[0], 4.0, 15.0, time_constant=600.0),
        PreslidingFriction(_RIGID.bodies[0], 4.0, reach=1e-4),
        ForceConstantRipple(0.03, 0.02, pitch=0.024),
    ),
    "imperfect_screw": _TWO.with_effect(
        EncoderRipple("ql", 2e-6, 1e-6, pitch=0.01),
        PayloadChange(_TWO.bodies[1], 30.0, time=9.0),
        FrictionTrend(_TWO.bodies[1], 1.0, 2.0),
        LoadDependentFriction(_TWO.bodies[0], 0.2),
    ),
}
AXES |= IMPERFECT
AXES["gantry"] = gantry.AXIS


@pytest.mark.parametrize("name", IMPERFECT)
def test_imperfections_are_marked_where_they_act_and_explained_below(name: str) -> None:
    axis = IMPERFECT[name]
    notes = [t.get_text() for t in draw_schematic(axis).axes[0].texts if t.get_gid() == "note"]
    elsewhere = [label for label in labels(draw_schematic(axis)) if label not in notes]
    for i, element in enumerate(axis.imperfections):
        mark = chr(ord("\u2460") + i)
        assert f"{mark} {element.formula}" in " ".join(" ".join(notes).split())
        assert sum(mark in label for label in elsewhere) == 1


def labels(figure: Figure) -> list[str]:
    """Texts of a figure."""
    return [text.get_text() for text in figure.axes[0].texts if text.get_text()]


def names(figure: Figure) -> set[str]:
    """Group ids of everything drawn."""
    return {artist.get_gid() for artist in figure.axes[0].get_children() if artist.get_gid()}


@pytest.mark.parametrize("name", list(AXES))
def test_every_body_parameter_and_signal_has_a_label(name: str) -> None:
    axis = AXES[name]
    figure = draw_schematic(axis)
    shown = [part for label in labels(figure) for part in label.replace(" g sin q", "").split(", ")]
    many = [
        p
        for law in axis.laws
        if len(law.terms()) > 2
        for p in dict.fromkeys(t.parameter for t in law.terms())
    ]
    expected = {b.name for b in axis.bodies} | {s.signal for s in axis.sensors}
    expected |= set(axis.physical_parameters) - set(many) | {
        drive.command or drive.signal for drive in axis.drives
    }
    assert expected <= set(shown), expected - set(shown)
    assert {f"body {b.name}" for b in axis.bodies} | {f"sensor {s.signal}" for s in axis.sensors} <= names(
        figure
    )


@pytest.mark.parametrize("name", list(AXES))
def test_no_label_lies_on_another_one_or_outside(name: str) -> None:
    figure = draw_schematic(AXES[name])
    renderer = FigureCanvasAgg(figure).get_renderer()
    texts = [text for text in figure.axes[0].texts if text.get_text()]
    boxes = {id(text): text.get_window_extent(renderer) for text in texts}
    for first, second in combinations(texts, 2):
        overlap = boxes[id(first)].overlaps(boxes[id(second)])
        assert not overlap, f"{first.get_text()!r} lies on {second.get_text()!r}"
    for text in texts:
        box = boxes[id(text)]
        inside = figure.bbox.contains(box.x0, box.y0) and figure.bbox.contains(box.x1, box.y1)
        assert inside, f"{text.get_text()!r} is cut off"


def test_bodies_that_turn_are_discs() -> None:
    patches = {p.get_gid(): p for p in draw_schematic(AXES["geared_ballscrew_3m2s"]).axes[0].patches}
    assert isinstance(patches["body screw"], Circle)
    assert not isinstance(patches["body table"], Circle)


def test_kinds_of_sensors_differ_by_their_lines() -> None:
    lines = {line.get_gid(): line.get_linestyle() for line in draw_schematic(AXES["triangle"]).axes[0].lines}
    assert (lines["sensor qa"], lines["sensor dc"], lines["sensor ddb"]) == ("-", "--", ":")


@pytest.mark.parametrize("palette", [LIGHT, DARK])
def test_ink_stands_out_from_paper_and_bodies(palette: Palette) -> None:
    def grey(colour: str) -> float:
        return sum(w * int(colour[i : i + 2], 16) / 255 for w, i in ((0.299, 1), (0.587, 3), (0.114, 5)))

    for ground in (palette.paper, palette.fill):
        assert abs(grey(palette.ink) - grey(ground)) > 0.5
    assert abs(grey(palette.measured) - grey(palette.model)) > 0.2, "the curves are one in grey print"


def test_show_draws_it(folder: Path) -> None:
    assert run("show", "motor_bench", "--plot", "axis.svg", "--dark") == 0
    drawn = Path("axis.svg").read_text()
    assert 'id="body motor"' in drawn
    assert DARK.paper.lower() in drawn.lower()
    assert run("show", "motor_bench", "--plot", "axis.bmp") == 2
