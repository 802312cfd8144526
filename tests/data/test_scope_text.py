"""Text of scopes, written by hand after what TwinCAT Scope and ControlDesk export."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import run

from symid.data import open_table, read_log
from symid.errors import LogError
from symid.units import Unit

EXPECTED = {"q": Unit.of("m"), "F": Unit.of("N")}
N, PERIOD = 600, 0.002
T = PERIOD * np.arange(N)
Q = 0.05 * (1 - np.cos(8.0 * T))
F = 12.0 * 0.05 * 64.0 * np.cos(8.0 * T) + 3.0 * np.sign(np.sin(8.0 * T)) + 0.5
NAMES = {"q": "Axis.ActPos", "F": "Axis.ActForce"}


def twincat(separator: str = "\t", *, comma: bool = False, unit: float = 1e3, clocks: bool = False) -> str:
    """Fifteen lines of properties, a column of times in ms for each channel; F every second sample if clocks differ."""
    step = 2 if clocks else 1
    channels = {"Axis.ActPos": (T, 1e3 * Q, 2), "Axis.ActForce": (T[::step], F[::step], 2 * step)}
    head = [
        "Name;Scope Project",
        "File;C:\\Traces\\x.svdx",
        "Starttime of export;133",
        "Endtime of export;134",
        "",
    ]
    properties = {
        "Name": list(channels),
        "SymbolComment": ["", ""],
        "Data-Type": ["REAL64", "REAL64"],
        "SampleTime[ms]": [str(ms) for *_, ms in channels.values()],
        "VariableSize": ["8", "8"],
        "SymbolBased": ["True", "True"],
        "IndexGroup": ["16448", "16448"],
        "SymbolName": list(channels),
        "NetID": ["5.1.2.3.1.1", "5.1.2.3.1.1"],
        "Port": ["851", "851"],
        "ScaleFactor": ["1", "1"],
    }
    lines = [line.replace(";", separator) for line in head]
    lines += [
        separator.join(x for value in values for x in (key, value)) for key, values in properties.items()
    ]
    lines.append("")
    for k in range(N):
        cells: list[str] = []
        for t, x, _ in channels.values():
            cells += [repr(float(unit * t[k])), repr(float(x[k]))] if k < t.size else ["", ""]
        line = separator.join(cells)
        lines.append(line.replace(".", ",") if comma else line)
    return "\r\n".join(lines) + "\r\n"


def control_desk() -> str:
    rows = zip(T.tolist(), (1e3 * Q).tolist(), F.tolist(), strict=True)
    lines = [
        "header_version,1.0",
        'type,"measurement"',
        "date,2026-11-21",
        "",
        "name,time,Model/Axis/q,Model/Axis/F",
        "unit,s,mm,N",
        "description,,position,force",
    ]
    for k, row in enumerate(rows):
        lines.append(",".join(["trace_values" if k == 0 else "", *map(repr, row)]))
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("name", "text", "encoding"),
    [
        ("tabs.csv", twincat(), "utf-8"),
        ("german.csv", twincat(";", comma=True), "cp1252"),
        ("wide.txt", twincat(), "utf-16"),
        ("seconds.csv", twincat(unit=1.0), "utf-8"),
        ("hundreds_of_ns.csv", twincat(unit=1e7), "utf-8"),
    ],
)
def test_twincat(name: str, text: str, encoding: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(text, encoding=encoding, newline="")
    assert open_table(path).headers == ("Axis.ActPos", "Axis.ActForce", "t")
    log = read_log(path, expected=EXPECTED, columns=NAMES, units={"q": "mm"})
    assert log.sampling_period == pytest.approx(PERIOD)
    np.testing.assert_allclose(log["q"], Q, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(log["F"], F, rtol=1e-12)


def test_control_desk(tmp_path: Path) -> None:
    path = tmp_path / "recording.csv"
    path.write_text(control_desk(), encoding="utf-8")
    assert open_table(path).headers == ("time [s]", "Model/Axis/q [mm]", "Model/Axis/F [N]")
    names = {"t": "time", "q": "Model/Axis/q", "F": "Model/Axis/F"}
    log = read_log(path, expected=EXPECTED, columns=names)
    assert log.sampling_period == PERIOD
    np.testing.assert_allclose(log["q"], Q, rtol=1e-12, atol=1e-15)
    np.testing.assert_array_equal(log["F"], F)


def test_clocks_that_differ_are_resampled_if_that_is_said(tmp_path: Path) -> None:
    path = tmp_path / "clocks.csv"
    path.write_text(twincat(clocks=True), encoding="utf-8")
    assert open_table(path).headers[2:] == ("t", "t of Axis.ActForce")
    with pytest.raises(LogError, match="'F' has other times than 'q': give `resample=own`"):
        read_log(path, expected=EXPECTED, columns=NAMES, units={"q": "mm"})
    log = read_log(path, expected=EXPECTED, columns=NAMES, units={"q": "mm"}, resample="own")
    assert log.sampling_period == pytest.approx(PERIOD)
    moves = np.abs(np.sin(8.0 * log.time)) > 0.1  # away from the steps of friction, which no spline follows
    true = 12.0 * 0.05 * 64.0 * np.cos(8.0 * log.time) + 3.0 * np.sign(np.sin(8.0 * log.time)) + 0.5
    assert np.max(np.abs(log["F"] - true)[moves]) < 0.2
    assert any("resampled to 500 Hz" in note for note in log.notes)


@pytest.mark.parametrize("kind", ["twincat", "control_desk"])
def test_from_import_to_parameters(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("x.csv").write_text(twincat() if kind == "twincat" else control_desk(), encoding="utf-8")
    assert run("import", "x.csv", "--axis", "rigid_1m", "-o", "m.json") == 0
    named = ("--column", "q=Axis.ActPos", "--unit", "q=mm") if kind == "twincat" else ()
    assert run("identify", "rigid_1m", "x.csv", "--mapping", "m.json", *named, "--json", "f.json") == 0
    found = json.loads(Path("f.json").read_text(encoding="utf-8"))["physical"]
    assert found["M"]["value"] == pytest.approx(12.0, rel=0.02)
    assert found["Fs"]["value"] == pytest.approx(3.0, rel=0.1)


@pytest.mark.parametrize("cut", [3, 9, 16, 17])
def test_scopes_without_values_are_one_line(cut: int, tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("\n".join(twincat().splitlines()[:cut]), encoding="utf-8")
    with pytest.raises(LogError, match=r"x\.csv: ") as caught:
        read_log(path, expected=EXPECTED, columns=NAMES)
    assert "\n" not in str(caught.value)
