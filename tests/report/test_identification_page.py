"""The page of an identification: numbers against those computed by hand, and what it says of itself."""

import hashlib
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from command_line import run

import symid
from symid.estimation.least_squares import fit_percent
from symid.report.figures.residual_correlation import (
    PredictedOutput,
    correlation,
    residual_correlations,
)
from symid.report.pages.identification_page import write_identification_html


def recording(file: Path, noise: np.ndarray | float = 0.0) -> None:
    t = np.arange(6000) / 1000
    q = 0.1 * np.sin(9 * t) + 0.02 * np.sin(23 * t)
    v, a = 0.9 * np.cos(9 * t) + 0.46 * np.cos(23 * t), -8.1 * np.sin(9 * t) - 10.58 * np.sin(23 * t)
    pl.DataFrame({"t": t, "q": q, "F": 5 * a + 3 * v + 2 * np.sign(v) + noise}).write_csv(file)


class Page(HTMLParser):
    """Tags, ids and text of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids, self.tags, self.text, self.links = [], [], "", []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.tags.append(tag)
        if "id" in given:
            self.ids.append(given["id"])
        if tag == "a":
            self.links.append(given["href"])

    def handle_data(self, data: str) -> None:
        self.text += data


def test_the_page_of_the_command(folder: Path) -> None:
    rng = np.random.default_rng(0)
    recording(Path("a.csv"), 0.5 * rng.standard_normal(6000))
    recording(Path("b<.csv"), 0.5 * rng.standard_normal(6000))
    assert run("identify", "rigid_1m", "a.csv", "--validation", "b<.csv", "--report", "p.html") == 0
    text = Path("p.html").read_text(encoding="utf-8")
    page = Page(text)
    assert len(page.ids) == len(set(page.ids))
    assert page.tags.count("main") == 1
    assert {link[1:] for link in page.links if not link.startswith("data:text/csv")} <= set(page.ids)
    assert not re.search(r'(src|href)="(?!#|data:)', text.replace("xlink:", ""))
    for file in ("a.csv", "b<.csv"):
        assert hashlib.sha256(Path(file).read_bytes()).hexdigest() in page.text
    assert f"symid {symid.__version__}, Python" in page.text
    assert "b<.csv (validation)" in page.text
    for section in (
        "Parameters",
        "Correlations of the parameters",
        "Correlation of the residual",
        "Settings",
    ):
        assert section in page.text


@pytest.mark.usefixtures("plain_pages")
def test_numbers_of_the_page(tmp_path: Path) -> None:
    recording(tmp_path / "a.csv", 0.5 * np.random.default_rng(0).standard_normal(6000))
    log = symid.read_axis_log("rigid_1m", tmp_path / "a.csv")
    found = symid.identify("rigid_1m", log)
    write_identification_html(found, tmp_path / "p.html", axis=symid.load_axis("rigid_1m"), runs=[log])
    text = Page((tmp_path / "p.html").read_text(encoding="utf-8")).text
    (run_,) = found.observations
    y = run_.y[0][run_.valid[0]]
    error = y - run_.W[0][run_.valid[0]] @ found.fit.solution
    fit = 100 * (1 - np.sqrt(np.sum(error**2) / np.sum((y - np.mean(y)) ** 2)))
    assert f"{fit:.4g} %" in text
    covariance = found.physical[0].propagated(found.covariance)
    rho = covariance[1, 2] / np.sqrt(covariance[1, 1] * covariance[2, 2])
    assert f"{rho:.2f}" in text


def test_a_white_residual_stays_in_the_band_and_a_coloured_one_leaves_it() -> None:
    rng = np.random.default_rng(3)
    white, used = rng.standard_normal(20_000), rng.random(20_000) < 0.7
    whole = correlation(white, white, used, range(41))
    assert whole.outside < 0.05
    coloured = np.convolve(white, np.ones(5) / 5, mode="same")
    found = correlation(coloured, coloured, np.ones(20_000, bool), range(41))
    assert found.outside > 0.08
    np.testing.assert_allclose(found.value[:5], [1.0, 0.8, 0.6, 0.4, 0.2], atol=0.03)


def test_the_cross_correlation_finds_the_lag() -> None:
    x = np.random.default_rng(4).standard_normal(5000)
    late = np.roll(x, 7)
    found = correlation(late, x, np.ones(5000, bool), range(-20, 21))
    assert found.lag[np.argmax(found.value)] == 7


def test_friction_that_the_model_lacks_is_remembered(tmp_path: Path) -> None:
    t = np.arange(6000) / 1000
    recording(tmp_path / "a.csv", 4.0 * np.sin(40 * t) + 0.1 * np.random.default_rng(0).standard_normal(6000))
    settings = symid.Preparation(cutoff_hz=60.0)
    found = symid.identify("rigid_1m", tmp_path / "a.csv", preparation=settings)
    (run,) = found.observations
    output = PredictedOutput("F", "a.csv", "N", run.y[0], run.W[0] @ found.fit.solution, run.valid[0])
    ((_, own, _),) = residual_correlations([output])
    assert own.outside > 0.5


def test_fit_of_the_mean_is_none() -> None:
    y = np.array([1.0, 2.0, 4.0])
    assert fit_percent(y, y) == 100.0
    assert fit_percent(y, np.full(3, y.mean())) == pytest.approx(0.0)


def test_a_page_that_cannot_be_written_is_refused_first(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recording(Path("a.csv"))
    assert run("identify", "rigid_1m", "a.csv", "--report", "p.txt") == 2
    assert "p.txt" in capsys.readouterr().err


@pytest.mark.usefixtures("plain_pages")
def test_numbers_of_the_page_of_output_error(tmp_path: Path) -> None:
    recording(tmp_path / "a.csv")
    frame = pl.read_csv(tmp_path / "a.csv")[::5]
    noise = 1e-6 * np.random.default_rng(5).standard_normal(frame.height)
    found = symid.identify("rigid_1m", frame.with_columns(pl.col("q") + noise), method="oe")
    found.report(tmp_path / "p.html")
    page = Page((tmp_path / "p.html").read_text(encoding="utf-8"))
    assert len(set(page.ids)) == len(page.ids)
    (one,) = found.predictions
    used = np.isfinite(one.innovations[:, 0])
    rms = np.sqrt(np.mean(one.innovations[used, 0] ** 2))
    assert f"{rms:.4g} m rms over {used.sum()} rows" in page.text
    covariance = found.physical_covariance(corrected=True)
    assert f"{covariance[1, 2] / np.sqrt(covariance[1, 1] * covariance[2, 2]):.2f}" in page.text
    assert "Each sample is predicted from those before it" in page.text
    assert "output error, by maximum likelihood" in page.text
