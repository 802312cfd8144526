"""Logs that are longer than memory: the same values, the same clock and the same faults as if read at once."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from symid.data import AnyLog, Log, LongLog, open_log, read_log
from symid.errors import LogError
from symid.units import Unit

EXPECTED = {"q": Unit.of("m"), "F": Unit.of("N")}
N = 5003
Columns = dict[str, np.ndarray]


def columns() -> Columns:
    t = np.arange(N) / 250.0
    return {"t": 3.0 + t, "q [mm]": 1e3 * np.sin(t), "F": np.cos(3 * t)}


def written(folder: Path, kind: str, values: Columns) -> Path:
    file = folder / f"log.{kind}"
    if kind == "csv":
        pl.DataFrame(values).write_csv(file)
    else:
        pl.DataFrame(values).write_parquet(file, row_group_size=700)
    return file


def opened(file: Path) -> AnyLog:
    return open_log(file, expected=EXPECTED, memory=1000, block=600)


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symid.data.text_files.csv_table._CHUNK", 5000)


@pytest.mark.parametrize("kind", ["csv", "parquet"])
@pytest.mark.parametrize("window", [(0, N), (0, 1), (698, 703), (1234, 4321), (N - 1, N)])
def test_windows_hold_what_the_whole_file_holds(tmp_path: Path, kind: str, window: tuple[int, int]) -> None:
    file = written(tmp_path, kind, columns())
    whole, long = read_log(file, expected=EXPECTED), opened(file)
    assert isinstance(long, LongLog)
    assert (long.start, long.sampling_period, long.n_samples) == (whole.start, whole.sampling_period, N)
    for name in ("q", "F"):
        np.testing.assert_array_equal(long.window(*window)[name], whole.window(*window)[name])


def test_a_log_that_fits_is_read_at_once(tmp_path: Path) -> None:
    assert isinstance(open_log(written(tmp_path, "csv", columns()), expected=EXPECTED), Log)


def test_blank_lines_at_the_end_and_other_separators(tmp_path: Path) -> None:
    file = written(tmp_path, "csv", columns())
    text = file.read_text().replace(",", ";").replace(".", ",")
    file.write_text(text.rstrip("\n") + "\r\n\n\n")
    assert opened(file).n_samples == N


def nan(values: Columns) -> None:
    values["F"][4000] = np.nan


def backward(values: Columns) -> None:
    values["t"][3000:] -= 0.01


def repeated(values: Columns) -> None:
    values["t"][3001] = values["t"][3000]


def gap(values: Columns) -> None:
    values["t"][555:] += 1.0  # between two blocks


def constant(values: Columns) -> None:
    values["F"][:] = 4.0


def infinite_time(values: Columns) -> None:
    values["t"][2000] = np.inf


@pytest.mark.parametrize("kind", ["csv", "parquet"])
@pytest.mark.parametrize("damage", [nan, backward, repeated, gap, constant, infinite_time])
def test_the_first_fault_is_that_of_the_whole_file(
    tmp_path: Path, kind: str, damage: Callable[[Columns], None]
) -> None:
    values = columns()
    damage(values)
    file = written(tmp_path, kind, values)
    with pytest.raises(LogError) as whole:
        read_log(file, expected=EXPECTED)
    with pytest.raises(LogError) as long:
        opened(file)
    rows = [re.findall(r"row (\d+)", str(error.value)) for error in (whole, long)]
    assert rows[0] == rows[1]
    assert str(long.value).startswith(f"{file}: ")
    kinds = ("empty", "backwards", "repeated", "gap", "constant", "no possible time")
    assert [k for k in kinds if k in str(whole.value)] == [k for k in kinds if k in str(long.value)]


def test_a_clock_that_changes_from_one_block_to_the_next(tmp_path: Path) -> None:
    values = columns()
    values["t"] = np.cumsum(np.where(np.arange(N) < 1112, 0.004, 0.005))
    with pytest.raises(LogError, match="changes its sampling period"):
        opened(written(tmp_path, "parquet", values))


def test_text_in_a_late_row_is_named_by_its_row(tmp_path: Path) -> None:
    file = written(tmp_path, "csv", columns())
    lines = file.read_text().split("\n")
    lines[4000] = "1,hello,3"
    file.write_text("\n".join(lines))
    with pytest.raises(LogError, match="'hello' in row 4000 where a number is required"):
        opened(file)
