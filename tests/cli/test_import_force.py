"""The force of a foreign file: measured, or commanded where nothing else is recorded."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from command_line import run


@pytest.mark.parametrize(
    ("header", "gain", "words"),
    [
        ("Set torque [N]", [], "F is a command: no column seems to be a measured force"),
        ("TCMD[%]", ["--gain", "F=0.1"], "F is a command"),
        ("IL.FB (Arms)", ["--gain", "F=10"], "its unit is written, Arms"),
    ],
)
def test_the_only_force_is_taken_though_it_is_a_command(
    header: str,
    gain: list[str],
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    t = np.arange(1000) / 1000
    columns = {"t [ms]": 1e3 * t, "PosF[mm]": 100 * np.sin(9 * t), header: 40 * np.sin(9 * t)}
    pl.DataFrame(columns).write_csv("c.csv")
    assert run("import", "c.csv", "--axis", "rigid_1m", "-o", "m.json", *gain) == 0
    assert words in capsys.readouterr().out
    assert json.loads(Path("m.json").read_text(encoding="utf-8"))["columns"]["F"] == header
