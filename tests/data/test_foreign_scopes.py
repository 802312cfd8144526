"""Columns of traces of oscilloscopes and controllers: names, units and times in the layouts that they export."""

from pathlib import Path

import numpy as np
import openpyxl
import pytest

from symid.data import foreign_columns, guessed_layout, open_table

T = 5e-4 * np.arange(40)
Q = 0.2 * np.sin(30 * T)


def guessed(path: Path) -> dict[str, tuple[str | None, str | None]]:
    table = open_table(path, guessed_layout(path) if path.suffix in (".csv", ".txt") else None)
    return {column.header: (column.quantity, column.unit) for column in foreign_columns(table)}


def written(path: Path, head: list[str], row: str) -> Path:
    lines = [row.format(t=t, q=q, i=i) for i, (t, q) in enumerate(zip(T, Q, strict=True), start=1)]
    path.write_text("\n".join([*head, *lines]) + "\n")
    return path


def test_units_above_an_empty_line_are_joined(tmp_path: Path) -> None:
    head = ["Zeit;Kanal A;Kanal B", "(ms);(V);(mV)", ""]
    found = guessed(written(tmp_path / "pico.csv", head, "{t:.6f};{q:.6f};{q:.6f}"))
    assert found == {
        "Zeit [ms]": ("time", "ms"),
        "Kanal A [V]": ("voltage", "V"),
        "Kanal B [mV]": ("voltage", "mV"),
    }


def test_channels_of_one_name_are_numbered(tmp_path: Path) -> None:
    found = guessed(
        written(tmp_path / "k.csv", ["x-axis,1,2", "second,Volt,Volt"], "{t:.6f},{q:.6f},{q:.6f}")
    )
    assert list(found) == ["second", "Volt (1)", "Volt (2)"]


def test_labels_above_the_names_of_channels(tmp_path: Path) -> None:
    head = ["Model,MSO44", "Label,Position,Force", "TIME,CH1,CH2"]
    found = guessed(written(tmp_path / "tek.csv", head, "{t:.6e},{q:.6f},{q:.6f}"))
    assert found["Label [TIME]"] == ("time", "s")
    assert found["Position [CH1]"] == ("position", None)


def test_a_column_that_rises_evenly_is_no_position(tmp_path: Path) -> None:
    found = guessed(written(tmp_path / "lv.csv", ["X_Value,Position"], "{t:.6f},{q:.6f}"))
    assert found == {"X_Value": ("time", "s"), "Position": ("position", None)}


def test_numbers_of_samples_are_not_taken_for_milliseconds(tmp_path: Path) -> None:
    path = written(tmp_path / "hal.txt", [], "{i} {q:.6f} {q:.6f}")
    assert guessed(path)["column 1"] == ("time", None)


def test_samples_that_are_no_numbers_do_not_hide_what_a_column_is(tmp_path: Path) -> None:
    path = tmp_path / "daq.csv"
    current = [*["inf"] * 3, *["nan"] * 3, *range(T.size - 6)]
    rows = [f"{t:.6f},{q:.6f},{i}" for t, q, i in zip(T, Q, current, strict=True)]
    path.write_text("\n".join(["Time,Position [Millimeters],Current [Amps]", *rows]) + "\n")
    assert guessed(path) == {
        "Time": ("time", "s"),
        "Position [Millimeters]": ("position", "Millimeters"),
        "Current [Amps]": ("current", "Amps"),
    }


def test_increments_are_a_position_of_unknown_length(tmp_path: Path) -> None:
    path = written(tmp_path / "s.csv", ["Zeit;r482", "ms;Inkr"], "{t:.6f};{i}")
    (column,) = (c for c in foreign_columns(open_table(path, guessed_layout(path))) if "r482" in c.header)
    assert (column.quantity, column.unit, column.scaled) == ("position", None, True)


def test_letters_for_the_type_of_a_variable_count_least(tmp_path: Path) -> None:
    head = ['"Time";"fActPos";"fActForce"']
    row = '"12.03.2026 10:11:12.{i:06d}";"{q:.6f}";"{q:.5f}"'
    found = guessed(written(tmp_path / "c.csv", head, row))
    assert found["Time"] == ("time", "s")
    assert (found["fActPos"][0], found["fActForce"][0]) == ("position", "force")


def test_a_channel_that_stands_still_comes_last(tmp_path: Path) -> None:
    path = written(tmp_path / "two.csv", ["t,pos_y,pos_x"], "{t:.6f},0.0,{q:.6f}")
    columns = {c.header: c for c in foreign_columns(open_table(path, guessed_layout(path)))}
    assert (columns["pos_y"].quantity, columns["pos_y"].constant) == ("position", True)
    assert not columns["pos_x"].constant


def test_cells_of_a_sheet_that_are_text_are_numbers(tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    book.active.append(["Protokoll"])
    sheet = book.create_sheet("Messung")
    sheet.append(["Zeit [ms]", "Weg [mm]"])
    for t, q in zip(T, Q, strict=True):
        sheet.append([f"{1e3 * t:.1f}".replace(".", ","), f"{q:.6f}".replace(".", ",")])
    book.save(tmp_path / "p.xlsx")
    time, way = open_table(tmp_path / "p.xlsx").read([0, 1])
    assert np.asarray(time) == pytest.approx(1e3 * T, abs=0.051)
    assert np.asarray(way) == pytest.approx(Q, abs=1e-6)


def test_a_slower_channel_may_lack_every_other_sample(tmp_path: Path) -> None:
    rows = [f"{t:.6f};{q:.6f};{i if i % 2 else ''}" for i, (t, q) in enumerate(zip(T, Q, strict=True), 1)]
    path = tmp_path / "slow.csv"
    path.write_text("\n".join(["Time [s];Position [m];Current [A]", *rows]) + "\n")
    assert list(guessed(path)) == ["Time [s]", "Position [m]", "Current [A]"]
    (current,) = open_table(path, guessed_layout(path)).read([2])
    np.testing.assert_array_equal(current[::2], np.arange(1, T.size + 1, 2))
    assert np.isnan(current[1::2]).all()


def test_remarks_below_the_values_are_no_values(tmp_path: Path) -> None:
    path = written(tmp_path / "foot.csv", ["Zeit [s];Weg [mm];"], "{t:.6f};{q:.6f};")
    path.write_text(path.read_text() + "\nMesswerte: 40\n\nEnde;\n")
    assert guessed(path)["Weg [mm]"] == ("position", "mm")
    (q,) = open_table(path, guessed_layout(path)).read([1])
    np.testing.assert_allclose(q, Q, atol=1e-6)


@pytest.mark.parametrize("day", ["21.11.2026", "2026/11/21", "11/21/2026"])
@pytest.mark.parametrize("between", [";", " "])
def test_day_and_time_are_in_one_column_or_two(day: str, between: str, tmp_path: Path) -> None:
    head = f"Datum{between}Zeit;Position [mm]"
    path = written(tmp_path / "d.csv", [head], f"{day}{between}09:59:59.{{i:06d}};{{q:.6f}}")
    table = open_table(path, guessed_layout(path))
    times = [place for place, column in enumerate(foreign_columns(table)) if column.quantity == "time"]
    assert times == [int(between == ";")]
    (seconds,) = table.read(times)
    np.testing.assert_allclose(seconds, 1e-6 * np.arange(T.size), atol=1e-9)


def test_names_of_angles_and_their_derivatives_are_read(tmp_path: Path) -> None:
    names = ("theta", "theta_dot", "theta_ddot", "omega", "q_dot", "displacement")
    head = ",".join(("time", *names))
    row = ",".join(("{t:.6f}", *(["{q:.6f}"] * len(names))))
    found = guessed(written(tmp_path / "rig.csv", [head], row))
    wanted = ("position", "velocity", "acceleration", "velocity", "velocity", "position")
    assert tuple(found[name][0] for name in names) == wanted
