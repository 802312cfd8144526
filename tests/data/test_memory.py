"""A small file that holds a great many rows takes the memory that it may take, or is refused."""

import struct
import zlib
from pathlib import Path

import numpy as np
import polars as pl
import pytest
import scipy

from symid.data import LongLog, open_log, read_log
from symid.data.table import free_memory, require_memory
from symid.errors import LogError
from symid.units import Unit

EXPECTED = {"q": Unit.of("m"), "F": Unit.of("N")}
N = 300_000


@pytest.fixture
def small_file(tmp_path: Path) -> Path:
    """A file of far fewer bytes than rows."""
    file = tmp_path / "small.parquet"
    t = np.arange(N) / 1000
    pl.DataFrame({"t": t.astype(np.float32) * 0 + 1.0, "q": np.zeros(N), "F": np.zeros(N)}).write_parquet(
        file
    )
    assert file.stat().st_size < N / 4
    return file


def test_rows_count_and_not_bytes(small_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symid.data.opening.read_table", lambda *_: pytest.fail("it was read at once"))
    with pytest.raises(LogError, match=r"small\.parquet"):  # its clock stands still in the first block
        open_log(small_file, expected=EXPECTED, memory=10_000_000)


def test_a_log_that_must_be_whole_is_refused(small_file: Path) -> None:
    with pytest.raises(LogError, match=r"needs 7\.2 MB of memory, but 1 MB are allowed"):
        open_log(small_file, expected=EXPECTED, memory=1_000_000, whole=True)


def test_a_matlab_bomb_is_refused_before_it_is_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "bomb.mat"
    scipy.io.savemat(file, dict.fromkeys(EXPECTED, np.zeros(N)), do_compression=True)
    assert file.stat().st_size < 20_000
    monkeypatch.setattr(scipy.io, "loadmat", lambda *_: pytest.fail("it was loaded"))
    with pytest.raises(LogError, match=r"bomb\.mat: needs 4\.8 MB of memory"):
        open_log(file, expected=EXPECTED, memory=1_000_000)


def test_a_matlab_file_without_compression_is_read_within_its_memory(tmp_path: Path) -> None:
    file, t = tmp_path / "plain.mat", np.arange(2000) / 1000.0
    scipy.io.savemat(file, {"t": t, "q": np.sin(9 * t), "F": np.cos(9 * t)})
    assert open_log(file, expected=EXPECTED, memory=10_000_000).n_samples == t.size


@pytest.mark.parametrize("stated", [None, 1000])
def test_a_bomb_in_a_struct_is_refused_before_it_is_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stated: int | None
) -> None:
    """The list of variables shows one struct; the size that the file states may be a lie."""
    file = tmp_path / "bomb.mat"
    scipy.io.savemat(file, {"run": dict.fromkeys(EXPECTED, np.zeros(N))}, do_compression=True)
    if stated is not None:
        content = file.read_bytes()
        inner = bytearray(zlib.decompress(content[136:]))
        inner[4:8] = struct.pack("<I", stated)
        packed = zlib.compress(inner)
        file.write_bytes(content[:128] + struct.pack("<II", 15, len(packed)) + packed)
    assert file.stat().st_size < 20_000
    loaded = scipy.io.loadmat(file, simplify_cells=True)  # it is a sound file
    assert all(loaded["run"][name].size == N for name in EXPECTED)
    monkeypatch.setattr(scipy.io, "loadmat", lambda *_: pytest.fail("it was loaded"))
    with pytest.raises(LogError, match=r"bomb\.mat: needs (4\.8|1\.05) MB of memory"):
        open_log(file, expected=EXPECTED, memory=1_000_000)


def test_what_the_machine_does_not_have_is_not_asked_for(
    small_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("symid.data.table.free_memory", lambda: 1e6)
    with pytest.raises(LogError, match="1 MB are free"):
        read_log(small_file, expected=EXPECTED)


def test_blocks_are_chosen_by_rows(tmp_path: Path) -> None:
    file = tmp_path / "long.parquet"
    t = np.arange(N) / 1000
    pl.DataFrame({"t": t, "q": np.round(np.sin(t), 1), "F": np.round(np.cos(t), 1)}).write_parquet(file)
    assert isinstance(open_log(file, expected=EXPECTED, memory=20_000_000), LongLog)


def test_this_machine_says_what_is_free() -> None:
    assert free_memory() > 1e6
    require_memory(1000)
