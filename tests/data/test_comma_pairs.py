"""Files whose separators and decimal marks are both commas: read where the count of fields shows it, else refused."""

from pathlib import Path

import numpy as np
import pytest

from symid.data import foreign_columns, open_table, read_log
from symid.data.formats import layout_found
from symid.errors import LogError
from symid.units import Unit

EXPECTED = {"q": Unit.of("m"), "F": Unit.of("N")}
T = 1e-3 * np.arange(60)
Q, F = 0.01 * np.sin(50 * T), 3.0 * np.cos(70 * T)


def written(file: Path, header: str, *forms: str, below: str = "") -> Path:
    rows = [
        ",".join(form.format(x).replace(".", ",") for form, x in zip(forms, row, strict=True))
        for row in zip(T, Q, F, strict=True)
    ]
    file.write_text("\n".join([header, *rows, below]))
    return file


@pytest.mark.parametrize(
    ("header", "forms"),
    [
        ("t,q,F", ("{:.3f}", "{:.9f}", "{:.9f}")),
        ("t, q, F", ("{:.3f}", " {:.9f}", " {:.9f}")),
        ("t,q,F\n[s],[m],[N]", ("{:.3f}", "{:.8e}", "{:.8e}")),
        ("Recorded 3.4.\n\nt,q,F", ("{:.3f}", "{:.9f}", "{:.9f}")),
    ],
)
def test_every_second_comma_is_read_as_a_decimal_mark(
    tmp_path: Path, header: str, forms: tuple[str, ...]
) -> None:
    file = written(tmp_path / "log.csv", header, *forms)
    layout = layout_found(file)
    assert (layout.separator, layout.decimal) == (",", ",")
    log = read_log(file, expected=EXPECTED, layout=layout)
    assert log["q"] == pytest.approx(Q, abs=1e-8)
    assert log["F"] == pytest.approx(F, abs=1e-7)
    assert log.sampling_period == pytest.approx(1e-3)


def test_numbers_that_lack_their_fraction_are_refused_with_the_way_out(tmp_path: Path) -> None:
    file = written(tmp_path / "log.csv", "t,q,F", "{:.3f}", "{:.9f}", "{:.3g}")
    file.write_text(file.read_text().replace(",3,0\n", ",3\n"))
    with pytest.raises(LogError, match=r"below 3 names lines have 5 or 6 whole numbers .* with semicolons"):
        layout_found(file)


def test_a_line_with_fewer_fields_is_named(tmp_path: Path) -> None:
    form = ("{:.3f}", "{:.9f}", "{:.9f}")
    file = written(tmp_path / "log.csv", "t,q,F", *form, below="0,060,1,0,2")
    with pytest.raises(LogError, match="row 61 has 5 fields where 3 numbers with decimal commas have 6"):
        read_log(file, expected=EXPECTED, layout=layout_found(file))


def test_whole_numbers_are_not_joined(tmp_path: Path) -> None:
    rows = [f"{i},{7 * i % 11},{i * i},{i % 13}" for i in range(40)]
    (tmp_path / "log.csv").write_text("\n".join(["a,b,c,d", *rows]))
    table = open_table(tmp_path / "log.csv", layout_found(tmp_path / "log.csv"))
    assert [column.header for column in foreign_columns(table)] == ["a", "b", "c", "d"]


def test_such_a_file_is_not_read_by_the_first_fields(tmp_path: Path) -> None:
    file = written(tmp_path / "log.csv", "t,q,F", "{:.3f}", "{:.9f}", "{:.9f}")
    with pytest.raises(LogError, match=r"has 6 fields below 3 names.* symid import"):
        read_log(file, expected=EXPECTED)
