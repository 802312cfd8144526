"""The trace of CODESYS, written by hand after what the controller exports."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import run

from symid.data import open_table
from symid.errors import LogError

N, PERIOD = 600, 0.002
T = PERIOD * np.arange(N)
Q = 0.05 * (1 - np.cos(8.0 * T))
F = 12.0 * 0.05 * 64.0 * np.cos(8.0 * T) + 3.0 * np.sign(np.sin(8.0 * T)) + 0.5


def trace(flags: int) -> str:
    """A trace of position, force and a truth value, with stamps in ms or us."""
    unit = 1e-6 if flags & 0x20 else 1e-3
    lines = ["[key]; [value]", "Version; 0x03050000", "Name; Application.Trace", "IecTaskName; MainTask"]
    lines += ["Condition.Name; ", "EveryNCycles; 1", "BufferEntries; 601", f"Flags; {flags}"]
    variables = {
        "PLC_PRG.axis.fActPosition": [f"{q:.9f}" for q in Q],
        "PLC_PRG.axis.fActForce": [f"{f:.6E}" for f in F],
        "PLC_PRG.bEnabled": ["TRUE"] * N,
    }
    for number, (name, values) in enumerate(variables.items()):
        lines += [
            f"{number}.Variable; {name}",
            f"{number}.Class; 14",
            f"{number}.YAxis; 0",
            f"{number}.Data; ",
        ]
        lines += [f"; {2 + round(t / unit)}; {value}" for t, value in zip(T, values, strict=True)]
    return "\n".join(lines) + "\n"


def trace_with_comma(flags: int) -> str:
    """The same with decimal commas in the values only."""
    lines = trace(flags).splitlines()
    return "\n".join(line.replace(".", ",") if line.startswith(";") else line for line in lines)


@pytest.mark.parametrize("flags", [0x10, 0x20, 0x11, 0x60])
@pytest.mark.parametrize("write", [trace, trace_with_comma])
def test_variables_and_clock_of_a_trace(tmp_path: Path, flags: int, write) -> None:  # type: ignore[no-untyped-def]  # one of two functions
    file = tmp_path / "axis.trace.csv"
    file.write_text(write(flags))
    table = open_table(file)
    assert table.headers == ("PLC_PRG.axis.fActPosition", "PLC_PRG.axis.fActForce", "PLC_PRG.bEnabled", "t")
    q, force, enabled, t = (np.asarray(column) for column in table.read(range(4)))
    np.testing.assert_allclose(t - t[0], T, atol=1e-9)
    np.testing.assert_allclose(q, Q, atol=1e-9)
    np.testing.assert_allclose(force, F, rtol=1e-6)
    assert enabled.tolist() == [1.0] * N


def test_from_trace_to_parameters(folder: Path) -> None:
    Path("x.csv").write_text(trace(0x20))
    named = ("--unit", "q=m", "--unit", "F=N")
    assert run("import", "x.csv", "--axis", "rigid_1m", *named, "-o", "m.json") == 0
    assert json.loads(Path("m.json").read_text())["columns"]["q"] == "PLC_PRG.axis.fActPosition"
    assert run("identify", "rigid_1m", "x.csv", "--mapping", "m.json", "--json", "f.json") == 0
    found = json.loads(Path("f.json").read_text())["physical"]
    assert found["M"]["value"] == pytest.approx(12.0, rel=0.02)


def test_trace_without_resolution_or_samples_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "axis.csv"
    file.write_text(trace(0x01))
    with pytest.raises(LogError, match=r"Flags \(1\) state no resolution of the time stamps: set ms or us"):
        open_table(file)
    file.write_text("\n".join(line for line in trace(0x10).splitlines() if not line.startswith(";")))
    with pytest.raises(LogError, match="no variable of the trace has samples"):
        open_table(file)
