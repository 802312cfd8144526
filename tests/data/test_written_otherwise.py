"""Text whose numbers, times, repeated lines and encodings are not those of a plain CSV file."""

from pathlib import Path

import numpy as np
import pytest

from symid.data import Log, foreign_columns, open_table, read_log
from symid.data.formats import layout_found
from symid.data.text_files.foreign import described_column
from symid.errors import LogError
from symid.units import Unit

EXPECTED = {"q": Unit.of("m"), "F": Unit.of("N")}
T = 1e-3 * np.arange(60)
Q, F = 0.01 * np.sin(50 * T), 3.0 * np.cos(70 * T)


def written(file: Path, header: str, form: str, *, encoding: str = "utf-8", repeat: bool = False) -> Path:
    lines = [
        form.format(t=t, q=q, F=f, s=17 + int(t), n=round(t % 1 * 1e9))
        for t, q, f in zip(T, Q, F, strict=True)
    ]
    if repeat:
        lines.insert(30, header)
    file.write_bytes("\n".join([header, *lines, ""]).encode(encoding))
    return file


def check(log: Log) -> None:
    assert log["q"] == pytest.approx(Q, abs=1e-8)
    assert log["F"] == pytest.approx(F, abs=1e-8)
    assert log.sampling_period == pytest.approx(1e-3)


@pytest.mark.parametrize(
    ("header", "form"),
    [
        ("t,q,F", "{t:.3f},{q:.9f} m,{F:.9f}N"),
        ("t,q [m],F", "{t:.3f} s,{q:.9f} m,{F:.9f}"),
        ("secs,nsecs,q,F", "{s},{n},{q:.9f},{F:.9f}"),
        ("stamp.sec,stamp.nanosec,q,F", "{s},{n},{q:.9f},{F:.9f}"),
    ],
)
@pytest.mark.parametrize("repeat", [False, True])
def test_units_in_cells_split_times_and_repeated_names_are_read(
    tmp_path: Path, header: str, form: str, repeat: bool
) -> None:
    file = written(tmp_path / "log.csv", header, form, repeat=repeat)
    check(read_log(file, expected=EXPECTED))
    check(read_log(file, expected=EXPECTED, layout=layout_found(file)))


@pytest.mark.parametrize("mark", "Dd")
def test_exponents_of_fortran_are_read(tmp_path: Path, mark: str) -> None:
    file = written(tmp_path / "log.csv", "t,q,F", "{t:.9e},{q:.9e},{F:.9e}")
    file.write_text(file.read_text().replace("e", mark))
    check(read_log(file, expected=EXPECTED))
    check(read_log(file, expected=EXPECTED, layout=layout_found(file)))


def test_a_unit_in_cells_that_is_not_that_of_the_name_is_refused(tmp_path: Path) -> None:
    file = written(tmp_path / "log.csv", "t,q [mm],F", "{t:.3f},{q:.9f} m,{F:.9f}")
    with pytest.raises(LogError, match=r"'q \[mm\]' holds numbers in m"):
        read_log(file, expected=EXPECTED)


def test_cells_of_several_units_are_refused(tmp_path: Path) -> None:
    file = written(tmp_path / "log.csv", "t,q,F", "{t:.3f},{q:.9f} m,{F:.9f}")
    text = file.read_text().splitlines()
    text[20] = text[20].replace(" m", " mm")
    file.write_text("\n".join(text))
    with pytest.raises(LogError, match=r"mm' in row 20"):
        read_log(file, expected=EXPECTED)


@pytest.mark.parametrize(
    ("encoding", "header"),
    [
        ("cp1251", "Время [с],Положение [м],Сила [Н]"),
        ("koi8-r", "Время, с;Положение, м;Усилие, Н"),
        ("cp932", "時間[s],位置[m],推力[N]"),
        ("euc_jp", "時間[s],位置[m],推力[N]"),
        ("gbk", "时间(s),位置(m),力(N)"),
        ("cp1252", "Zeit [s],Lage [m],Größe,Kraft [N]"),
    ],
)
def test_the_encoding_is_the_one_whose_names_are_words(tmp_path: Path, encoding: str, header: str) -> None:
    mark = ";" if ";" in header else ","
    form = mark.join(["{t:.3f}", "{q:.9f}", *["7"] * ("Größe" in header), "{F:.9f}"])
    file = written(tmp_path / "log.csv", header, form, encoding=encoding)
    layout = layout_found(file)
    assert layout.encoding == encoding
    found = {column.quantity: column.unit for column in foreign_columns(open_table(file, layout))}
    found.pop(None, None)
    units = {"time": "s", "position": "m", "force": "N"}
    assert found == units


@pytest.mark.parametrize(
    ("header", "quantity", "unit"),
    [
        ("Iststrom [Aeff]", "current", "A"),
        ("Istdrehzahl [U/min]", "velocity", "rpm"),
        ("Istgeschwindigkeit", "velocity", None),
        ("Schleppabstand [mm]", None, "mm"),
        ("Position following error [mm]", None, "mm"),
        ("PosErr", None, None),
    ],
)
def test_values_are_told_from_their_differences_to_what_is_commanded(
    header: str, quantity: str, unit: str | None
) -> None:
    found = described_column(header, np.linspace(0, 1, 9))
    assert (found.quantity, found.unit, found.setpoint) == (quantity, unit, False)


@pytest.mark.parametrize(
    ("header", "quantity", "unit"),
    [
        ("iq_mA", "current", "mA"),
        ("torque_mNm", "force", "mNm"),
        ("force_daN", "force", "daN"),
        ("pos_nm", "position", "nm"),
        ("q1_mrad", "position", "mrad"),
        ("vel_mm_s", "velocity", "mm/s"),
        ("dq1_rad_s", "velocity", "rad/s"),
        ("Speed deg/s", "velocity", "deg/s"),
        ("acc_mm_s2", "acceleration", "mm/s2"),
        ("u_mV", "voltage", "mV"),
        ("trq_permille", "percent", "0.1 %"),
        ("time_ns", "time", "ns"),
        ("time_in_s", "time", "s"),
        ("acc_g", "acceleration", "g"),
        ("force_kgf", "force", "kgf"),
        ("force_lbf", "force", "lbf"),
        ("trq_inlb", "force", "lbf*in"),
        ("trq_N_mm", "force", "N*mm"),
        ("TORQUE_NM", "force", "N*m"),
        ("IQ_MA", "current", "mA"),
        ("pos_inch", "position", "inch"),
        ("vel_in_s", "velocity", "in/s"),
        ("vel_mm_min", "velocity", "mm/min"),
        ("VEL_MM_S", "velocity", "mm/s"),
    ],
)
def test_units_at_the_end_of_a_name_are_read(header: str, quantity: str, unit: str) -> None:
    found = described_column(header, 20 * np.sin(np.linspace(0, 9, 99)))
    assert (found.quantity, found.unit, found.stated) == (quantity, unit, True)


def test_the_end_of_an_unknown_unit_is_no_unit_of_the_time() -> None:
    found = described_column("vel_ell_s", 20 * np.sin(np.linspace(0, 9, 99)))
    assert (found.quantity, found.stated) == ("velocity", False)


@pytest.mark.parametrize(
    ("header", "quantity", "reason"),
    [
        ("enc_cnt", "position", "its unit is cnt, of unknown length"),
        ("pos_ticks", "position", "its unit is ticks, of unknown length"),
        ("vel_cts_s", "velocity", "its unit is cts/s, of unknown size"),
        ("iq_lsb", "current", "its unit is lsb, of unknown size"),
        ("pos_in", "position", "may be inches or an input"),
        ("force_kg", "force", "is a mass, or the force that it weighs"),
        ("FORCE_MN", "force", "stands for several units"),
        ("encoder", "position", "it may be in counts"),
    ],
)
def test_counts_and_units_in_doubt_are_asked_for(header: str, quantity: str, reason: str) -> None:
    found = described_column(header, 20 * np.sin(np.linspace(0, 9, 99)))
    assert (found.quantity, found.unit, found.stated, found.scaled) == (quantity, None, False, True)
    assert reason in found.reason


@pytest.mark.parametrize("remark", ["# page 2", "% page 2;;", "// page 2"])
def test_remarks_between_values_are_passed_over(tmp_path: Path, remark: str) -> None:
    file = written(tmp_path / "log.csv", "t;q;F", "{t:.3f};{q:.9f};{F:.9f}")
    lines = file.read_text().splitlines()
    file.write_text("\n".join([*lines[:20], "", remark, *lines[20:40], remark, *lines[40:]]))
    check(read_log(file, expected=EXPECTED, layout=layout_found(file)))


@pytest.mark.parametrize("resample", [None, "own"])
def test_rows_of_which_the_last_comes_first_are_turned_round(tmp_path: Path, resample: str | None) -> None:
    file = written(tmp_path / "log.csv", "t,q,F", "{t:.3f},{q:.9f},{F:.9f}")
    head, *rows = file.read_text().splitlines()
    file.write_text("\n".join([head, *reversed(rows)]))
    log = read_log(file, expected=EXPECTED, resample=resample)
    assert log.n_samples == T.size
    assert "the times fall: the order of the rows was reversed" in log.notes
    assert log["q"] == pytest.approx(Q, abs=1e-5)


def test_a_share_in_cells_is_in_percent(tmp_path: Path) -> None:
    file = written(tmp_path / "log.csv", "t,pos,torque", "{t:.3f} s,{q:.9f} m,{F:.9f} %")
    table = open_table(file, layout_found(file))
    assert [(c.quantity, c.unit) for c in foreign_columns(table)][2] == ("percent", "%")
    assert table.read([2])[0] == pytest.approx(F, abs=1e-8)


@pytest.mark.parametrize(
    ("values", "bits"),
    [
        (np.round(3000 * np.sin(60 * T)) % 65536, 16),
        (np.round(30 * np.sin(60 * T)) % 256, 8),
        (np.round(127 + 120 * np.sin(60 * T)), 0),  # an unsigned number
        (np.round(40_000 * np.sin(60 * T)) % 65536, 0),  # a counter that overflows
        (np.where(np.sin(60 * T) > 0, 250.0, 2.0), 0),  # a switched one
    ],
)
def test_signed_numbers_that_were_read_as_unsigned_are_doubted(values: np.ndarray, bits: int) -> None:
    doubt = described_column("torque", values).doubt
    assert (f"signed numbers of {bits} bits" in doubt) == bool(bits)
    assert bool(doubt) == bool(bits)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("resample", [None, "own"])
def test_numbers_near_the_end_of_the_range_are_one_fault(tmp_path: Path, resample: str | None) -> None:
    rows = [
        f"{t:.3f},{1e308 * (-1) ** k if k in (30, 31) else q:.9g},{f}"
        for k, (t, q, f) in enumerate(zip(T, Q, F, strict=True))
    ]
    (tmp_path / "log.csv").write_text("\n".join(["t,q,F", *rows]))
    with pytest.raises(LogError, match=r"'q' (jumps|has a value)"):
        read_log(tmp_path / "log.csv", expected=EXPECTED, resample=resample)
