"""MATLAB and Parquet files: arrays that are not signals, truncated files, damaged bytes."""

import numpy as np
import polars as pl
import pytest
import scipy.io
from hypothesis import given, settings, strategies as st
from log_files import EXPECTED, FM, Q2, N, T, columns, error_of, write

from symid.data import read_log
from symid.errors import LogError


@pytest.mark.parametrize("kind", ["parquet", "mat"])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.7, 0.99])
def test_truncated_binary_files(tmp_path, kind, share):
    path = tmp_path / f"a.{kind}"
    if kind == "parquet":
        pl.DataFrame(columns()).write_parquet(path)
    else:
        scipy.io.savemat(path, columns(), do_compression=True)
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    error_of(path)


@given(seed=st.integers(0, 10_000), kind=st.sampled_from(["csv", "parquet"]))
@settings(max_examples=60, deadline=None)
def test_damaged_bytes_give_a_log_or_one_line(tmp_path_factory, seed, kind):
    path = tmp_path_factory.mktemp("d") / f"a.{kind}"
    if kind == "csv":
        write(path, columns())
    else:
        pl.DataFrame(columns()).write_parquet(path)
    rng = np.random.default_rng(seed)
    content = np.frombuffer(path.read_bytes(), dtype=np.uint8).copy()
    content[rng.integers(0, content.size, 4)] = rng.integers(0, 256, 4)
    path.write_bytes(content.tobytes())
    try:
        message = read_log(path, expected=EXPECTED).source
    except LogError as error:
        message = str(error)
    assert message.startswith(str(path))
    assert "\n" not in message


def test_matlab_7_3(tmp_path):
    path = tmp_path / "a.mat"
    text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64"
    path.write_bytes(text.ljust(512) + b"\x89HDF\r\n\x1a\n" + bytes(500))
    assert "is damaged, or not a HDF5 file" in error_of(path)


def test_matlab_arrays_that_are_no_signals(tmp_path):
    path = tmp_path / "a.mat"
    scipy.io.savemat(path, columns(q2=np.outer(Q2, Q2), Fm=FM * (1.0 + 1.0j)), do_compression=True)
    message = error_of(path)
    assert "column 'q2' is an array of 200 x 200 where a vector is required" in message
    assert "column 'Fm' is complex" in message
    scipy.io.savemat(path, columns(q2=Q2[:150], ref=np.zeros(9)), do_compression=True)
    assert "differ in length (t 200, q2 150, Fm 200)" in error_of(path)
    scipy.io.savemat(path, {"t": T, "q2": Q2, "Fm": "text"}, do_compression=True)
    assert list(read_log(path, expected=EXPECTED).signals) == ["q2"]
    assert "no column 'Fm'" in error_of(path, columns={"Fm": "Fm"})


def test_parquet_columns_that_are_no_numbers(tmp_path):
    path = tmp_path / "a.parquet"
    pl.DataFrame({**columns(), "q2": ["x"] * N}).write_parquet(path)
    assert "column 'q2' holds texts such as 'x' where numbers are required" in error_of(path)
    pl.DataFrame({"t": T, "q2": (1e6 * Q2).astype(np.int32), "Fm": FM.astype(np.float32)}).write_parquet(path)
    log = read_log(path, expected=EXPECTED, units={"q2": "um"})
    assert log["q2"] == pytest.approx(Q2, abs=1e-6)
    assert log["Fm"].dtype == np.float64
