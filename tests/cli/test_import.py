"""`symid import`: foreign files written by hand are guessed, declared as guesses, mapped and identified alike."""

import json
from pathlib import Path

import pytest
import scipy
from command_line import run
from recorded_run import PERIOD, TRUE, table

from symid import load_axis, read_axis_log
from symid.data import Layout, foreign_columns, guessed_layout, open_table
from symid.report.figures.colours import DARK

KT = 12.5  # N/A


def written(kind: str, log, folder: Path) -> str:
    t, q, F = log.time, log["q"], log["F"]
    if kind == "milliseconds":
        text = table({"Time (ms)": 1e3 * t, "Position [mm]": 1e3 * q, "I_q [A]": F / KT}, ";", comma=True)
        (folder / "a.csv").write_text(text, encoding="cp1252")
        return "a.csv"
    if kind == "microseconds":
        text = table({"Time": 1e6 * t, "CmdPos": 1e3 * q, "ActPos": 1e3 * q, "Motor Force (N)": F}, ",")
        (folder / "b.csv").write_text(text, encoding="utf-8")
        return "b.csv"
    if kind == "percent":
        above = "Scope;X axis\nRecorded;2026-11-21\nSampling interval: 1 ms\n\n"
        text = table({"Lage [µm]": 1e6 * q, "Torque %": 100 * F / 400.0, "Drehzahl [mm/s]": 0 * q}, "\t")
        (folder / "c.txt").write_text(above + text, encoding="utf-16")
        return "c.txt"
    scipy.io.savemat(folder / "d.mat", {"time": t, "pos_mm": 1e3 * q, "kraft": F, "note": "text"})
    return "d.mat"


KINDS = {
    "milliseconds": ("--gain 12.5", {"t": "ms", "q": "mm", "F": "N"}),
    "microseconds": ("", {"t": "us", "q": "mm", "F": "N"}),
    "percent": ("--rated 400", {"q": "um", "F": "N"}),
    "matlab": ("", {"q": "mm"}),
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_mapping_reads_the_foreign_file(
    kind: str, recorded, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options, units = KINDS[kind]
    file = written(kind, recorded, folder)
    if kind == "matlab":
        options = "--rate 1000"  # its time is in seconds, as 1 ms steps show; a rate is not used then
    arguments = ["--axis", "rigid_1m", *options.split(), "-o", "map.json", "--plot", "map.svg", "--dark"]
    assert run("import", file, *arguments) == 0
    shown = capsys.readouterr().out
    assert "check each" in shown
    assert DARK.paper.lower() in (folder / "map.svg").read_text().lower()
    mapping = json.loads((folder / "map.json").read_text())
    assert units.items() <= mapping["units"].items()
    assert len(mapping["guesses"]) >= 3
    assert (
        run("identify", "rigid_1m", file, "--mapping", "map.json", "--held", "F", "--json", "out.json") == 0
    )
    assert "map.json guesses: " in capsys.readouterr().err
    record = json.loads((folder / "out.json").read_text())
    assert sum("guessed in the mapping" in note for note in record["notes"]) == len(mapping["guesses"])
    for name, value in TRUE.items():
        assert record["physical"][name]["value"] == pytest.approx(value, rel=2e-2)


def test_guesses_that_were_checked_are_silent_and_late_is_used(
    recorded, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = written("microseconds", recorded, folder)
    assert run("import", file, "--axis", "rigid_1m", "-o", "map.json") == 0
    mapping = json.loads((folder / "map.json").read_text())
    (folder / "map.json").write_text(json.dumps({**mapping, "guesses": [], "late": {"F": -PERIOD / 2}}))
    capsys.readouterr()
    assert run("identify", "rigid_1m", file, "--mapping", "map.json", "--json", "late.json") == 0
    assert "guess" not in capsys.readouterr().err
    assert (
        run("identify", "rigid_1m", file, "--mapping", "map.json", "--late", "F=0", "--json", "now.json") == 0
    )
    late, now = (
        json.loads((folder / name).read_text())["physical"]["M"]["value"]
        for name in ("late.json", "now.json")
    )
    assert abs(late - TRUE["M"]) < abs(now - TRUE["M"])


@pytest.mark.parametrize(
    ("kind", "options", "words"),
    [
        ("milliseconds", "", "F has no factor: give --gain F in N per A"),
        ("percent", "", "per % (rated value / 100)"),
    ],
)
def test_what_nothing_identifies_is_missing_and_not_used(
    kind: str, options: str, words: str, recorded, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = written(kind, recorded, folder)
    assert run("import", file, "--axis", "rigid_1m", "-o", "map.json", *options.split()) == 0
    assert words in capsys.readouterr().out
    assert run("identify", "rigid_1m", file, "--mapping", "map.json") == 2
    err = capsys.readouterr().err
    assert words in err
    assert err.count("\n") == 1


def test_layouts_are_found(recorded, folder: Path) -> None:
    found = {kind: guessed_layout(folder / written(kind, recorded, folder)) for kind in list(KINDS)[:3]}
    assert found["milliseconds"] == Layout("utf-8-sig", ";", ",", 0, 0)
    assert found["microseconds"] == Layout("utf-8-sig", ",", ".", 0, 0)
    assert found["percent"] == Layout("utf-16", "\t", ".", 4, 0)


def test_setpoints_and_units_are_distinguished_from_names_and_values(recorded, folder: Path) -> None:
    columns = foreign_columns(open_table(folder / written("microseconds", recorded, folder)))
    assert [(c.quantity, c.unit, c.setpoint, c.stated) for c in columns] == [
        ("time", "us", False, False),
        ("position", "mm", True, False),
        ("position", "mm", False, False),
        ("force", "N", False, True),
    ]


@pytest.mark.parametrize("command", ["position demand", "goal_position", "Target pos"])
def test_a_commanded_position_is_not_taken_for_the_measured_one(
    command: str, recorded, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    q = 1e3 * recorded["q"]
    columns = {
        "time [ms]": 1e3 * recorded.time,
        f"{command} [mm]": q,
        "position [mm]": q,
        "F [N]": recorded["F"],
    }
    (folder / "a.csv").write_text(table(columns, ","), encoding="utf-8")
    assert run("import", "a.csv", "--axis", "rigid_1m", "-o", "m.json") == 0
    mapping = json.loads((folder / "m.json").read_text())
    assert mapping["columns"]["q"] == "position [mm]"
    assert mapping["columns"]["reference"] == f"{command} [mm]"
    assert "may as well" not in capsys.readouterr().out


def test_a_second_position_is_named_and_an_option_silences_the_guess(
    recorded, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    q = 1e3 * recorded["q"]
    columns = {
        "time [ms]": 1e3 * recorded.time,
        "pos 1 [mm]": 0 * q,  # stands still
        "pos 2 [mm]": q,
        "I [A]": recorded["F"] / KT,
    }
    (folder / "a.csv").write_text(table(columns, ","), encoding="utf-8")
    assert run("import", "a.csv", "--axis", "rigid_1m", "--gain", str(KT), "-o", "m.json") == 0
    assert "q may as well be column 'pos 1 [mm]'" in capsys.readouterr().out
    identify = ("identify", "rigid_1m", "a.csv", "--mapping", "m.json", "--held", "F", "--json", "o.json")
    assert run(*identify, "--column", "q=pos 2 [mm]", "--gain", f"F={KT}") == 0
    printed = capsys.readouterr().err
    assert "t is column 'time [ms]'" in printed
    assert "F is column 'I [A]'" in printed
    assert "pos 1" not in printed
    assert "N per A" not in printed


def test_a_drive_in_volts_takes_a_voltage(recorded, folder: Path) -> None:
    axis = """from symid import Axis, Body, Drive, Position, ViscousFriction
arm = Body("arm", inertia="J")
axis = Axis("servo", (arm, ViscousFriction(arm, "Fv")), Drive("u", arm, unit="V"), (Position("q", arm),))
"""
    (folder / "servo.py").write_text(axis)
    columns = {"timestamp": recorded.time, "angle [rad]": recorded["q"], "voltage [V]": recorded["F"]}
    (folder / "a.csv").write_text(table(columns, ","), encoding="utf-8")
    assert run("import", "a.csv", "--axis", "servo.py", "-o", "m.json") == 0
    mapping = json.loads((folder / "m.json").read_text())
    assert mapping["columns"]["u"] == "voltage [V]"
    assert not mapping["missing"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("import none.csv", "no such file"),
        ("import text.csv", "no columns of numbers"),
        ("import good.csv -o map.json", "-o needs --axis"),
        ("import good.csv --rate -1", "must be positive"),
        ("import good.csv --plot figure.doc", ".png"),
        ("import good.csv --axis nowhere", "nowhere"),
        ("identify rigid_1m good.csv --mapping wrong.json", "holds no mapping"),
        ("identify rigid_1m good.csv --mapping strange.json", "does not have"),
        ("identify rigid_1m good.csv --mapping layout.json", "separator"),
    ],
)
def test_mistakes_are_one_line(
    recorded, folder: Path, arguments: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "good.csv").write_text(table({"t": recorded.time, "q": recorded["q"], "F": recorded["F"]}, ","))
    (folder / "text.csv").write_text("a;b\n" + "one;two\n" * 20)
    (folder / "wrong.json").write_text('{"colums": {}}')
    (folder / "strange.json").write_text('{"columns": {"q7": "q"}}')
    (folder / "layout.json").write_text('{"layout": {"separator": ";;"}}')
    assert run(*arguments.split()) == 2
    err = capsys.readouterr().err
    assert words in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("header", "options", "unit", "gain"),
    [
        ("Moment [N*m]", "--gain 257", "N", 257.0),
        ("Moment [N*m]", "--gain F=257", "N", 257.0),
        ("Moment [mNm]", "--gain 0.257", "N", 0.257),
        ("Kraft [kN]", "--gain -1", "kN", -1.0),
        ("Kraft [CH2]", "--gain 50", "N", 50.0),
        ("Kraft [kN]", "", "kN", None),
        ("Kraft [kN]", "--rated 5", "kN", None),
    ],
)
def test_a_factor_that_is_given_is_used(
    header: str, options: str, unit: str, gain: float | None, recorded, folder: Path
) -> None:
    text = table({"t [s]": recorded.time, "Lage [m]": recorded["q"], header: recorded["F"]}, ";")
    (folder / "a.csv").write_text(text)
    assert run("import", "a.csv", "--axis", "rigid_1m", "-o", "map.json", *options.split()) == 0
    mapping = json.loads((folder / "map.json").read_text())
    assert (mapping["units"]["F"], mapping["gains"].get("F"), mapping["missing"]) == (unit, gain, [])
    assert any("rated value is not used" in guess for guess in mapping["guesses"]) is ("--rated" in options)
    assert run("identify", "rigid_1m", "a.csv", "--mapping", "map.json") == 0


def test_a_factor_of_a_reading_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("import", "a.csv", "--axis", "rigid_1m", "--gain", "q=-1") == 2
    assert "--gain q=-1: only that of a drive is asked here" in capsys.readouterr().err


def test_a_torque_is_no_force_without_a_factor(
    recorded, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = table({"t [s]": recorded.time, "Lage [m]": recorded["q"], "Moment [N*m]": recorded["F"]}, ";")
    (folder / "a.csv").write_text(text)
    assert run("import", "a.csv", "--axis", "rigid_1m", "-o", "map.json") == 0
    assert "F has no factor: give --gain F in N per N*m" in capsys.readouterr().out


def test_options_complete_a_mapping_that_lacks_something(
    recorded, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = {"Zeit [ms]": 1e3 * recorded.time, "enc": 5e6 * recorded["q"], "Strom [A]": recorded["F"] / KT}
    (folder / "a.csv").write_text(table(columns, ";"), encoding="utf-8")
    assert run("import", "a.csv", "--axis", "rigid_1m", "-o", "m.json") == 0
    identify = ("identify", "rigid_1m", "a.csv", "--mapping", "m.json")
    assert run(*identify) == 2
    assert "q" in capsys.readouterr().err
    assert run(*identify, "--column", "q=enc", "--unit", "q=0.2 um") == 2
    assert "F has no factor" in capsys.readouterr().err
    complete = (
        "--column",
        "q=enc",
        "--unit",
        "q=0.2 um",
        "--gain",
        f"F={KT}",
        "--held",
        "F",
        "--json",
        "f.json",
    )
    assert run(*identify, *complete) == 0
    found = json.loads(Path("f.json").read_text(encoding="utf-8"))["physical"]
    assert found["M"]["value"] == pytest.approx(TRUE["M"], rel=0.02)


def test_moments_are_seconds_and_a_number_in_brackets_is_a_channel(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A servo on a serial bus at 10 Hz: times of day, positions in counts, the motor in brackets."""
    load = [0, 12, 250, 387, 25, 1061, 1299, 1361, 1111, 1024]
    rows = [
        f"2025-11-09T09:27:{k / 10:06.3f}Z,{2000 + k},{1990 + k * k % 7},{load[k % 10]}" for k in range(100)
    ]
    (folder / "bus.csv").write_text("\n".join(["timestamp,goal pos (4),pos (4),load (4)", *rows]))
    options = ("--column", "F=load (4)", "--column", "q=pos (4)", "--unit", "q=100 counts/mm")
    options += ("--column", "reference=goal pos (4)", "--unit", "reference=100 counts/mm")
    assert run("import", "bus.csv", "--axis", "rigid_1m", "-o", "map.json", *options) == 0
    shown = capsys.readouterr().out
    assert "read in seconds" in shown
    assert "its unit '4'" not in shown
    assert (
        "F is column 'load (4)', whose values 0 to 387 and 1024 to 1361 look like sign and magnitude" in shown
    )
    mapping = json.loads((folder / "map.json").read_text())
    assert mapping["units"]["t"] == "s"
    names = {"columns": mapping["columns"], "units": mapping["units"]}
    log = read_axis_log(load_axis("rigid_1m"), "bus.csv", **names)
    assert log.sampling_period == pytest.approx(0.1)
    assert log["reference"][:2] == pytest.approx([0.02, 0.02001])
