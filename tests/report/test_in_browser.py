"""The HTML report in a real browser: its plots are drawn, zoom together, and nothing is asked of any network."""

import io
from dataclasses import replace

import matplotlib.image
import numpy as np
import pytest
from browser import Page
from diagnosis_example import diagnosis_example, without_nominal
from diagnosis_page import page_of, written

from benchmarks.pictures import photograph
from symid.arrays import FloatArray
from symid.diagnosis import Signals
from symid.report.figures.colours import EXPLAINED, MEASURED, MODEL, NOMINAL, PAPER, in_dark
from symid.report.pages.diagnosis_page import write_diagnosis_html

pytestmark = pytest.mark.browser

DRAWN = """
new Promise((drawn, failed) => {
  const begin = Date.now();
  const look = () => {
    if (window.Bokeh && Bokeh.documents.length && Bokeh.documents.every(one => one.is_idle)) setTimeout(drawn, 100);
    else if (Date.now() - begin > 30000) failed("the plots are not drawn");
    else setTimeout(look, 50);
  };
  look();
})
"""
RANGES = """
["force", "error", "position", "velocity"].map(name => Bokeh.documents[0].get_model_by_name(`plot of ${name}`))
  .map(plot => [plot.x_range.start, plot.x_range.end, plot.y_range.start, plot.y_range.end])
"""


def opened(page: Page, text: str, folder) -> None:
    file = folder / "report.html"
    file.write_text(text, encoding="utf-8")
    page.open(file)
    page.evaluate(DRAWN)
    assert page.complaints == []
    asked = [address for address in page.requests if not address.startswith("data:")]
    assert asked == [file.resolve().as_uri()]


def place(page: Page, selector: str) -> dict[str, float]:
    script = f"document.querySelector('{selector}').getBoundingClientRect().toJSON()"
    return dict(page.evaluate(script))


def pictures(page: Page, *selectors: str) -> list[FloatArray]:
    """What elements show: parts of one picture, as each one of a page beyond its window draws all plots anew."""
    boxes = [place(page, selector) for selector in selectors]
    left, top = min(box["left"] for box in boxes), min(box["top"] for box in boxes)
    right, bottom = max(box["right"] for box in boxes), max(box["bottom"] for box in boxes)
    whole = page.picture({"x": left, "y": top, "width": right - left, "height": bottom - top})
    shown = matplotlib.image.imread(io.BytesIO(whole))[:, :, :3]
    edges = [[round(box[side] - top) for side in ("top", "bottom")] for box in boxes]
    sides = [[round(box[side] - left) for side in ("left", "right")] for box in boxes]
    return [shown[slice(*rows), slice(*columns)] for rows, columns in zip(edges, sides, strict=True)]


def pixels_of(part: FloatArray, *colours: str) -> list[int]:
    """How many pixels of a picture have each colour."""
    wanted = [np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255 for colour in colours]
    return [int((np.abs(part - colour).max(axis=2) < 0.02).sum()) for colour in wanted]


def pixels(page: Page, selector: str, *colours: str) -> list[int]:
    """How many pixels of an element have each colour."""
    return pixels_of(*pictures(page, selector), *colours)


LEGEND = 100
"""More pixels than the names of curves alone take."""


TEXTS = (
    *(
        "h1",
        ".verdict",
        ".eyebrow",
        ".note",
        ".figures dt",
        ".figures dd",
        "thead th",
        "tbody td",
        ".unit",
        ".or",
    ),
    *(".accepted th", ".absorbed td", ".tag", ".absorbed .tag", "summary", ".next", "footer", ".ticks i"),
)
PAPER_SHOWN = "getComputedStyle(document.body).backgroundColor"


def curves_are_drawn(page: Page, kind: str) -> None:
    signals, spectrum = pictures(page, "#signals .plot", "#spectrum .plot")
    assert min(pixels_of(signals, MODEL, MEASURED)) > 10 * LEGEND
    model, explained = pixels_of(spectrum, MODEL, EXPLAINED)
    assert model > 5 * LEGEND
    assert (explained > 5 * LEGEND) == bool(diagnosis_example(kind).effects)


def text_stands_out(page: Page, *texts: str) -> None:
    for scheme, paper in (("light", "rgb(255, 255, 255)"), ("dark", "rgb(23, 23, 23)")):
        page.prefer(scheme)
        assert page.evaluate(PAPER_SHOWN) == paper
        assert min(page.contrasts(*texts).values()) > 4.5


@pytest.mark.parametrize(  # of the other kinds, tests below open the pages
    ("kind", "texts"),
    [
        ("two effects", TEXTS),
        ("no gap", (".verdict",)),
        ("unexplained", (".verdict", ".faults li")),
        ("recording", (".verdict", ".faults li")),
    ],
)
def test_curves_are_drawn_and_text_stands_out(kind, texts, page, tmp_path):
    opened(page, page_of(kind), tmp_path)
    curves_are_drawn(page, kind)
    text_stands_out(page, *texts)


def test_plots_turn_dark_with_their_page(page, tmp_path):
    page.prefer("dark")
    opened(page, page_of("effect"), tmp_path)
    dark = [in_dark(colour) for colour in (PAPER, MODEL, EXPLAINED)]
    (light,) = pixels(page, "#spectrum .plot", PAPER)
    paper, model, explained = pixels(page, "#spectrum .plot", *dark)
    assert light == 0
    assert paper > 1000 * LEGEND
    assert min(model, explained) > 5 * LEGEND
    light, paper = pixels(page, ".schematic svg", PAPER, dark[0])
    assert light == 0
    assert paper > 10 * LEGEND


def test_print_is_light(page, tmp_path):
    page.prefer("dark", "print")
    opened(page, page_of("effect"), tmp_path)
    assert page.evaluate(PAPER_SHOWN) == "rgb(255, 255, 255)"
    assert min(page.contrasts("h1", ".verdict", ".note", ".tag", ".next").values()) > 4.5
    paper, dark = pixels(page, "#spectrum .plot", PAPER, in_dark(PAPER))
    assert paper > 1000 * LEGEND > dark


def test_a_page_becomes_a_picture(tmp_path):
    file, picture = tmp_path / "report.html", tmp_path / "page.png"
    write_diagnosis_html(diagnosis_example("effect"), file)
    photograph(file, picture, 900, 700)
    shown = matplotlib.image.imread(picture)[:, :, :3]
    assert shown.shape == (700, 900, 3)
    wanted = np.array([int(EXPLAINED[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    assert (np.abs(shown - wanted).max(axis=2) < 0.1).sum() > 20  # the bar of the explained gap


def test_nominal_values_are_drawn_where_they_are_given(page, tmp_path):
    opened(page, page_of("parameters"), tmp_path)
    curves_are_drawn(page, "parameters")
    (given,) = pixels(page, "#signals .plot", NOMINAL)
    text_stands_out(page, ".verdict")
    page.events.clear()
    page.prefer("light")
    opened(page, written(without_nominal(diagnosis_example("parameters"))), tmp_path)
    assert given > LEGEND
    assert pixels(page, "#signals .plot", NOMINAL) == [0]


def test_hostile_names_run_nothing(page, tmp_path):
    hostile = "</script><script>window.hostile = 1</script><img src=x onerror='window.hostile = 1'>"
    found = diagnosis_example("effect")
    gap = replace(found.gap, signal=hostile, unit=hostile)
    opened(page, written(replace(found, sentence=hostile, logs=(hostile,), gap=gap)), tmp_path)
    assert page.evaluate("typeof window.hostile") == "undefined"
    assert page.evaluate("document.querySelector('h1').textContent").endswith(hostile)


def test_an_error_is_drawn_over_motion_saved_and_zoomed(page, tmp_path):
    signals = diagnosis_example("effect").signals
    opened(page, page_of("effect"), tmp_path)
    curves_are_drawn(page, "effect")
    is_drawn_over_motion(page)
    data_are_saved(page, signals.measured)
    a_drag_zooms_all_curves_over_time(page, signals)


def is_drawn_over_motion(page: Page) -> None:
    beside = (f"#over-motion .beside > :{which}-child .plot" for which in ("first", "last"))
    for part in pictures(page, *beside):
        assert min(pixels_of(part, MODEL, EXPLAINED)) > 2 * LEGEND


def data_are_saved(page: Page, measured: FloatArray) -> None:
    page.evaluate("URL.createObjectURL = blob => { window.saved = blob; return '#'; }")
    saved = {}
    for section in ("signals", "over-motion", "spectrum"):
        page.evaluate(f"document.querySelector('#{section} button.save').click()")
        saved[section] = page.evaluate("window.saved.text()")
    names, *rows = (line.split(",") for line in saved["signals"].splitlines())
    assert {"time", "measured", "reidentified", "position"} <= set(names)
    force = [float(row[names.index("measured")]) for row in rows if row[names.index("measured")]]
    # of long logs, lowest and highest value of each bundle of samples
    assert 3_000 < len(force) <= 6_000 < measured.size
    assert [min(force), max(force)] == pytest.approx([measured.min(), measured.max()], rel=1e-6)
    assert saved["spectrum"].startswith("frequency,")
    assert len(saved["over-motion"].split("\n\n")) > 2  # dots and means


def a_drag_zooms_all_curves_over_time(page: Page, signals: Signals) -> None:
    page.evaluate("document.querySelector('#signals').scrollIntoView()")
    before = np.array(page.evaluate(RANGES))
    box = place(page, "#signals .plot")
    middle, height = box["left"] + box["width"] / 2, box["top"] + 200
    page.drag((middle, height), (middle + box["width"] / 10, height))
    page.evaluate(DRAWN)
    after = np.array(page.evaluate(RANGES))
    length = after[:, 1] - after[:, 0]
    assert length == pytest.approx(length[0])
    assert 0.08 < length[0] / (before[0, 1] - before[0, 0]) < 0.14
    seen = (signals.time > after[2, 0]) & (signals.time < after[2, 1])
    travel = np.ptp(signals.position[seen])
    assert travel < 0.8 * np.ptp(signals.position)
    assert travel <= after[2, 3] - after[2, 2] < 1.2 * travel  # the part that is shown fills its plot
