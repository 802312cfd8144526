"""Clocks of foreign files that jitter, have gaps, or are called by their unit alone."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import run
from recorded_run import TRUE, table

from symid.data import Log


def uneven(log: Log, jitter: float, lost: int) -> dict[str, np.ndarray]:
    """The run, read by lines at times that are off by up to a share of a step, some of them lost."""
    rng = np.random.default_rng(3)
    inner = np.sort(rng.choice(np.arange(1, log.n_samples - 1), log.n_samples - 2 - lost, replace=False))
    t = (inner + jitter * rng.uniform(-1, 1, inner.size)) * log.sampling_period
    return {"t": t, "q": np.interp(t, log.time, log["q"]), "F": np.interp(t, log.time, log["F"])}


@pytest.mark.parametrize(
    ("name", "per_second", "jitter", "lost", "unit"),
    [
        ("clk", 1.0, 0.1, 0, "s"),
        ("sampled at", 1e3, 0.45, 0, "ms"),
        ("micros", 1e6, 0.3, 20, "us"),
        ("elapsed", 1.0, 0.05, 20, "s"),
    ],
)
def test_a_clock_that_jitters_is_recognised_and_resampled(
    name: str,
    per_second: float,
    jitter: float,
    lost: int,
    unit: str,
    recorded: Log,
    folder: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    seen = uneven(recorded, jitter, lost)
    columns = {name: per_second * seen["t"], "pos [mm]": 1e3 * seen["q"], "force [N]": seen["F"]}
    (folder / "a.csv").write_text(table(columns, ","), encoding="utf-8")
    assert run("import", "a.csv", "--axis", "rigid_1m", "-o", "map.json") == 0
    out = " ".join(capsys.readouterr().out.split())
    assert f"t is column '{name}' in {unit}" in out
    assert "Sampling: t " in out
    assert out.endswith("symid identify rigid_1m a.csv --mapping map.json --resample own")
    options = ["--mapping", "map.json", "--resample", "own", "--held", "F", "--json", "out.json"]
    assert run("identify", "rigid_1m", "a.csv", *options) == 0
    found = json.loads((folder / "out.json").read_text())["physical"]
    assert found["M"]["value"] == pytest.approx(TRUE["M"], rel=2e-2)


def test_a_named_clock_is_taken_before_another_column_that_rises(recorded: Log, folder: Path) -> None:
    seen = uneven(recorded, 0.2, 0)
    columns = {
        "c1": 7 * seen["t"],
        "timestamp": seen["t"],
        "pos [mm]": 1e3 * seen["q"],
        "force [N]": seen["F"],
    }
    (folder / "a.csv").write_text(table(columns, ","), encoding="utf-8")
    assert run("import", "a.csv", "--axis", "rigid_1m", "-o", "map.json") == 0
    assert json.loads((folder / "map.json").read_text())["columns"]["t"] == "timestamp"


def test_numbers_of_samples_with_gaps_are_no_clock(
    recorded: Log, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    kept = np.arange(recorded.n_samples) % 97 != 5
    columns = {
        "k": np.arange(recorded.n_samples)[kept],
        "pos [mm]": 1e3 * recorded["q"][kept],
        "force [N]": recorded["F"][kept],
    }
    (folder / "a.csv").write_text(table(columns, ","), encoding="utf-8")
    assert run("import", "a.csv", "--axis", "rigid_1m") == 0
    assert "'k' may be it, it rises by 1: numbers of samples, or ms" in " ".join(
        capsys.readouterr().out.split()
    )


@pytest.mark.parametrize("lacking", ["every other row", "the first rows"])
def test_a_channel_that_lacks_values_is_resampled(
    lacking: str, recorded: Log, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    row = np.arange(recorded.n_samples)
    force = np.where(row % 2 if lacking == "every other row" else row < 50, np.nan, recorded["F"])
    columns = {"t [s]": recorded.time, "pos [mm]": 1e3 * recorded["q"], "force [N]": force}
    (folder / "a.csv").write_text(table(columns, ",").replace("nan", ""), encoding="utf-8")
    assert run("import", "a.csv", "--axis", "rigid_1m", "-o", "map.json") == 0
    out = capsys.readouterr().out
    assert "Sampling: 'F' has" in out
    assert out.rstrip().endswith("--mapping map.json --resample own")
    assert run("identify", "rigid_1m", "a.csv", "--mapping", "map.json") == 2
    assert "or give --resample own" in capsys.readouterr().err
    options = ["--mapping", "map.json", "--resample", "own", "--held", "F", "--json", "out.json"]
    assert run("identify", "rigid_1m", "a.csv", *options) == 0
    found = json.loads((folder / "out.json").read_text())["physical"]
    assert found["M"]["value"] == pytest.approx(TRUE["M"], rel=2e-2)


@pytest.mark.parametrize("resample", [[], ["--resample", "own"]])
def test_a_counter_that_overflows_is_continued(resample: list[str], recorded: Log, folder: Path) -> None:
    count = 2e-6
    counts = np.round(recorded["q"] / count) % 2**16
    columns = {"t [s]": recorded.time, "enc [counts]": counts, "force [N]": recorded["F"]}
    (folder / "a.csv").write_text(table(columns, ","), encoding="utf-8")
    given = ["--unit", f"q={1 / count:g} counts/m"]
    assert run("import", "a.csv", "--axis", "rigid_1m", "-o", "map.json", *given) == 0
    options = ["--mapping", "map.json", "--held", "F", "--json", "out.json", *resample]
    assert run("identify", "rigid_1m", "a.csv", *options) == 0
    record = json.loads((folder / "out.json").read_text())
    assert any("after 65536 steps: it is unwrapped" in note for note in record["notes"])
    assert record["physical"]["M"]["value"] == pytest.approx(TRUE["M"], rel=2e-2)


def test_a_clock_that_overflows_is_continued(recorded: Log, folder: Path) -> None:
    ticks = np.round(1e6 * recorded.time + 60_000) % 2**16
    columns = {"time_us": ticks, "pos [m]": recorded["q"], "force [N]": recorded["F"]}
    (folder / "a.csv").write_text(table(columns, ","), encoding="utf-8")
    assert run("import", "a.csv", "--axis", "rigid_1m", "-o", "map.json") == 0
    assert (
        run("identify", "rigid_1m", "a.csv", "--mapping", "map.json", "--held", "F", "--json", "out.json")
        == 0
    )
    record = json.loads((folder / "out.json").read_text())
    assert any("times after 65536: it is unwrapped" in note for note in record["notes"])
    assert record["physical"]["M"]["value"] == pytest.approx(TRUE["M"], rel=2e-2)
