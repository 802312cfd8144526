"""Text files whose numbers have marks of thousands, as spreadsheets write them."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from command_line import run

from symid.data import open_table, read_log
from symid.data.text_files.layout import guessed_layout
from symid.units import Unit

TIME = np.arange(400) / 1000
FORCE = np.round(2500 * np.sin(20 * TIME), 2)
WRITTEN: dict[str, tuple[str, str, Callable[[float], str]]] = {
    "german": (";", "{}", lambda x: f"{x:,.3f}".translate(str.maketrans(",.", ".,"))),
    "french": (";", "{}", lambda x: f"{x:,.3f}".translate(str.maketrans(",.", "\u202f,"))),
    "swiss": ("\t", "{}", lambda x: f"{x:,.3f}".replace(",", "'")),
    "english": (",", '"{}"', lambda x: f"{x:,.3f}"),
    "quoted comma": (",", '"{}"', lambda x: f"{x:.3f}".replace(".", ",")),
}


@pytest.mark.parametrize("kind", WRITTEN)
def test_marks_of_thousands_are_no_decimals(kind: str, tmp_path: Path) -> None:
    separator, quoted, number = WRITTEN[kind]
    lines = [separator.join(["t", "F [N]"])]
    lines += [separator.join(quoted.format(number(x)) for x in row) for row in zip(TIME, FORCE, strict=True)]
    file = tmp_path / "run.csv"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    assert read_log(file, expected={"F": Unit.of("N")})["F"] == pytest.approx(FORCE)
    t, force = open_table(file, guessed_layout(file)).read([0, 1])
    assert force == pytest.approx(FORCE)
    assert t == pytest.approx(TIME)


def test_whole_numbers_beside_decimal_commas(tmp_path: Path) -> None:
    whole = np.rint(FORCE)
    rows = (
        f"{t:.3f};{x:,.0f}".translate(str.maketrans(",.", ".,")) for t, x in zip(TIME, whole, strict=True)
    )
    file = tmp_path / "run.csv"
    file.write_text("t;F\n" + "\n".join(rows) + "\n")
    _, force = open_table(file, guessed_layout(file)).read([0, 1])
    assert force == pytest.approx(whole)


def test_a_mapping_goes_alone_to_the_standard_output(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = "\n".join(f"{t:.3f},{x / 1e5},{x}" for t, x in zip(TIME, FORCE, strict=True))
    Path("run.csv").write_text(f"t,q,F\n{rows}\n")
    assert run("import", "run.csv", "--axis", "rigid_1m", "-o", "-", "--json", "all.json") == 0
    assert json.loads(capsys.readouterr().out)["columns"] == {"t": "t", "q": "q", "F": "F"}
    assert run("import", "run.csv", "--axis", "rigid_1m", "-o", "-", "--json", "-") == 2
    assert "give one of them a file" in capsys.readouterr().err
