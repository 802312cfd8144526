"""Clocks that jitter, lack samples, or are faster than is wanted: against the signals themselves."""

from pathlib import Path

import numpy as np
import polars as pl
import pytest
from command_line import run

from symid.data import read_log
from symid.data.resampling import resampled
from symid.errors import LogError
from symid.units import Unit

EXPECTED = {"q": Unit.of("m"), "F": Unit.of("N")}
RATE = 1000.0


def signals(t: np.ndarray) -> dict[str, np.ndarray]:
    return {"q": 0.1 * np.sin(20 * t) + 0.02 * np.sin(90 * t), "F": 40 * np.cos(20 * t) + 7 * np.sin(130 * t)}


def jittered(share: float, seconds: float = 4.0) -> np.ndarray:
    regular = np.arange(int(seconds * RATE)) / RATE
    return regular + share / RATE * np.random.default_rng(0).uniform(-1, 1, regular.size)


def read(t: np.ndarray, tmp_path: Path, resample: float | str | None = "own", **replaced: np.ndarray):
    pl.DataFrame({"t": t, **signals(t), **replaced}).write_parquet(tmp_path / "a.parquet")
    return read_log(tmp_path / "a.parquet", expected=EXPECTED, resample=resample)


def errors(log) -> dict[str, float]:
    """Relative to the peak, the ends left out."""
    inner = slice(50, -50)
    return {
        name: float(np.max(np.abs(log[name] - x)[inner]) / np.max(np.abs(x)))
        for name, x in signals(log.time).items()
    }


def test_jitter_of_a_third_is_taken_out(tmp_path: Path) -> None:
    t = jittered(0.3)
    with pytest.raises(LogError, match=r"jitters .* give `resample=own`"):
        read(t, tmp_path, None)
    log = read(t, tmp_path)
    assert max(errors(log).values()) < 1e-4
    assert log.sampling_frequency == pytest.approx(RATE, rel=0.02)
    assert any("jittered by" in note for note in log.notes)


def test_short_gaps_are_filled_and_reported_and_long_ones_refused(tmp_path: Path) -> None:
    t = np.arange(4000) / RATE
    short = np.delete(t, [700, 701, 702, 2000])
    with pytest.raises(LogError, match="gap"):
        read(short, tmp_path, None)
    log = read(short, tmp_path)
    assert log.n_samples == 4000
    assert max(errors(log).values()) < 1e-4
    assert any("4 missing samples were filled, after t = 0.699 s, 1.999 s" in note for note in log.notes)
    with pytest.raises(LogError, match=r"has 11 missing samples after t = 0\.699 s"):
        read(np.delete(t, range(700, 711)), tmp_path)


def test_values_that_lack_are_filled(tmp_path: Path) -> None:
    t = np.arange(4000) / RATE
    holes = signals(t)["q"]
    holes[[100, 101, 3000]] = np.nan
    log = read(t, tmp_path, q=holes)
    assert max(errors(log).values()) < 1e-4


def test_a_lower_rate_holds_no_images(tmp_path: Path) -> None:
    t = np.arange(8000) / RATE
    loud = signals(t)["F"] + 20 * np.sin(2 * np.pi * 380 * t)  # 380 Hz would appear at 20 Hz
    log = read(t, tmp_path, 200.0, F=loud)
    assert log.sampling_frequency == pytest.approx(200.0)
    assert max(errors(log).values()) < 2e-3
    assert any("low-pass at 80 Hz" in note for note in log.notes)


def test_counts_of_an_encoder_are_no_jumps(tmp_path: Path) -> None:
    t = jittered(0.2)
    slow = np.round(1e-4 * t / 2e-5) * 2e-5  # steps of one count, far apart
    log = read(t, tmp_path, q=slow)
    assert np.max(np.abs(log["q"] - 1e-4 * log.time)) < 2e-5


def test_a_jump_stays_a_fault(tmp_path: Path) -> None:
    t = jittered(0.2)
    broken = signals(t)["q"] + np.where(t > 2.0, 0.5, 0.0)
    with pytest.raises(LogError, match="'q' jumps by"):
        read(t, tmp_path, q=broken)


@pytest.mark.parametrize(
    ("rate", "says"),
    [
        (0.0, "positive"),
        (float("nan"), "positive"),
        (1.0, "are required"),
        (1e11, "are required"),
        (2 * RATE, "above the"),
    ],
)
def test_rates_that_are_none(rate: float, says: str, tmp_path: Path) -> None:
    with pytest.raises(LogError, match=says):
        read(np.arange(4000) / RATE, tmp_path, rate)


def test_times_must_advance() -> None:
    t = np.arange(100) / RATE
    t[50] = t[49] - 1e-4
    with pytest.raises(LogError, match="goes back or stops at t"):
        resampled({"q": np.sin(t)}, {"q": t}, "own")


def test_on_the_command_line(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    t = jittered(0.3)
    v, a = 1.6 * np.cos(20 * t), -32 * np.sin(20 * t)
    q = 0.08 * np.sin(20 * t)
    pl.DataFrame({"t": t, "q": q, "F": 5 * a + 3 * v + 0.0 * t}).write_csv("a.csv")
    assert run("identify", "rigid_1m", "a.csv") == 2
    assert "--resample own" in capsys.readouterr().err
    assert run("identify", "rigid_1m", "a.csv", "--resample", "own") == 0
    printed = capsys.readouterr().out
    assert "resampled to" in printed
    assert run("identify", "rigid_1m", "a.csv", "--resample", "-3") == 2
    assert run("batch", "rigid_1m", "a.csv", "-o", "r.parquet", "--resample", "500", "--jobs", "1") == 0
    (row,) = pl.read_parquet("r.parquet").iter_rows(named=True)
    assert row["M"] == pytest.approx(5.0, rel=1e-2)


def test_times_in_whole_milliseconds_lack_nothing(tmp_path: Path) -> None:
    t = np.round(np.arange(1200) * 7 / 3) / 1000  # steps of 2, 2 and 3 ms
    log = read(t, tmp_path)
    assert log.sampling_frequency == pytest.approx(3000 / 7, rel=1e-3)
    assert not any("lacked" in note for note in log.notes)


def test_samples_of_the_fastest_clock_are_kept_where_another_begins_later(tmp_path: Path) -> None:
    t = np.arange(400) / RATE
    steps = np.repeat([0.0, 1.0], 200)
    clocks = {"F": t, "q": t, "reference": t + 0.3 / RATE}
    found, _ = resampled({"F": steps, "q": t, "reference": t}, clocks, "own")
    assert found["F"] == pytest.approx(steps[1:], abs=1e-9)
    assert found["t"] == pytest.approx(t[1:], abs=1e-9)


def test_rounding_of_seconds_from_1970_is_no_jitter() -> None:
    t = np.arange(400) / RATE
    found, _ = resampled({"q": np.sign(np.sin(300 * t))}, {"q": 1.76e9 + t}, "own")
    assert found["q"] == pytest.approx(np.sign(np.sin(300 * t)), abs=2e-5)


@pytest.mark.parametrize("resample", [None, "own"])
def test_a_commanded_position_without_values_is_left_out(resample: str | None, tmp_path: Path) -> None:
    t = np.arange(400) / RATE
    pl.DataFrame({"t": t, **signals(t), "set": np.full(400, np.nan)}).write_parquet(tmp_path / "a.parquet")
    log = read_log(tmp_path / "a.parquet", expected=EXPECTED, columns={"reference": "set"}, resample=resample)
    assert set(log.signals) == {"q", "F"}
    assert any("'reference' has missing values" in note for note in log.notes)
