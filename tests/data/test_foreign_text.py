"""Text files as programs write them: lines of names and units, columns of texts, moments, words for missing values."""

import bz2
import gzip
import lzma
import zipfile
from pathlib import Path

import numpy as np
import pytest

from symid.data import foreign_columns, open_table
from symid.data.formats import layout_found
from symid.data.text_files.foreign import described_column
from symid.data.text_files.time_stamps import seconds_of_stamps
from symid.errors import LogError

T = 5e-4 * np.arange(40)
Q = 200 * np.sin(30 * T)


def columns_of(path: Path, encoding: str | None = None) -> dict[str, tuple[str | None, str | None]]:
    table = open_table(path, layout_found(path, encoding))
    return {column.header: (column.quantity, column.unit) for column in foreign_columns(table)}


def written(path: Path, head: str, row: str = "{t:.6f},{q:.6f},{q:.6f}", encoding: str = "utf-8") -> Path:
    lines = [row.format(t=t, q=q, i=i) for i, (t, q) in enumerate(zip(T, Q, strict=True), start=1)]
    path.write_bytes("\n".join([head, *lines, ""]).encode(encoding))
    return path


MEANT = [("time", "s"), ("position", "mm"), ("force", "N")]


@pytest.mark.parametrize(
    "head",
    [
        ",Axis 1,Axis 1\nTime [s],Position [mm],Force [N]",
        "Time,Position,Force\ns,mm,N\nclock,encoder,drive",
        "Time,Position,Force\ns,mm,N\n---,---,---",
        "s,mm,N\nTime,Position,Force",
        "Test 7,Axis X,\nTime,Position,Force\ns,mm,N",
        "% Time [s],Position [mm],Force [N]",
        "// by a program\n// Time [s],Position [mm],Force [N]",
        "s,mm,N",
        "Tempo [s],Posizione [mm],Forza [N]",
        "时间 (s),实际位置 (mm),推力 (N)",
    ],
)
def test_names_and_units_stand_in_several_lines(head: str, tmp_path: Path) -> None:
    assert list(columns_of(written(tmp_path / "a.csv", head)).values()) == MEANT


def test_names_in_columns_of_spaces_have_units_behind_a_space(tmp_path: Path) -> None:
    path = written(tmp_path / "a.txt", "% time [s]  position [mm]  force [N]", "{t:.6f}  {q:.6f} {q:.6f}")
    assert list(columns_of(path).values()) == MEANT


def test_columns_of_texts_stand_beside_the_numbers(tmp_path: Path) -> None:
    head = "exported,by,x,,\nTime [s],State,Position [mm],Force [N],Word"
    path = written(tmp_path / "a.csv", head, "{t:.6f},RUN,{q:.6f},{q:.6f},0x{i:X}")
    assert list(columns_of(path).values()) == MEANT
    (q,) = open_table(path, layout_found(path)).read([2])
    np.testing.assert_allclose(q, Q, atol=1e-6)


def test_a_remark_in_the_first_row_does_not_make_it_a_line_of_names(tmp_path: Path) -> None:
    path = written(tmp_path / "a.csv", "Time [s],Position [mm],Force [N],Event", "{t:.6f},{q:.6f},{q:.6f},")
    path.write_text(path.read_text().replace(",\n", ",start\n", 1))
    assert list(columns_of(path).values()) == MEANT
    (q,) = open_table(path, layout_found(path)).read([1])
    np.testing.assert_allclose(q, Q, atol=1e-6)


@pytest.mark.parametrize(
    ("header", "quantity", "setpoint", "scaled"),
    [
        ("s noml X [mm]", "position", True, False),
        ("actual_qd_0", "velocity", False, False),
        ("AIPos.A1", "position", False, False),
        ("MACur.A1", "current", False, False),
        ("Actual Velocity (0.1 counts/s)", "velocity", False, True),
        ("Position [units]", "position", False, True),
        ("_p_act (usr_p)", "position", False, True),
        ("Torque [raw]", "force", False, True),
        ("axis0.controller.input_pos", "position", True, False),
        ("Motor[1].DesPos", "position", True, False),
        ("RPOS(0) [deg]", "position", True, False),
        ("PositionCmptd1 [rad]", "position", True, False),
    ],
)
def test_names_of_controls_and_robots(header: str, quantity: str, setpoint: bool, scaled: bool) -> None:
    column = described_column(header, np.sin(np.arange(50.0)))
    assert (column.quantity, column.setpoint, column.scaled) == (quantity, setpoint, scaled)


@pytest.mark.parametrize("encoding", ["cp932", "euc_jp"])
def test_japanese_names_are_not_taken_for_another_alphabet(encoding: str, tmp_path: Path) -> None:
    head = "時間[ms],位置指令[deg],位置フィードバック[deg],トルク指令[%]"
    path = written(tmp_path / "a.csv", head, "{t:.6f},{q:.6f},{q:.6f},{q:.6f}", encoding)
    assert list(columns_of(path)) == head.split(",")


def test_whole_numbers_without_a_unit_are_not_taken_for_amperes() -> None:
    current = np.round(900 * np.sin(np.arange(80.0)))
    assert described_column("Present Current", current).scaled
    assert not described_column("Present Current", 0.01 * current).scaled


def test_names_without_a_latin_letter_tell_the_quantity(tmp_path: Path) -> None:
    path = written(tmp_path / "a.csv", "时间,指令位置,位置,推力", "{t:.6f},{q:.6f},{q:.6f},{q:.6f}", "gbk")
    assert [quantity for quantity, _ in columns_of(path, "gbk").values()] == [
        "time",
        "position",
        "position",
        "force",
    ]


@pytest.mark.parametrize(
    ("first", "second", "apart"),
    [
        ("21.11.26 10:00:00,001", "21.11.26 10:00:00,002", 0.001),
        ("11/21/2026 11:59:59 AM", "11/21/2026 12:00:01 PM", 2.0),
        ("1/2/26 9:59:59.5", "1/2/26 10:00:00.0", 0.5),
        ("31-Dec-2026 23:59:59", "01-Jan-2027 00:00:00", 1.0),
        ("10:00:00:250", "10:00:01:251", 1.001),
        ("9:59:59.5", "10:00:00.5", 1.0),
        ("59:59.5", "00:00.5", 1.0),
        ("0 days 00:00:59.5", "1 days 00:01:00", 86400.5),
        ("20261121T100000.5Z", "20261121T100001.5Z", 1.0),
        ("2026-11-21 10:00:00 UTC", "2026-11-21 10:00:00.25 UTC", 0.25),
        ("2026-11-21 10:00", "2026-11-21 10:01", 60.0),
        ("T#0ms", "T#250ms", 0.25),
        ("t#59s750ms", "T#1m0.25s", 0.5),
        ("TIME#1d_23h", "LTIME#2d_1s_5us", 3601.000005),
    ],
)
def test_moments_in_many_forms_are_seconds(first: str, second: str, apart: float) -> None:
    seconds = seconds_of_stamps([first, second])
    assert seconds is not None
    assert seconds.tolist() == [0.0, apart]


@pytest.mark.parametrize(
    "texts",
    [
        ["10:00:00", "10:00:00 PM"],
        ["12345678"] * 2,
        ["13:61:00"] * 2,
        ["10:00:00Z", "10:00:00+01:00"],
        ["x"],
        ["T#"] * 2,
        ["T#1s", "T#2"],
    ],
)
def test_other_texts_are_no_moments(texts: list[str]) -> None:
    assert seconds_of_stamps(texts) is None


def test_days_of_a_spreadsheet_are_a_time(tmp_path: Path) -> None:
    head = "Time,Position [mm]\n" + "\n".join(
        f"{46347.25 + t / 86400:.11f},{q:.6f}" for t, q in zip(T, Q, strict=True)
    )
    (tmp_path / "a.csv").write_text(head + "\n")
    assert columns_of(tmp_path / "a.csv")["Time"] == ("time", "day")


@pytest.mark.parametrize("word", ["#N/A", "---", "NULL", "1.#QNAN", "-nan(ind)", "Overflow", "?"])
def test_words_for_no_value_are_no_numbers(word: str, tmp_path: Path) -> None:
    path = written(tmp_path / "a.csv", "Time [s],Position [mm]", "{t:.6f},{q:.6f}")
    lines = path.read_text().splitlines()
    lines[20] = f"{T[19]:.6f},{word}"
    path.write_text("\n".join(lines) + "\n")
    (q,) = open_table(path, layout_found(path)).read([1])
    assert np.flatnonzero(np.isnan(q)).tolist() == [19]


@pytest.mark.parametrize("suffix", ["gz", "bz2", "xz", "zip"])
def test_compressed_text_of_any_name_is_read(suffix: str, tmp_path: Path) -> None:
    text = written(tmp_path / "a.csv", "Time [s],Position [mm],Force [N]").read_bytes()
    path = tmp_path / f"run.txt.{suffix}"
    if suffix == "zip":
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("run.csv", text)
    else:
        path.write_bytes({"gz": gzip, "bz2": bz2, "xz": lzma}[suffix].compress(text))
    assert list(columns_of(path).values()) == MEANT


def test_text_with_the_suffix_of_excel_is_read(tmp_path: Path) -> None:
    path = written(tmp_path / "a.xls", "Time [s]\tPosition [mm]\tForce [N]", "{t:.6f}\t{q:.6f}\t{q:.6f}")
    assert list(columns_of(path).values()) == MEANT


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"PAR1" + bytes(90), "is not text but a .parquet file"),
        (b"\x1f\x8b" + bytes(90), "is not text but a .gz file"),
        (b"<html><table>", "holds a page of HTML"),
        (b"\n\n", "is empty"),
        (b"t,q\n0,1\n1,2\n", "has fewer than 5 consecutive rows of numbers"),
        (b"\x81\x8d\xff\xff", "is not text in cp1252: give its `encoding`"),
    ],
)
def test_what_is_no_table_is_named(content: bytes, said: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(content)
    with pytest.raises(LogError, match=said):
        layout_found(tmp_path / "a.csv")


def test_names_that_hold_spaces_stand_above_columns_of_several_spaces(tmp_path: Path) -> None:
    head = "Scope\n\n Time [ms]   s actual X [mm]   I (int) X [A]"
    found = columns_of(written(tmp_path / "a.txt", head, "{t:12.6f} {q:14.6f} {q:14.6f}"))
    assert list(found) == ["Time [ms]", "s actual X [mm]", "I (int) X [A]"]


def test_units_may_stand_among_the_properties_above(tmp_path: Path) -> None:
    head = "LabVIEW Measurement\t\nY_Unit_Label\tmm\tN\nDelta_X\t0.0005\t0.0005\n\t\nX_Value\tPosition\tForce\tComment"
    found = columns_of(written(tmp_path / "a.lvm", head, "{t:.6f}\t{q:.6f}\t{q:.6f}"))
    assert list(found.values())[:3] == MEANT
