"""The page of a fleet in a real browser: it opens at once, sorts, filters, pages, and shows a log under the mouse."""

import time

import polars as pl
import pytest
from browser import Page
from fleet_example import fleet_example

from symid.fleet import review_fleet
from symid.report.pages.fleet_page import write_fleet_html

pytestmark = pytest.mark.browser

HOSTILE = "</script><script>window.hostile = 1</script><img src=x onerror='window.hostile = 1'>"
ROWS = "[...document.querySelectorAll('.rows tbody tr')].map(row => [...row.cells].map(cell => cell.textContent))"
HEADINGS = "[...document.querySelectorAll('.rows th')].map(heading => heading.textContent)"


def opened(page: Page, table: pl.DataFrame, folder) -> None:
    file = folder / "fleet.html"
    write_fleet_html(review_fleet(table), file)
    page.open(file)
    assert page.complaints == []
    assert page.requests == [file.resolve().as_uri()]


def column(page: Page, name: str) -> list[str]:
    place = [heading.rstrip(" ▲▼") for heading in page.evaluate(HEADINGS)].index(name)
    return [row[place] for row in page.evaluate(ROWS)]


def click_heading(page: Page, name: str) -> None:
    page.evaluate(
        f"[...document.querySelectorAll('.rows th button')].find(b => b.textContent.startsWith('{name}')).click()"
    )


def enter(page: Page, selector: str, text: str, event: str) -> None:
    page.evaluate(
        f"(() => {{ const box = document.querySelector('{selector}'); box.value = '{text}';"
        f" box.dispatchEvent(new Event('{event}')); }})()"
    )


def test_the_table_sorts_filters_and_pages(page, tmp_path) -> None:
    table = fleet_example(60)
    opened(page, table, tmp_path)
    assert len(page.evaluate(ROWS)) == 50
    click_heading(page, "Fs")
    names = table.filter(pl.col("Fs").is_not_null()).sort("Fs")["log"].to_list()
    smallest = [name.removeprefix("logs/") for name in names]  # the folder of all logs is not repeated
    assert column(page, "log") == smallest[:50]
    click_heading(page, "Fs")
    assert column(page, "log") == smallest[::-1][:50]
    enter(page, "select[aria-label=Status]", "unreadable", "change")
    failed = table.filter(pl.col("status") == "unreadable").height
    assert column(page, "status") == ["unreadable"] * failed
    enter(page, "select[aria-label=Status]", "", "change")
    enter(page, "select[aria-label=Axis]", "emps", "change")
    assert set(column(page, "axis")) == {"emps"}
    assert "Ks" not in page.evaluate(HEADINGS)  # emps has no such parameter
    page.evaluate("document.querySelectorAll('.controls button')[1].click()")
    assert len(page.evaluate(ROWS)) == 10
    enter(page, ".controls input", "RUN_0007 stribeck", "input")
    assert page.evaluate("document.querySelector('.controls .count').textContent") in (
        "no log",
        "1–1 of 1 logs",
    )


def test_the_log_under_the_mouse_is_named(page, tmp_path) -> None:
    table = fleet_example(60)
    opened(page, table, tmp_path)
    box = page.evaluate(
        "(() => { const chart = document.querySelector('.chart'); chart.scrollIntoView(); const box ="
        " chart.getBoundingClientRect(), point = chart.querySelector('.runs').getAttribute('d').match(/[\\d.]+/g);"
        " const scale = box.width / chart.viewBox.baseVal.width;"
        " return [box.left + point[0] * scale, box.top + point[1] * scale]; })()"
    )
    page.send("Input.dispatchMouseEvent", type="mouseMoved", x=box[0], y=box[1])
    hint = page.evaluate("document.getElementById('hint').textContent")
    assert hint.split("\n")[0] in table["log"].to_list()


def test_a_chart_and_the_table_are_saved(page, tmp_path) -> None:
    table = fleet_example(30).with_columns(log=pl.concat_str(pl.lit("=1+"), "log"))
    opened(page, table, tmp_path)
    page.evaluate("URL.createObjectURL = blob => { window.saved = blob; return '#'; }")

    def saved(button: str) -> pl.DataFrame:
        page.evaluate(f"document.querySelector({button!r}).click()")
        return pl.read_csv(page.evaluate("saved.text()").encode())

    chart = saved(".chart + .save")
    name = chart.columns[2]
    assert chart.columns == ["log", "recorded", name, f"{name}_std", "level", "limit"]
    joined = chart.with_columns(pl.col("log").str.strip_prefix("'")).join(table, on="log", suffix="_true")
    assert joined.height == chart.height > 20
    assert (joined[name] / joined[f"{name}_true"] - 1).abs().max() < 1e-6
    assert ((joined[name] - joined["level"]).abs() < joined["limit"]).mean() > 0.9
    logs = saved(".controls button:last-child")
    assert logs.height == table.height
    assert logs["log"].str.starts_with("'=").all()  # no formula
    assert {"M", "M_std", "status"} <= set(logs.columns)


def test_five_thousand_logs_open_in_less_than_five_seconds(page, tmp_path) -> None:
    """The bound is that of use, several times what it takes."""
    file = tmp_path / "fleet.html"
    write_fleet_html(review_fleet(fleet_example(1667)), file)
    begin = time.monotonic()
    page.open(file)
    assert len(page.evaluate(ROWS)) == 50
    assert time.monotonic() - begin < 5.0


PAPER = "getComputedStyle(document.body).backgroundColor"
TEXTS = (
    "h1",
    ".note",
    ".tag",
    ".change",
    ".rows td",
    "summary .count",
    ".figures dt",
    "thead th",
    "footer",
    ".count",
)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_stands_out_from_the_page(scheme, page, tmp_path) -> None:
    page.prefer(scheme)
    opened(page, fleet_example(30), tmp_path)
    assert min(page.contrasts(*TEXTS).values()) > 4.5
    assert page.evaluate(PAPER) == {"light": "rgb(255, 255, 255)", "dark": "rgb(23, 23, 23)"}[scheme]


def test_print_is_light(page, tmp_path) -> None:
    page.prefer("dark", "print")
    opened(page, fleet_example(30), tmp_path)
    assert page.evaluate(PAPER) == "rgb(255, 255, 255)"
    assert min(page.contrasts("h1", ".note", ".tag").values()) > 4.5


def test_hostile_names_run_nothing(page, tmp_path) -> None:
    table = fleet_example(30).with_columns(log=pl.lit(HOSTILE) + pl.col("log"), message=pl.lit(HOSTILE))
    opened(page, table, tmp_path)
    assert page.evaluate("typeof window.hostile") == "undefined"
    assert page.evaluate("document.querySelector('.rows td').title").startswith(HOSTILE)
    assert column(page, "message")[0] == HOSTILE


LABELS = """
[...document.querySelectorAll('svg.chart')].map(chart => [...chart.querySelectorAll('text')]
  .filter(text => getComputedStyle(text).display !== 'none')
  .map(text => text.getBoundingClientRect()).map(r => [r.left, r.right, r.top, r.bottom]))
"""


@pytest.mark.parametrize("width", [400, 1200])
def test_labels_of_charts_are_readable_and_apart(width, page, tmp_path) -> None:
    page.renew(width, 900)
    opened(page, fleet_example(), tmp_path)
    charts = [labels for labels in page.evaluate(LABELS) if labels and labels[0][1]]
    assert charts
    for labels in charts:
        assert min(bottom - top for _, _, top, bottom in labels) > 11
        assert min(left for left, *_ in labels) > 0
        assert max(right for _, right, *_ in labels) < width
        for i, (left, right, top, bottom) in enumerate(labels):
            for other in labels[:i]:
                assert right < other[0] or left > other[1] or bottom < other[2] or top > other[3]
