"""What the page of a diagnosis says of the memory of its error, and of how it was made."""

import hashlib
import re
from pathlib import Path

import numpy as np
import pytest
from command_line import run
from hand_made import rigid_log
from scipy.signal import lfilter

import symid
from symid.data import write_log
from symid.diagnosis import diagnose
from symid.diagnosis.effects import DelayEffect
from symid.report.figures.residual_correlation import correlation
from symid.report.pages.diagnosis_page import write_diagnosis_html
from symid.report.tables.number_text import interval_end


def outside(page: str) -> tuple[int, int]:
    """Per cent of both correlations outside their bands, as a page says."""
    found = re.search(r"(\d+) % of the auto-correlation and (\d+) % of the cross-correlation", page)
    return int(found[1]), int(found[2])


@pytest.mark.parametrize(("wave", "low", "high"), [(0.0, 0, 5), (4.0, 50, 100)])
def test_noise_stays_in_the_bands_and_a_force_of_time_leaves_them(
    wave: float, low: int, high: int, tmp_path: Path
) -> None:
    log = rigid_log(lambda t, *_: wave * np.sin(30 * t), seconds=12.0)
    found = diagnose(symid.load_axis("rigid_1m"), log, library=(DelayEffect(),))
    write_diagnosis_html(found, tmp_path / "p.html")
    page = (tmp_path / "p.html").read_text(encoding="utf-8")
    own, across = outside(page)
    assert low <= own <= high
    # the band of the cross-correlation is that of noise: a wave may resemble the prediction by chance
    assert across <= 5 or wave


def test_99_per_cent_of_coloured_noise_lie_in_the_band() -> None:
    rng = np.random.default_rng(5)
    taps, n, lags = np.array([1.0, 0.6]), 1500, range(21)
    noise = np.zeros(41)
    noise[:2] = 1.0, 0.6 / 1.36  # of a moving average of two
    own, across = [], []
    for _ in range(100):
        x = lfilter(taps, 1.0, rng.standard_normal(n))
        y = lfilter([1.0], [1.0, -0.9], rng.standard_normal(n))  # knows nothing of x
        for other, places, found in ((x, lags, own), (y, range(-20, 21), across)):
            found.append(correlation(x, other, np.ones(n, bool), places, noise).outside)
    assert 0.002 < np.mean(own) < 0.02
    assert 0.002 < np.mean(across) < 0.02


@pytest.mark.usefixtures("plain_pages")
def test_the_page_says_how_it_was_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for seed in (1, 2):
        write_log(rigid_log(seed=seed), Path(f"run {seed}.csv"))
    command = ("diagnose", "rigid_1m", "run 1.csv", "--validation", "run 2.csv", "--late", "F=200us")
    monkeypatch.setattr("sys.argv", ["symid", *command, "--report", "p.html"])
    assert run(*command, "--report", "p.html") == 0
    page = Path("p.html").read_text(encoding="utf-8")
    for seed in (1, 2):
        assert hashlib.sha256(Path(f"run {seed}.csv").read_bytes()).hexdigest() in page
    assert "symid diagnose rigid_1m &#39;run 1.csv&#39; --validation" in page
    assert f"symid {symid.__version__}, Python" in page
    assert f"NumPy {np.__version__}" in page
    assert re.search(r"recorded late</th><td[^>]*>F 200 us", page)


def test_ends_of_an_interval_have_the_digits_of_the_deviation() -> None:
    ends = [interval_end(120.004, 0.0031, side) for side in (-2.0, 2.0)]
    assert ends == ["119.9978", "120.0102"]
    assert interval_end(22140.0, 614.2, -2.0) == "20912"
    assert interval_end(2.0, 0.0, 2.0) == "2"
