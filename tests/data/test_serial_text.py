"""Text of serial monitors: values beside their names, with a time of day before each line or without."""

from pathlib import Path

import numpy as np
import pytest

from symid.data import foreign_columns, open_table
from symid.data.formats import layout_found

T = 1e-3 * np.arange(200)
Q = 40 * np.sin(30 * T)


def table_in(path: Path, lines: list[str], encoding: str = "utf-8") -> tuple[list[tuple], list[np.ndarray]]:
    path.write_bytes("\r\n".join(lines).encode(encoding))
    table = open_table(path, layout_found(path))
    columns = [(c.header, c.quantity, c.unit) for c in foreign_columns(table)]
    return columns, table.read(range(len(table.headers)))


@pytest.mark.parametrize(
    ("line", "headers"),
    [
        ("t:{us} pos:{q} pwm:{f}", ["t", "pos", "pwm"]),
        ("t={us}us, pos = {q}mm, force={f}N", ["t [us]", "pos [mm]", "force [N]"]),
        ("10:15:00.{ms:03d} -> time_us: {us}\tenc.pos: {q}\tu[0]: {f}", ["time_us", "enc.pos", "u[0]"]),
        ("[INFO] t={us} pos={q} out={f}", ["t", "pos", "out"]),
    ],
)
@pytest.mark.parametrize(("suffix", "encoding"), [(".log", "utf-8"), (".txt", "utf-16"), (".csv", "utf-8")])
def test_values_stand_beside_their_names(
    line: str, headers: list[str], suffix: str, encoding: str, tmp_path: Path
) -> None:
    rows = [line.format(us=k * 1000, ms=k, q=f"{q:.4f}", f=f"{2 * q:.3e}") for k, q in enumerate(Q.tolist())]
    lines = ["Booting", "IMU ok: 3", *rows[:100], "warning: late", *rows[100:], "done", ""]
    columns, values = table_in(tmp_path / f"a{suffix}", lines, encoding)
    assert [header for header, *_ in columns] == headers
    assert columns[0][1:] == ("time", "us")
    np.testing.assert_allclose(values[0], 1e6 * T)
    np.testing.assert_allclose(values[1], Q, atol=1e-4)
    np.testing.assert_allclose(values[2], 2 * Q, rtol=1e-3, atol=1e-3)


def test_moments_before_lines_are_the_time_where_no_name_is(tmp_path: Path) -> None:
    rows = [f"10:15:00.{k:03d} -> pos:{q:.4f} force:{2 * q:.4f}" for k, q in enumerate(Q.tolist())]
    columns, values = table_in(tmp_path / "a.log", rows)
    assert [quantity for _, quantity, _ in columns] == ["position", "force", "time"]
    np.testing.assert_allclose(values[2] - values[2][0], T, atol=1e-9)


def test_moments_before_values_without_names_are_a_column(tmp_path: Path) -> None:
    rows = [f"10:15:00.{k:03d} -> {q:.4f},{2 * q:.4f}" for k, q in enumerate(Q.tolist())]
    columns, values = table_in(tmp_path / "a.txt", rows)
    assert columns[2] == ("column 3", "time", "s")
    np.testing.assert_allclose(values[0], Q, atol=1e-4)


def test_a_table_below_properties_is_no_such_text(tmp_path: Path) -> None:
    rows = [f"{t:.3f};{q:.4f}" for t, q in zip(T, Q, strict=True)]
    columns, _ = table_in(
        tmp_path / "a.csv", ["Rate: 1000 Axis: 3", "Gain=2 Offset=1", "t [s];pos [mm]", *rows]
    )
    assert columns == [("t [s]", "time", "s"), ("pos [mm]", "position", "mm")]
