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


def grouped(*, stamps: bool = False, end: str = "", named_alone: bool = False, late: bool = False) -> str:
    """One column of times for all channels of a sample time, in ms or stamps of 100 ns, as Scope exports by default.

    The force is the first of two groups if `late`, and has only the first half of its samples.
    """
    groups = (
        [["Axis.ActForce"], ["Axis.ActPos", "Axis.SetPos"]] if late else [["Axis.ActPos", "Axis.ActForce"]]
    )
    values = {"Axis.ActPos": 1e3 * Q, "Axis.SetPos": 1e3 * Q, "Axis.ActForce": F[: N // 2] if late else F}
    units = {"Axis.ActPos": "mm (Length)", "Axis.SetPos": "mm (Length)", "Axis.ActForce": "(None)"}
    rows = {
        "Name": {name: name for name in values},
        "SampleTime[ms]": dict.fromkeys(values, "2"),
        "BitMask": dict.fromkeys(values, "0xffff"),
        "Unit": units,
    }
    above = [
        ["Name", "x"],
        ["Starttime of export", "132959733843760000", "Montag", "15:56:24.376"],
        [""],
        [""],
    ]
    for key, cells in list(rows.items())[: 1 if named_alone else None]:
        above.append([text for group in groups for text in (key, *(cells[name] for name in group))])
    times = [str(132959733843760000 + 20_000 * k) if stamps else f"{2 * k}" for k in range(N)]
    body = [
        [
            text
            for group in groups
            for there in [k < values[group[0]].size]
            for text in (
                [times[k], *(repr(float(values[name][k])) for name in group)]
                if there
                else [""] * (1 + len(group))
            )
        ]
        for k in range(N)
    ]
    return "\r\n".join("\t".join(row) for row in [*above, [""], *body]) + f"\r\n{end}"


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


@pytest.mark.parametrize(
    ("text", "headers", "rows"),
    [
        (grouped(), ("Axis.ActPos [mm]", "Axis.ActForce", "t"), N),
        (grouped(end="EOF\r\n"), ("Axis.ActPos [mm]", "Axis.ActForce", "t"), N),
        (grouped(stamps=True), ("Axis.ActPos [mm]", "Axis.ActForce", "t"), N),
        (grouped(named_alone=True), ("Axis.ActPos", "Axis.ActForce", "t"), N),
        (
            grouped(late=True),
            ("Axis.ActForce", "Axis.ActPos [mm]", "Axis.SetPos [mm]", "t", "t of Axis.ActPos"),
            N // 2,
        ),
    ],
    ids=["ms", "end of file", "stamps", "names alone", "shorter first"],
)
def test_channels_that_share_times(text: str, headers: tuple[str, ...], rows: int, tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text(text, encoding="utf-8-sig", newline="")
    assert open_table(path).headers == headers
    resample = "own" if rows < N else None
    log = read_log(path, expected=EXPECTED, columns=NAMES, units={"q": "mm"}, resample=resample)
    assert (log.n_samples, log.sampling_period) == (rows, pytest.approx(PERIOD, rel=1e-12))
    np.testing.assert_allclose(log["q"], Q[:rows], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(log["F"], F[:rows], rtol=1e-9)


def test_control_desk(tmp_path: Path) -> None:
    path = tmp_path / "recording.csv"
    path.write_text(control_desk(), encoding="utf-8")
    assert open_table(path).headers == ("time [s]", "Model/Axis/q [mm]", "Model/Axis/F [N]")
    names = {"t": "time", "q": "Model/Axis/q", "F": "Model/Axis/F"}
    log = read_log(path, expected=EXPECTED, columns=names)
    assert log.sampling_period == PERIOD
    np.testing.assert_allclose(log["q"], Q, rtol=1e-12, atol=1e-15)
    np.testing.assert_array_equal(log["F"], F)


def test_clocks_that_differ_are_resampled_on_request(tmp_path: Path) -> None:
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
def test_from_import_to_parameters(kind: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
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


def test_names_above_units_are_no_properties_of_a_scope(folder: Path) -> None:
    rows = "\n".join(
        f"{i};{t:.3f};{1e3 * q:.6f};{f:.4f}" for i, (t, q, f) in enumerate(zip(T, Q, F, strict=True))
    )
    path = folder / "x.csv"
    path.write_text(f"Name;Time;Position;Force\nUnit;s;mm;N\n{rows}\n", encoding="utf-8")
    assert run("import", "x.csv", "--axis", "rigid_1m", "-o", "m.json") == 0
    assert run("identify", "rigid_1m", "x.csv", "--mapping", "m.json", "--json", "f.json") == 0
    found = json.loads(Path("f.json").read_text(encoding="utf-8"))["physical"]
    assert found["M"]["value"] == pytest.approx(12.0, rel=0.02)
