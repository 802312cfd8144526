"""The pages by axe-core in a real browser, on a desk and on a phone, in light and dark: nothing is complained of."""

from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from browser import Page
from diagnosis_example import diagnosis_example
from fleet_example import fleet_example

from symid import Log, identify, load_axis
from symid.fleet import review_fleet
from symid.report.pages.comparison_page import write_comparison_html
from symid.report.pages.diagnosis_page import write_diagnosis_html
from symid.report.pages.fleet_page import write_fleet_html
from symid.report.pages.identification_page import write_identification_html
from symid.report.tables.result_comparison import comparison_record, values_of_record

pytestmark = pytest.mark.browser

AXE = files("axe_core_python").joinpath("axe.min.js").read_text(encoding="utf-8")
VIOLATIONS = """
axe.run(document, {resultTypes: ["violations"]})
  .then(found => found.violations.map(one => `${one.id}: ${one.nodes[0].html}`))
"""


def identification_page(file: Path) -> None:
    t = np.arange(3000) / 1000
    q = 0.1 * np.sin(9 * t) + 0.02 * np.sin(23 * t)
    v, a = 0.9 * np.cos(9 * t) + 0.46 * np.cos(23 * t), -8.1 * np.sin(9 * t) - 10.58 * np.sin(23 * t)
    log = Log.from_frame(pl.DataFrame({"t": t, "q": q, "F": 5 * a + 3 * v + 2 * np.sign(v)}))
    write_identification_html(identify(load_axis("rigid_1m"), log), file)


def comparison_page(file: Path) -> None:
    values = (
        values_of_record({"M": {"value": m, "std": 0.1}, "Fv": {"value": 1.0, "std": 0.3}}, f"{m}")
        for m in (4, 5)
    )
    write_comparison_html(comparison_record(*values), file)


PAGES: dict[str, Callable[[Path], object]] = {
    "diagnosis": lambda file: write_diagnosis_html(diagnosis_example(), file),
    "fleet": lambda file: write_fleet_html(review_fleet(fleet_example()), file),
    "identification": identification_page,
    "comparison": comparison_page,
    "axis": lambda file: load_axis("direct_3m2s").report(file),
}


@pytest.mark.parametrize("name", PAGES)
def test_axe_finds_nothing(name: str, page: Page, tmp_path: Path) -> None:
    file = tmp_path / "page.html"
    PAGES[name](file)
    page.resize(400, 800)
    page.prefer("dark")
    page.open(file)
    page.send("Runtime.evaluate", expression=AXE)
    for width, scheme in ((400, "dark"), (1280, "light")):
        page.resize(width, 800)
        page.prefer(scheme)
        assert page.evaluate(VIOLATIONS) == []
        assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_a_fault_would_be_found(page: Page, tmp_path: Path) -> None:
    file = tmp_path / "page.html"
    file.write_text("<html><body><main><img src='data:,'></main></body></html>", encoding="utf-8")
    page.open(file)
    page.send("Runtime.evaluate", expression=AXE)
    assert any(found.startswith("image-alt") for found in page.evaluate(VIOLATIONS))
