"""One log in several files."""

from pathlib import Path

import numpy as np
import pytest

from symid.data import open_table, read_log
from symid.errors import LogError
from symid.report.pages.page import provenance
from tests.log_formats import EXPECTED, PERIOD, F, Q, T


def saved(path: Path, names: str, *columns: np.ndarray) -> Path:
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=names, comments="")
    return path


def test_signals_of_two_files_have_the_times_of_theirs(tmp_path: Path) -> None:
    saved(tmp_path / "a.csv", "t [ms],q [mm]", 1e3 * T, 1e3 * Q)
    saved(tmp_path / "b.csv", "time,F", T[::2], F[::2])
    log = read_log(f"{tmp_path / 'a.csv'}+b.csv", expected=EXPECTED, resample="own")
    assert log.sampling_period == pytest.approx(PERIOD)
    inner = slice(9, -9)
    np.testing.assert_allclose(log["q"], Q[: log.n_samples], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(log["F"][inner], F[: log.n_samples][inner], rtol=1e-5)


def test_names_that_both_files_have_begin_with_that_of_the_file(tmp_path: Path) -> None:
    for name in ("a.csv", "b.csv"):
        saved(tmp_path / name, "t,q", T, Q)
    assert open_table(Path(f"{tmp_path / 'a.csv'}+{tmp_path / 'b.csv'}")).headers == ("a.q", "b.q", "t")


def test_each_file_is_hashed(tmp_path: Path) -> None:
    a, b = (saved(tmp_path / name, "t,q", T, Q) for name in ("a.csv", "b.csv"))
    assert {f"SHA-256 of {file}" for file in (a, b)} <= {name for name, _ in provenance([f"{a}+{b}"], "")}


@pytest.mark.parametrize(
    ("names", "fault"),
    [("q,F", "no column of times in a known unit"), ("time,F", "no column of times in a known unit")],
)
def test_a_file_without_times_is_refused(names: str, fault: str, tmp_path: Path) -> None:
    saved(tmp_path / "a.csv", "t,q", T, Q)
    first = Q if names == "q,F" else 1e9 * np.arange(T.size)  # no unit makes that a sampling period
    saved(tmp_path / "b.csv", names, first, F)
    with pytest.raises(LogError, match=f"b.csv: has {fault}"):
        open_table(Path(f"{tmp_path / 'a.csv'}+b.csv"))


def test_moments_of_two_files_have_no_common_begin(tmp_path: Path) -> None:
    saved(tmp_path / "a.csv", "t,q", T, Q)
    rows = [f"2026-11-21T10:00:{t:09.6f},{f}" for t, f in zip(T, F, strict=True)]
    (tmp_path / "b.csv").write_text("\n".join(["time,F", *rows]))
    with pytest.raises(LogError, match="times are moments"):
        open_table(Path(f"{tmp_path / 'a.csv'}+b.csv"))
