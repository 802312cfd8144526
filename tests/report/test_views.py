"""Axes, logs and results show themselves: a line, tables, a figure, a page."""

import re
import xml.etree.ElementTree as ET
from functools import cache
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import symid
from symid.data import Log
from symid.errors import SettingError


def recorded(seed: int = 0) -> Log:
    """M = 5 kg, Fv = 1 N s/m, Fs = 2 N by hand, with a little noise."""
    t = np.arange(4000) / 1000
    q, v, a = np.sin(10 * t), 10 * np.cos(10 * t), -100 * np.sin(10 * t)
    noise = 0.05 * np.random.default_rng(seed).standard_normal(t.size)
    force = 5 * a + v + 2 * np.sign(v) + noise
    return Log.from_arrays({"q": q, "F": force}, sampling_period=1e-3, source="a<b>\x1b.csv")


@cache
def results() -> dict[str, object]:
    log = recorded()
    return {
        "axis": symid.load_axis("rigid_1m"),
        "log": log,
        "derived": symid.derive("rigid_1m"),
        "identification": symid.identify("rigid_1m", log),
        "tuning": symid.tune("rigid_1m", {"M": 5.0, "Fv": 1.0, "Fs": 2.0}),
        "diagnosis": symid.diagnose("rigid_1m", log),
    }


KINDS = ["axis", "log", "derived", "identification", "tuning", "diagnosis"]


class Parser(HTMLParser):
    """Tags that are open, and all text."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.text, self.tags = "", []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.tags.append(tag)

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.mark.parametrize("kind", KINDS)
def test_the_repr_is_a_short_line(kind: str) -> None:
    line = repr(results()[kind])
    assert line.startswith(f"<{type(results()[kind]).__name__} ")
    assert len(line) < 400
    assert line.isprintable()


def test_the_line_of_an_identification_says_what_was_found() -> None:
    found = results()["identification"]
    assert "rigid_1m from q, " in repr(found)
    (mass,) = re.findall(r"M = ([\d.]+) ± ", repr(found))
    assert float(mass) == pytest.approx(5.0, rel=1e-4)


@pytest.mark.parametrize("kind", KINDS)
def test_notebooks_are_shown_the_text_of_the_summary_escaped(kind: str) -> None:
    found = results()[kind]
    page = Parser(found._repr_html_())
    assert set(page.tags) <= {"pre", "span"}
    assert page.text.split() == found.summary().split()
    assert "\x1b" not in page.text


def test_an_axis_is_shown_as_its_file_declares_it() -> None:
    printed = results()["axis"].summary()
    assert 'ViscousFriction(motor, "Fv")' in printed
    assert "inertia=None" not in printed


@pytest.mark.usefixtures("plain_pages")
def test_an_identification_shows_the_motion_of_its_logs(tmp_path: Path) -> None:
    found = results()["identification"]
    labels = [axes.get_xlabel() for axes in found.plot().axes]
    assert "velocity of q [m/s]" in labels
    page = found.report(tmp_path / "page.html").read_text(encoding="utf-8")
    assert "Nothing was simulated" not in page
    assert "Fit of q simulated" in page
    # which names its axis only
    of_model = symid.identify(symid.load_generated("rigid_1m", ("q",)), recorded())
    drawn = of_model.plot(axis="rigid_1m", runs=[recorded().to_frame()])
    assert [axes.get_xlabel() for axes in drawn.axes] == labels


def test_scales_are_labelled_by_plain_numbers() -> None:
    for kind in ("identification", "tuning"):
        figure = results()[kind].plot()
        figure.canvas.draw()
        ticks = [text.get_text() for axes in figure.axes for text in axes.get_xticklabels(which="both")]
        assert not any("$" in tick for tick in ticks)
        assert any(tick in ("1", "10", "100") for tick in ticks)


@pytest.mark.parametrize("kind", KINDS)
def test_figures_are_drawn_and_shown_by_notebooks(kind: str) -> None:
    figure = results()[kind].plot()
    assert figure.axes
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_the_figure_of_a_log_holds_its_samples() -> None:
    log = recorded()
    for axes, (name, values) in zip(log.plot().axes, log.signals.items(), strict=True):
        (line,) = axes.lines
        assert axes.get_ylabel() == name
        np.testing.assert_array_equal(line.get_ydata(), values)
        np.testing.assert_array_equal(line.get_xdata(), log.time)


def test_the_figure_of_a_diagnosis_holds_force_and_error() -> None:
    found = results()["diagnosis"]
    force, error, *_ = found.plot().axes
    drawn = {line.get_label(): line.get_ydata() for line in force.lines}
    np.testing.assert_array_equal(drawn["measured"], found.signals.measured)
    difference = found.signals.measured - found.signals.reidentified
    assert any(np.array_equal(line.get_ydata(), difference, equal_nan=True) for line in error.lines)


@pytest.mark.parametrize("kind", KINDS)
def test_pages_hold_text_and_figure_and_ask_nothing(kind: str, tmp_path: Path) -> None:
    found = results()[kind]
    page = found.report(tmp_path / "page.html")
    text = page.read_text(encoding="utf-8")
    assert "default-src 'none'" in text
    assert "<b>.csv" not in text
    if kind not in ("diagnosis", "identification"):  # they have pages of their own
        assert set(found.summary().split()) <= set(Parser(text).text.split())
        picture = text[text.index("<svg ") : text.index("</svg>") + 6]
        assert ET.fromstring(picture).tag.endswith("svg")


def test_a_batch_shows_its_logs(tmp_path: Path) -> None:
    for seed in range(3):
        log = recorded(seed)
        frame = pl.DataFrame({"t": log.time, "q": log["q"], "F": log["F"]})
        frame.write_csv(tmp_path / f"{seed}.csv")
    batch = symid.identify_batch("rigid_1m", tmp_path, jobs=1)
    assert repr(batch).startswith("<Batch of 3 logs: ")
    assert "3 logs" in batch.summary()
    ok = batch.table.filter(status="ok")
    mass = batch.plot().axes[0]
    assert mass.get_ylabel() == "M [kg]"
    np.testing.assert_array_equal(mass.containers[0].lines[0].get_ydata(), ok["M"].to_numpy())
    assert "Review of a fleet" in batch.report(tmp_path / "fleet.html").read_text(encoding="utf-8")


def test_a_page_of_another_kind_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SettingError, match=r"end its name with \.html"):
        results()["identification"].report(tmp_path / "page.txt")
