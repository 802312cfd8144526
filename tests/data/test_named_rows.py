"""Rows that each hold a time, the name of a signal and its value, as databases and brokers export them."""

import json
from pathlib import Path

import numpy as np
import pytest

from symid.data import foreign_columns, open_table
from symid.data.formats import layout_found
from symid.errors import LogError

N = 60
STAMPS = 1_760_000_000_000 + np.arange(N)  # ms
Q, F = np.round(200 * np.sin(np.arange(N) / 9), 4), np.round(50 * np.cos(np.arange(N) / 9), 4)
SIGNALS = {"axis/position_mm": Q, "axis/force_N": F}


def in_turn() -> list[tuple[int, str, float]]:
    return [(int(t), name, float(x[k])) for k, t in enumerate(STAMPS) for name, x in SIGNALS.items()]


def csv(path: Path) -> Path:
    rows = [f"{t};RUN;{name};{x:g}".replace(".", ",") for t, name, x in in_turn()]
    path.write_text("\n".join(["ts;state;tag;value", *rows]))
    return path


def annotated(path: Path) -> Path:
    """One signal below the other, with lines of types above each, as InfluxDB writes them."""
    head = "#datatype,long,dateTime:RFC3339,dateTime:RFC3339,double,string\n#default,,,,,\n"
    head += ",table,_start,_time,_value,_field"
    blocks = [head + "\n"]
    for name, x in SIGNALS.items():
        stamps = (f"2026-11-21T10:00:{t % 60_000 / 1e3:06.3f}Z" for t in STAMPS)
        rows = (f",0,2026-11-21T00:00:00Z,{t},{v:g},{name}" for t, v in zip(stamps, x, strict=True))
        blocks += ["\n".join(rows), "\n" + head + "\n"]
    path.write_text("".join(blocks[:-1]))
    return path


def lines(path: Path) -> Path:
    path.write_text("\n".join(json.dumps({"ts": t, "topic": name, "value": x}) for t, name, x in in_turn()))
    return path


@pytest.mark.parametrize(
    ("write", "name"), [(csv, "a.csv"), (csv, "a.txt"), (annotated, "a.csv"), (lines, "a.jsonl")]
)
def test_each_name_is_a_column_with_the_times_of_its_rows(write, name: str, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]  # one of three functions
    path = write(tmp_path / name)
    table = open_table(path, layout_found(path))
    assert table.headers == (*SIGNALS, "t")
    assert [(c.quantity, c.unit) for c in foreign_columns(table)][:2] == [("position", "mm"), ("force", "N")]
    position, force, time = (np.asarray(column) for column in table.read(range(3)))
    assert position == pytest.approx(Q, abs=1e-3)
    assert force == pytest.approx(F, abs=1e-3)
    assert time == pytest.approx(1e-3 * np.arange(N), abs=1e-9)


def test_a_column_of_words_beside_a_value_of_one_signal_stays_a_column(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rows = [f"{k / 1e3:.3f},{k % 2},{x:g}" for k, x in enumerate(Q)]
    path.write_text("\n".join(["time [s],channel,value", *rows]))
    assert open_table(path, layout_found(path)).headers == ("time [s]", "channel", "value")


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([("0.1", "a", None)] * 9, "has no values of them"),
        ([(k, f"n{k % 99}", 1.5) for k in range(999)], "has rows of 99 signals"),
        ([(5, "a", 1.5)] * 99, "have no known unit"),
        ([("soon", "a", 1.5)] * 99, "holds texts such as 'soon'"),
    ],
)
def test_rows_that_make_no_signals_are_one_line(rows: list[tuple], said: str, tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps([dict(zip(("ts", "tag", "value"), row, strict=True)) for row in rows]))
    with pytest.raises(LogError, match=said):
        open_table(path)
