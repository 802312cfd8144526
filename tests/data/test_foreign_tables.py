"""Tables of foreign programs: clocks of their own, rows that repeat or end early, texts and structs as columns."""

import datetime
import gzip
import json
from pathlib import Path

import h5py
import numpy as np
import polars as pl
import pytest

from symid.data import foreign_columns, open_table, read_log
from symid.data.formats import layout_found
from symid.errors import LogError
from symid.units import Unit

N = 200
T = 1e-3 * np.arange(N)
Q, F = 0.2 * np.sin(30 * T), 50 * np.cos(30 * T)
EXPECTED = {"q": Unit.of("m"), "F": Unit.of("N")}


def test_a_column_of_times_before_each_channel_is_its_clock(tmp_path: Path) -> None:
    late = 0.25 + 1e3 * T[::4]
    rows = [f"{1e3 * t:.2f};{q:.9f};;" for t, q in zip(T, Q, strict=True)]
    for k, (t, f) in enumerate(zip(late, F[::4], strict=True)):
        rows[k] = f"{rows[k][:-1]}{t:.2f};{f:.6f}"
    path = tmp_path / "pairs.csv"
    path.write_text("Zeit [ms];q;Zeit 2 [ms];F\n" + "\n".join(rows) + "\n")
    with pytest.raises(LogError, match="'F' has other times than 'q'"):
        read_log(path, expected=EXPECTED, layout=layout_found(path))
    log = read_log(path, expected=EXPECTED, layout=layout_found(path), resample="own")
    packed = tmp_path / "pairs.csv.gz"
    packed.write_bytes(gzip.compress(path.read_bytes()))
    assert open_table(packed).headers == open_table(path, layout_found(path)).headers
    np.testing.assert_allclose(log["F"], 50 * np.cos(30 * (log.time - 0.25e-3)), atol=0.02)


def test_times_before_numbers_of_samples_alone_are_no_clock_of_a_signal(tmp_path: Path) -> None:
    path = tmp_path / "joint_states.csv"
    came = T + 2e-4 * np.random.default_rng(0).random(N)
    rows = enumerate(zip(came, T, Q, F, strict=True))
    path.write_text(
        "%time,field.header.seq,field.header.stamp,q,F\n"
        + "".join(f"{1e9 * c:.0f},{k},{1e9 * t:.0f},{q},{f}\n" for k, (c, t, q, f) in rows)
    )
    log = read_log(path, expected=EXPECTED, layout=layout_found(path))
    assert log.sampling_period == pytest.approx(1e-3)
    np.testing.assert_allclose(log["q"], Q)


def test_times_that_are_alike_are_one_clock(tmp_path: Path) -> None:
    path = tmp_path / "pairs.csv"
    path.write_text(
        "Time;q;Time;F\n" + "".join(f"{t};{q};{t};{f}\n" for t, q, f in zip(T, Q, F, strict=True))
    )
    assert open_table(path, layout_found(path)).headers == ("Time (1)", "q", "Time (2)", "F")


@pytest.mark.parametrize("digits", [0, 3])
def test_milliseconds_stand_beside_a_time_of_day_or_repeat_it(tmp_path: Path, digits: int) -> None:
    path, t = tmp_path / "a.csv", 58.9 + 0.01 * np.arange(N)
    times = [
        f"20.11.2026,10:{22 + int(x // 60)}:{x % 60 - (0 if digits else x % 1):0{2 + (digits and 4)}.{digits}f}"
        for x in t
    ]
    rows = zip(times, np.rint(1e3 * t) % 1000, Q, F, strict=True)
    path.write_text("Date,Time,Millitm,q,F\n" + "".join(f"{x},{m:.0f},{q},{f}\n" for x, m, q, f in rows))
    log = read_log(path, expected=EXPECTED, columns={"t": "t"}, layout=layout_found(path))
    assert (log.n_samples, log.sampling_period) == (N, pytest.approx(0.01))
    np.testing.assert_allclose(log["q"], Q)


def test_names_above_which_no_values_stand_do_no_harm(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("\n".join([lines()[0] + ",Start,Increment,", *lines()[1:]]))
    for layout in (None, layout_found(path)):
        np.testing.assert_allclose(read_log(path, expected=EXPECTED, layout=layout)["q"], Q, atol=1e-9)


def lines() -> list[str]:
    return ["t,q,F", *(f"{t:.3f},{q:.9f},{f:.6f}" for t, q, f in zip(T, Q, F, strict=True))]


def test_a_row_that_was_cut_off_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("\n".join(lines())[:-10])
    log = read_log(path, expected=EXPECTED)
    assert log.n_samples == N - 1
    assert "the last row is not complete: left out" in log.notes


def test_a_repeated_row_is_left_out_by_resampling(tmp_path: Path) -> None:
    rows = lines()
    rows.insert(100, rows[99])
    (tmp_path / "a.csv").write_text("\n".join(rows))
    log = read_log(tmp_path / "a.csv", expected=EXPECTED, resample="own")
    assert log.n_samples == N
    assert "1 samples with the time of the one before were left out" in log.notes


def test_a_clock_that_is_written_coarsely_is_not_thinned(tmp_path: Path) -> None:
    rows = ["t,q,F", *(f"{t:.2f},{q},{f}" for t, q, f in zip(T, Q, F, strict=True))]
    (tmp_path / "a.csv").write_text("\n".join(rows))
    with pytest.raises(LogError, match="t goes back or stops"):
        read_log(tmp_path / "a.csv", expected=EXPECTED, resample="own")


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_rows_of_json_are_named_by_the_list_beside_them(encoding: str, tmp_path: Path) -> None:
    rows = np.column_stack([T, Q, F]).tolist()
    (tmp_path / "a.json").write_text(json.dumps({"fields": ["t", "q", "F"], "rows": rows}), encoding)
    np.testing.assert_array_equal(read_log(tmp_path / "a.json", expected=EXPECTED)["q"], Q)


def test_objects_beside_arrays_are_passed_over(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", t=T, q=Q, F=F, meta=np.array({"a": 1}, dtype=object))
    np.testing.assert_array_equal(read_log(tmp_path / "a.npz", expected=EXPECTED)["q"], Q)


def test_columns_of_an_array_without_names_are_called_as_in_other_files(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["run/data"] = np.column_stack([T, Q, F])
    assert open_table(tmp_path / "a.h5").headers == ("data(:,1)", "data(:,2)", "data(:,3)")


def test_columns_of_texts_structs_and_times_of_day_are_read(tmp_path: Path) -> None:
    day = datetime.datetime(2026, 11, 21, 10, tzinfo=datetime.UTC)
    frame = pl.DataFrame(
        {
            "time": [(day + datetime.timedelta(seconds=t)).time() for t in T.tolist()],
            "axis": [{"pos": q, "drive": {"force": f}} for q, f in zip(Q.tolist(), F.tolist(), strict=True)],
            "weg": [f"{1e3 * q:.6f}".replace(".", ",") for q in Q.tolist()],
        }
    )
    frame.write_parquet(tmp_path / "a.parquet")
    frame.write_ipc_stream(tmp_path / "a.arrow")
    for name in ("a.parquet", "a.arrow"):
        table = open_table(tmp_path / name)
        assert table.headers == ("time", "axis.pos", "axis.drive.force", "weg")
        time, q, f, way = table.read(range(4))
        np.testing.assert_allclose(time - time[0], T, atol=1e-9)
        np.testing.assert_array_equal(q, Q)
        np.testing.assert_array_equal(f, F)
        np.testing.assert_allclose(way, 1e3 * Q, atol=1e-6)
        assert foreign_columns(table)[0].unit == "s"
