"""Files of all kinds, mapped columns, units, and what happens to damaged files."""

import numpy as np
import polars as pl
import pytest
import scipy.io
from hypothesis import given, settings, strategies as st
from log_files import EXPECTED, FM, Q2, N, T, columns, error_of, write

from symid.data import Log, read_log
from symid.errors import LogError
from symid.units import Unit, to_si


def assert_same(log):
    assert isinstance(log, Log)
    assert log.sampling_period == 0.004
    assert log["q2"] == pytest.approx(Q2, rel=1e-12)
    assert log["Fm"] == pytest.approx(FM, rel=1e-12)
    assert not log["q2"].flags.writeable


@pytest.mark.parametrize(
    ("separator", "decimal", "lead"),
    [(",", ".", ""), (";", ".", ""), (";", ",", ""), ("\t", ".", ""), ("\t", ",", ""), (",", ".", "\ufeff")],
)
def test_csv_in_all_dialects(tmp_path, separator, decimal, lead):
    path = write(tmp_path / "a.csv", columns(), separator, decimal, lead)
    log = read_log(path, expected=EXPECTED)
    assert_same(log)
    assert log.source == str(path)
    assert list(log.signals) == ["q2", "Fm"]


def test_csv_with_spaces_quotes_blank_end_and_other_columns(tmp_path):
    path = tmp_path / "odd [1].csv"
    rows = [
        f' {t!r} , "{q!r}", {f!r} ,idle,'
        for t, q, f in zip(T.tolist(), Q2.tolist(), FM.tolist(), strict=True)
    ]
    path.write_text("t, q2 ,Fm,state\r\n" + "\r\n".join(rows) + "\r\n\r\n\r\n", encoding="utf-8")
    assert_same(read_log(path, expected=EXPECTED))


def test_latin_1_header(tmp_path):
    path = write(tmp_path / "a.csv", {"t": T, "q2 [µm]": 1e6 * Q2, "Fm": FM})
    path.write_bytes(path.read_text(encoding="utf-8").encode("latin-1"))
    assert_same(read_log(path, expected=EXPECTED))


def test_parquet_and_mat(tmp_path):
    pl.DataFrame({**columns(), "state": ["on"] * N}).write_parquet(tmp_path / "a.parquet")
    assert_same(read_log(tmp_path / "a.parquet", expected=EXPECTED))
    scipy.io.savemat(
        tmp_path / "a.mat",
        {**columns(), "gain": 3.0, "name": "bench", "setup": {"kp": 2.0}, "other": np.zeros((4, 5))},
    )
    assert_same(read_log(tmp_path / "a.mat", expected=EXPECTED))


def test_units_in_headers_and_given_ones(tmp_path):
    path = write(tmp_path / "a.csv", {"t [ms]": 1e3 * T, "q2 [mm]": 1e3 * Q2, "Fm [kN]": 1e-3 * FM})
    assert_same(read_log(path, expected=EXPECTED))
    path = write(tmp_path / "b.csv", {"time": 1e6 * T, "pos_mm": 1e3 * Q2, "cur [A]": FM / 35.0})
    log = read_log(
        path,
        expected={**EXPECTED, "Fm": Unit.of("A")},
        columns={"t": "time", "q2": "pos_mm", "Fm": "cur"},
        units={"t": "us", "q2": "mm"},
        gains={"Fm": 35.0},
    )
    assert_same(log)


@given(
    factor=st.sampled_from([("m", 1.0), ("mm", 1e3), ("um", 1e6), ("inch", 1.0 / 0.0254)]),
    gain=st.floats(0.1, 10.0),
)
@settings(max_examples=15)
def test_written_unit_and_gain_undo_each_other(tmp_path_factory, factor, gain):
    unit, per_metre = factor
    path = write(tmp_path_factory.mktemp("g") / "a.csv", columns(q2=Q2 * per_metre / gain))
    log = read_log(path, expected=EXPECTED, units={"q2": unit}, gains={"q2": gain})
    assert log["q2"] == pytest.approx(Q2, rel=1e-9)


def test_reference_is_kept_if_it_can_be(tmp_path):
    path = write(tmp_path / "a.csv", columns(**{"reference [mm]": 1e3 * Q2}))
    assert read_log(path, expected=EXPECTED)["reference"] == pytest.approx(Q2)
    for bad in (["up"] * N, np.where(T < 0.1, np.nan, Q2)):
        log = read_log(write(tmp_path / "b.csv", columns(reference=bad)), expected=EXPECTED)
        assert "reference" not in log.signals
        assert len(log.notes) == 1
    assert "numbers are required" in error_of(
        write(tmp_path / "c.csv", columns(cmd=["up"] * N)), columns={"reference": "cmd"}
    )


def test_alternative_column(tmp_path):
    path = write(tmp_path / "a.csv", {"t": T, "q2": Q2, "vir": FM / 35.0})
    alternatives = {"Fm": ("vir", 35.0)}
    assert_same(read_log(path, expected=EXPECTED, alternatives=alternatives))
    milli = write(tmp_path / "b.csv", {"t": T, "q2": Q2, "u [mV]": 1e3 * FM / 35.0})
    assert_same(read_log(milli, expected=EXPECTED, alternatives=alternatives, columns={"vir": "u"}))
    both = write(tmp_path / "c.csv", columns(vir=np.zeros(N)))
    assert_same(read_log(both, expected=EXPECTED, alternatives=alternatives))
    named = read_log(
        path, expected=EXPECTED, alternatives=alternatives, columns={"Fm": "vir"}, gains={"Fm": 35.0}
    )
    assert_same(named)
    assert "add `columns` Fm=vir" in error_of(path, alternatives=alternatives, gains={"Fm": 2.0})


def test_named_columns_that_are_missing(tmp_path):
    path = write(tmp_path / "a.csv", {"t": T, "pos_mm": Q2, "force [N]": FM})
    message = error_of(path, columns={"q2": "posmm", "Fm": "kraft"})
    assert "no column 'posmm' for the signal 'q2' (did you mean 'pos_mm'?)" in message
    assert "no column 'kraft'" in message
    assert "the file has t, pos_mm, force [N]" in message
    message = error_of(path, columns={"q2": "pos_mm", "q3": "pos_mm"}, gains={"Fn": 2.0})
    assert "signal 'q3' is not known (did you mean 'q2'?)" in message
    assert "signal 'Fn'" in message


def test_no_time_and_no_signal(tmp_path):
    path = write(tmp_path / "a.csv", {"time": T, "q2": Q2, "Fm": FM})
    message = error_of(path)
    assert "the file has time, q2, Fm" in message
    assert "`columns` t=NAME" in message
    path = write(tmp_path / "b.csv", {"t": T, "x": Q2})
    assert "has none of the signals q2, ddq1, Fm" in error_of(path)


def test_swapped_units_are_reported_together(tmp_path):
    message = error_of(write(tmp_path / "a.csv", {"t": T, "q2 [N]": Q2, "Fm [mm]": FM}))
    assert "column 'q2 [N]': unit 'N' does not measure" in message
    assert "column 'Fm [mm]': unit 'mm' does not measure" in message
    assert "unit 'furlogs' is not known" in error_of(
        write(tmp_path / "b.csv", columns()), units={"q2": "furlogs"}
    )
    for gain in (0.0, float("nan")):
        assert "gain" in error_of(tmp_path / "b.csv", gains={"q2": gain})


def test_duplicate_headers(tmp_path):
    path = tmp_path / "a.csv"
    rows = "\n".join(f"{t},{q},{q},{f}" for t, q, f in zip(T, Q2, FM, strict=True))
    path.write_text("t,q2,q2,Fm\n" + rows + "\n", encoding="utf-8")
    assert "column 'q2' occurs 2 times" in error_of(path)
    path.write_text("t,q2 [m],q2 [mm],Fm\n" + rows + "\n", encoding="utf-8")
    assert "('q2 [m]', 'q2 [mm]')" in error_of(path)
    assert read_log(path, expected=EXPECTED, columns={"q2": "q2 [m]"})["q2"] == pytest.approx(Q2)
    path.write_text("t,x,x,Fm\n" + rows + "\n", encoding="utf-8")
    assert list(read_log(path, expected=EXPECTED).signals) == ["Fm"]


@pytest.mark.parametrize("separator", [",", ";"])
def test_text_in_numbers(tmp_path, separator):
    q2 = [*Q2[:50].tolist(), "err", *Q2[51:150].tolist(), "off", *Q2[151:].tolist()]
    fm = [*FM[:7].tolist(), "1.2.3", *FM[8:].tolist()]
    message = error_of(write(tmp_path / "a.csv", columns(q2=q2, Fm=fm), separator))
    assert "column 'q2' has 'err' in row 51 and in 1 more" in message
    assert "column 'Fm' has '1.2.3' in row 8" in message


def test_runs_of_missing_values(tmp_path):
    q2 = Q2.copy()
    q2[60:70] = np.nan
    fm = [*FM[:9].tolist(), "", *FM[10:].tolist()]
    message = error_of(write(tmp_path / "a.csv", columns(q2=q2, Fm=fm)))
    assert "'q2' has 10 values empty or not finite, the first at t = 0.24 s (row 61)" in message
    assert "'Fm' has 1 value empty or not finite, the first at t = 0.036 s (row 10)" in message
    pl.DataFrame({**columns(), "q2": [None, *Q2[1:].tolist()]}).write_parquet(tmp_path / "a.parquet")
    assert "'q2' has 1 value empty or not finite" in error_of(tmp_path / "a.parquet")


def test_faults_of_clock_and_channels_are_reported_together(tmp_path):
    time = T.copy()
    time[20] = time[19]
    time[120:] += 1.0
    q2 = Q2.copy()
    q2[5] = np.inf
    message = error_of(write(tmp_path / "a.csv", columns(t=time, q2=q2, Fm=np.full(N, 3.0))))
    for part in ("1 repeated time", "gap", "'q2' has 1 value", "'Fm' is constant (3)"):
        assert part in message
    assert "1 step backwards" in error_of(write(tmp_path / "b.csv", columns(t=np.where(T < 0.4, T, T - 0.2))))


def test_a_constant_column_matters_only_if_the_axis_uses_it(tmp_path):
    path = write(tmp_path / "a.csv", columns(ddq1=np.zeros(N), supply=np.full(N, 24.0)))
    assert "'ddq1' is constant (0)" in error_of(path)
    assert_same(read_log(path, expected={name: EXPECTED[name] for name in ("q2", "Fm")}))


def test_short_logs(tmp_path):
    short = {name: column[:3] for name, column in columns().items()}
    assert "has only 3 samples: at least 25 are required" in error_of(write(tmp_path / "a.csv", short))
    pl.DataFrame(columns()).head(0).write_parquet(tmp_path / "a.parquet")
    assert "has no rows" in error_of(tmp_path / "a.parquet")
    (tmp_path / "b.csv").write_text("t,q2,Fm\n", encoding="utf-8")
    assert "has no rows" in error_of(tmp_path / "b.csv")
    (tmp_path / "c.csv").write_text("t,q2,Fm", encoding="utf-8")
    assert "has no rows" in error_of(tmp_path / "c.csv")


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".mat"])
def test_empty_and_foreign_bytes(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(b"")
    assert "is empty" in error_of(path)
    path.write_bytes(bytes(range(256)) * 20)
    error_of(path)
    assert "no such file" in error_of(tmp_path / f"b{suffix}")


def test_directories_and_other_suffixes(tmp_path):
    assert "is a directory" in error_of(tmp_path)
    (tmp_path / "a.docx").write_bytes(b"PK")
    assert "suffix '.docx' is not known: give a .csv, .parquet or .mat file" in error_of(tmp_path / "a.docx")


def test_headers_that_are_none(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("0,1,2\n1,2,3\n", encoding="utf-8")
    assert "the first line holds numbers" in error_of(path)
    path.write_text("\n0,1,2\n", encoding="utf-8")
    assert "the first line is empty" in error_of(path)
    path.write_text("t,q2,Fm\n0,1,2\n", encoding="utf-16")
    assert "not text in UTF-8" in error_of(path)


def test_rows_with_too_many_fields(tmp_path):
    path = write(tmp_path / "a.csv", columns(Fm=[*FM[:30].tolist(), "1,5", *FM[31:].tolist()]))
    assert "row 31 has 4 fields where there are 3 columns" in error_of(path)


@pytest.mark.parametrize("unit", ["µ?", "mm!", "m;", "?"])
def test_signs_that_no_unit_has_are_not_passed_over(unit):
    with pytest.raises(LogError, match="is not known"):
        to_si(unit)


@pytest.mark.parametrize(("unit", "factor"), [("µm", 1e-6), ("m/s²", 1.0), ("N·m", 1.0), ("m s**-2", 1.0)])
def test_units_as_they_are_written_are_known(unit, factor):
    assert to_si(unit) == pytest.approx(factor)
