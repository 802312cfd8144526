"""The files that scopes, drives and robots write: each is written by its own library and read alike."""

import gzip
import json
import os
import sys
from pathlib import Path

import h5py
import numpy as np
import polars as pl
import pytest
import scipy.io
from log_formats import COLUMNS, EXPECTED, FILES, PERIOD, F, N, Q, T, hdf5, mcap_of_json, mdf, text

from symid.data import Layout, guessed_layout, open_table, read_log
from symid.data.formats import FOLDER_SUFFIXES, SUFFIXES
from symid.data.formats.compressed import OPENERS
from symid.data.formats.extra import required
from symid.errors import LogError


@pytest.mark.parametrize("name", FILES)
def test_each_kind_is_read_alike(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    FILES[name](path)
    log = read_log(path, expected=EXPECTED)
    assert log.sampling_period == PERIOD
    np.testing.assert_allclose(log["q"], Q, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(log["F"], F, rtol=1e-12)


@pytest.mark.parametrize("name", FILES)
def test_each_kind_that_is_damaged_is_one_line(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    FILES[name](path)
    whole = path.read_bytes()
    rng = np.random.default_rng(1)
    sizes = (1, len(whole) // 3, len(whole) // 2, len(whole) - 9)
    apart = name.endswith((".mat", ".mf4"))  # each is read in a separate process
    for size in sizes[1:2] if apart else sizes:
        path.write_bytes(whole[:size])
        _fails_in_one_line_or_reads(path)
    for _ in range(int(name == "d.mat") if apart else 12):
        damaged = bytearray(whole)
        for place in rng.integers(0, len(whole), 20):
            damaged[place] ^= int(rng.integers(1, 256))
        path.write_bytes(bytes(damaged))
        _fails_in_one_line_or_reads(path)


def test_a_file_that_ends_its_parser_is_one_line(tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "a.mat", {"t": T})
    data = bytearray((tmp_path / "a.mat").read_bytes())
    data[176 + 1] = 0xFF  # the type of the name's element: scipy 1.17 reads where it may not
    (tmp_path / "a.mat").write_bytes(bytes(data))
    with pytest.raises(LogError, match=r"a\.mat: is damaged, or not a MATLAB file"):
        open_table(tmp_path / "a.mat")


def test_what_threads_of_polars_print_of_a_damaged_file_is_dropped(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(_: object) -> pl.LazyFrame:
        os.write(2, b"thread panicked")
        raise pl.exceptions.ComputeError("broken")

    monkeypatch.setattr(pl, "scan_ipc", broken)
    FILES["a.feather"](tmp_path / "a.feather")
    with pytest.raises(LogError, match=r"a\.feather: is damaged, or not a Feather file"):
        open_table(tmp_path / "a.feather")
    assert capfd.readouterr().err == ""


def _fails_in_one_line_or_reads(path: Path) -> None:
    try:
        read_log(path, expected=EXPECTED)
    except LogError as error:
        message = str(error)
        assert "\n" not in message
        assert message.startswith(f"{path}: ")


def test_matrices_are_their_columns(tmp_path: Path) -> None:
    matrix = np.column_stack(list(COLUMNS.values()))
    scipy.io.savemat(tmp_path / "m.mat", {"data": matrix}, do_compression=True)
    with h5py.File(tmp_path / "m.h5", "w") as file:
        file["data"] = matrix.T
    for name, columns in (
        ("m.mat", {"t": "data(:,1)", "q": "data(:,2)", "F": "data(:,3)"}),
        ("m.h5", {"t": "data(:,1)", "q": "data(:,2)", "F": "data(:,3)"}),
    ):
        log = read_log(tmp_path / name, expected=EXPECTED, columns=columns)
        np.testing.assert_array_equal(log["q"], Q)
        np.testing.assert_array_equal(log["F"], F)


def test_columns_of_an_array_have_the_names_and_units_that_stand_beside_it(tmp_path: Path) -> None:
    rows = np.column_stack([T, 1e3 * Q, F])
    with h5py.File(tmp_path / "named.h5", "w") as file:
        file["data"] = rows
        file["data"].attrs["columns"], file["data"].attrs["units"] = ["t", "q", "F"], ["s", "mm", "N"]
    with h5py.File(tmp_path / "pandas.h5", "w") as file:
        file["df/axis1"], file["df/block0_values"] = np.arange(N), rows
        file["df/block0_items"] = np.array([b"t", b"q [mm]", b"F"])
    fields = np.zeros(N, dtype=[("t", "f8"), ("q [mm]", "f8"), ("F", "f8")])
    fields["t"], fields["q [mm]"], fields["F"] = rows.T
    np.savez(tmp_path / "fields.npz", log=fields)
    np.save(tmp_path / "fields.npy", fields)
    for name in ("named.h5", "pandas.h5", "fields.npz", "fields.npy"):
        log = read_log(tmp_path / name, expected=EXPECTED)
        np.testing.assert_allclose(log["q"], Q, atol=1e-12)
        np.testing.assert_array_equal(log["F"], F)


def by_index(values: np.ndarray) -> dict[str, float]:
    return {str(i): value for i, value in enumerate(values.tolist())}


@pytest.mark.parametrize(
    "content",
    [
        {"t": by_index(T), "q [mm]": by_index(1e3 * Q), "F": by_index(F)},  # DataFrame.to_json of pandas
        [
            {"name": n, "unit": u, "values": x.tolist()}
            for n, u, x in (("t", "s", T), ("q", "m", Q), ("F", "N", F))
        ],
        {
            "t": T.tolist(),
            "q": {"unit": "mm", "data": (1e3 * Q).tolist()},
            "F": {"data": F.tolist(), "unit": "N"},
        },
    ],
)
def test_signals_of_json_are_records_or_columns(content: object, tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(json.dumps(content))
    log = read_log(tmp_path / "a.json", expected=EXPECTED)
    np.testing.assert_allclose(log["q"], Q, atol=1e-12)
    np.testing.assert_array_equal(log["F"], F)


def test_signals_of_a_recording_have_the_clock_that_they_refer_to(tmp_path: Path) -> None:
    """Two rasters of ControlDesk, and two scopes of Simulink."""
    xs, ys = np.empty((1, 2), dtype=object), np.empty((1, 2), dtype=object)
    xs[0, 0], xs[0, 1] = {"Name": "fast", "Data": T}, {"Name": "slow", "Data": T[::2]}
    ys[0, 0] = {"Name": "Model/q", "Data": 1e3 * Q, "Unit": "mm", "XIndex": 1}
    ys[0, 1] = {"Name": "Model/F", "Data": F[::2], "Unit": "N", "XIndex": 2}
    scipy.io.savemat(tmp_path / "dspace.mat", {"rec": {"X": xs, "Y": ys}}, do_compression=True)
    scopes = {
        name: {"time": t, "signals": {"values": x, "label": label}}
        for name, t, x, label in (("a", T, 1e3 * Q, "Model/q [mm]"), ("b", T[::2], F[::2], "Model/F"))
    }
    scipy.io.savemat(tmp_path / "simulink.mat", scopes, do_compression=True)
    columns = {"q": "Model/q", "F": "Model/F"}
    for name in ("dspace.mat", "simulink.mat"):
        with pytest.raises(LogError, match="has other times than"):
            read_log(tmp_path / name, expected=EXPECTED, columns=columns)
        log = read_log(tmp_path / name, expected=EXPECTED, columns=columns, resample="own")
        assert log.sampling_period == pytest.approx(PERIOD)
        np.testing.assert_allclose(log["F"], F[: log.n_samples], atol=1e-3)


def test_names_that_repeat_are_whole_paths(tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "two.mat", {"a": {"q": Q}, "b": {"q": Q}, "t": T}, do_compression=True)
    assert set(open_table(tmp_path / "two.mat").headers) == {"a.q", "b.q", "t"}


def test_a_library_that_is_missing_is_named_with_its_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hdf5(tmp_path / "a.h5")
    mdf(tmp_path / "a.mf4")
    mcap_of_json(tmp_path / "a.mcap")
    for library, name in (("h5py", "a.h5"), ("asammdf", "a.mf4"), ("mcap.reader", "a.mcap")):
        monkeypatch.setitem(sys.modules, library, None)
        with pytest.raises(LogError, match=rf"files are read by {library}, .* pip install 'symid\[files\]'"):
            read_log(tmp_path / name, expected=EXPECTED)
    assert required("json", tmp_path) is json


def test_every_format_has_a_row_in_the_table_of_formats() -> None:
    page = (Path(__file__).parents[2] / "docs/how_to/foreign_log.md").read_text(encoding="utf-8")
    table = page.partition("| suffix |")[2].partition("\n\n")[0]
    assert [suffix for suffix in SUFFIXES if f"`{suffix}`" not in table and suffix.count(".") == 1] == []


def test_results_and_settings_in_a_folder_are_no_logs() -> None:
    assert set(SUFFIXES) - set(FOLDER_SUFFIXES) == {".json", ".npz", ".npy", ".xls", ".ods", *OPENERS}


@pytest.mark.parametrize(
    "content", ["[]", "{}", '"a"', '{"a": [[1, 2], [3]]}', '[{"a": "x"}]', "[" * 100_000]
)
def test_json_without_columns_is_refused(content: str, tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text(content)
    with pytest.raises(LogError, match=r"a\.json: ") as caught:
        open_table(path)
    assert "\n" not in str(caught.value)


def test_no_objects_are_loaded(tmp_path: Path) -> None:
    np.savez(tmp_path / "o.npz", t=np.array([{"a": 1}] * 30, dtype=object))
    with pytest.raises(LogError, match=r"o\.npz: is damaged, or not a NPZ file"):
        open_table(tmp_path / "o.npz")


def test_a_file_without_names_has_numbered_columns(tmp_path: Path) -> None:
    path = tmp_path / "bare.csv"
    path.write_text(text().partition("\n")[2])
    layout = guessed_layout(path)
    assert layout == Layout("utf-8-sig", ",", ".", 0, 0, named=False)
    columns = {"t": "column 1", "q": "column 2", "F": "column 3"}
    log = read_log(path, expected=EXPECTED, columns=columns, layout=layout)
    assert log.n_samples == N
    np.testing.assert_array_equal(log["F"], F)


def test_a_line_of_a_property_above_the_names_is_no_line_of_names(tmp_path: Path) -> None:
    path = tmp_path / "servo.csv"
    path.write_text("SERVO GUIDE,Ver 10\nSampling,4.0,ms\n" + text())
    layout = guessed_layout(path)
    assert layout.above == 2
    np.testing.assert_array_equal(read_log(path, expected=EXPECTED, layout=layout)["q"], Q)


def test_compressed_text_has_lines_above_its_header(tmp_path: Path) -> None:
    path = tmp_path / "trace.csv.gz"
    above = "Trace of axis X\nrecorded today\n\n"
    path.write_bytes(gzip.compress((above + text(";", header="t;q;F")).encode("utf-16")))
    np.testing.assert_array_equal(read_log(path, expected=EXPECTED)["q"], Q)


@pytest.mark.parametrize(
    "stamp",
    [
        lambda k: (
            f"2026-11-21T09:59:59.{4 * k:03d}Z" if k < 250 else f"2026-11-21T10:00:00.{4 * k - 1000:03d}Z"
        ),
        lambda k: (
            f"2026-11-21 23:59:59.{4 * k:03d}" if k < 250 else f"2026-11-22 00:00:00.{4 * k - 1000:03d}"
        ),
        lambda k: f"23:59:59.{4 * k:03d}" if k < 250 else f"00:00:00.{4 * k - 1000:03d}",
    ],
)
def test_moments_are_seconds(stamp, tmp_path: Path) -> None:
    path = tmp_path / "iso.csv"
    rows = [f"{stamp(k)},{q!r},{f!r}" for k, (q, f) in enumerate(zip(Q.tolist(), F.tolist(), strict=True))]
    path.write_text("\n".join(["t,q,F", *rows]))
    log = read_log(path, expected=EXPECTED)
    assert log.sampling_period == pytest.approx(PERIOD)
    np.testing.assert_array_equal(log["q"], Q)
    assert guessed_layout(path).above == 0


def test_a_column_of_words_is_no_column_of_moments(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text().replace("\n0.004,", "\nlater,"))
    with pytest.raises(LogError, match="'later' in row 2"):
        read_log(path, expected=EXPECTED)


@pytest.mark.parametrize("mark", ["", "# "])
def test_columns_of_spaces_are_read(mark: str, tmp_path: Path) -> None:
    path = tmp_path / "run.dat"
    rows = "\n".join(f"{t:12.6f}{q:26.17e}\t  {f!r}  " for t, q, f in zip(T, Q, F.tolist(), strict=True))
    path.write_text(f"a log of the axis, written by hand\n{mark}t   q\tF\n{rows}\n")
    layout = guessed_layout(path)
    assert layout == Layout("utf-8-sig", " ", ".", 1, 0)
    log = read_log(path, expected=EXPECTED, layout=layout)
    np.testing.assert_array_equal(log["q"], Q)
    np.testing.assert_array_equal(log["F"], F)


def test_the_mark_of_a_comment_is_no_name(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "a.csv", np.column_stack(list(COLUMNS.values())), header="t,q,F", delimiter=",")
    np.testing.assert_array_equal(read_log(tmp_path / "a.csv", expected=EXPECTED)["F"], F)
