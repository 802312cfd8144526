"""`symid identify` and `symid demo` from outside: JSON as promised, and one line for every mistake."""

import json
from functools import partial
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from command_line import run

from symid.diagnosis import LIBRARY, diagnose
from symid.report.figures.drawn import Drawn, save_figure

DATA = Path(__file__).parents[2] / "data"
PUBLISHED = [
    "--cutoff",
    "100",
    "--filter",
    "motion",
    "--decimation",
    "10",
    "--trim",
    "49,0",
    "--standstill",
    "0",
    "--differences",
    "2",
    "--ddof",
    "1",
]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Working folder with one good log and one for every kind of damage."""
    monkeypatch.chdir(tmp_path)
    t = np.arange(4000) / 1000
    q, v, a = 0.1 * np.sin(9 * t), 0.9 * np.cos(9 * t), -8.1 * np.sin(9 * t)
    good = {"t": t, "q": q, "F": 5 * a + 3 * v + 2 * np.sign(v)}
    tables = {
        "good": good,
        "units": {"t [ms]": 1000 * t, "q [mm]": 1000 * q, "F [kN]": good["F"] / 1000},
        "foreign": {"time": t, "pos": 1000 * q, "cur": good["F"] / 2},
        "wrong_unit": {"t": t, "q [N]": q, "F": good["F"]},
        "no_unit": {"t": t, "q [zz]": q, "F": good["F"]},
        "nan": {**good, "F": np.where(np.arange(4000) == 100, np.nan, good["F"])},
        "short": {name: values[:3] for name, values in good.items()},
        "constant": {**good, "q": np.zeros(4000)},
        "clocks": {**good, "t": np.concatenate([t[:2000], 2 + np.arange(2000) / 500])},
        "gap": {**good, "t": t + 0.5 * (np.arange(4000) > 1000)},
        "backward": {**good, "t": np.concatenate([t[:10], t[5:15], t[20:]])},
        "no_force": {"t": t, "q": q},
    }
    for name, table in tables.items():
        pl.DataFrame(table).write_csv(f"{name}.csv")
    lines = Path("good.csv").read_text().splitlines()
    lines[50] = "0.049,hello,3"
    Path("text.csv").write_text("\n".join(lines))
    Path("empty.csv").write_text("")
    Path("p.json").write_text("[1, 2]")
    Path("broken.parquet").write_bytes(b"PAR1 but not really")
    return tmp_path


def test_emps_by_the_command_of_the_readme(capsys: pytest.CaptureFixture[str]) -> None:
    logs = DATA / "emps"
    arguments = [
        str(logs / "DATA_EMPS.mat"),
        "--column",
        "q=qm",
        *PUBLISHED,
        "--validation",
        str(logs / "DATA_EMPS_PULSES.mat"),
    ]
    assert run("identify", "emps", *arguments, "--json", "-") == 0
    record = json.loads(capsys.readouterr().out)
    assert f"{record['physical']['M']['value']:.4f} {record['physical']['M']['std']:.4f}" == "95.1089 0.1085"
    assert record["samples"] == 2480
    assert f"{100 * record['validation']['residual']['F']['relative']:.4f}" == "5.9824"
    assert run("identify", "emps", *arguments) == 0
    shown = capsys.readouterr().out
    for digits in ("95.1089", "0.1085", "25.9883", "108.7569", "4.0834 %", "5.9824 %"):
        assert digits in shown


@pytest.mark.usefixtures("plain_pages")
def test_demo_needs_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of the library one effect is tried: the whole of it is in the demo of the wheel and in the code of README."""
    monkeypatch.chdir(tmp_path)
    asymmetry = [effect for effect in LIBRARY if effect.name == "asymmetric_friction"]
    monkeypatch.setattr("symid.cli.demo_command.diagnose", partial(diagnose, library=asymmetry))
    assert run("demo") == 0
    shown = capsys.readouterr().out
    assert "95.1089" in shown
    assert "asymmetric friction at motor" in " ".join(shown.split())
    assert "noise floor" in shown
    assert str(tmp_path / "emps_report.html") in shown.replace("\n", "")
    assert "</html>" in (tmp_path / "emps_report.html").read_text(encoding="utf-8")
    assert run("demo", "--report", "report.pdf") == 2


def test_json_has_the_promised_keys(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("identify", "rigid_1m", "good.csv", "--json", "out.json") == 0
    record = json.loads((folder / "out.json").read_text())
    promised = {
        "axis",
        "measured",
        "method",
        "log",
        "status",
        "message",
        "filter",
        "samples",
        "condition_number",
    }
    assert promised | {"minimal", "physical", "residual"} <= record.keys()
    assert {"cutoff_hz", "order", "decimation"} <= record["filter"].keys()
    assert {"value", "std", "relative_std_percent", "unit"} <= record["physical"]["M"].keys()
    assert {"rms", "relative", "unit"} <= record["residual"]["F"].keys()
    assert record["physical"]["M"]["value"] == pytest.approx(5, rel=1e-3)
    assert record["physical"]["Fv"]["unit"] == "N*s/m"


@pytest.mark.parametrize(
    "arguments",
    ["units.csv", "foreign.csv --column t=time --column q=pos --unit q=mm --column F=cur --gain F=2"],
)
def test_units_and_foreign_columns_give_the_same_parameters(folder: Path, arguments: str) -> None:
    assert run("identify", "rigid_1m", "good.csv", "--json", "a.json") == 0
    assert run("identify", "rigid_1m", *arguments.split(), "--json", "b.json") == 0
    a, b = (json.loads((folder / name).read_text())["physical"] for name in ("a.json", "b.json"))
    for name in a:
        assert a[name]["value"] == pytest.approx(b[name]["value"], rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("identify rigid_1m foreign.csv", "--column"),
        ("identify rigid_1m good.csv --column q=pos", "pos"),
        ("identify rigid_1m wrong_unit.csv", "converts to m"),
        ("identify rigid_1m no_unit.csv", "not known"),
        ("identify rigid_1m nan.csv", "t = 0.1 s"),
        ("identify rigid_1m short.csv", "3 samples"),
        ("identify rigid_1m constant.csv", "constant"),
        ("identify rigid_1m clocks.csv", "sampling period"),
        ("identify rigid_1m gap.csv", "gap"),
        ("identify rigid_1m backward.csv", "t"),
        ("identify rigid_1m text.csv", "'hello' in row 50"),
        ("identify rigid_1m empty.csv", "empty"),
        ("identify rigid_1m broken.parquet", "broken.parquet"),
        ("identify rigid_1m missing.csv", "no such file"),
        ("identify rigid_1m p.json", ".json"),
        ("identify rigid_1m no_force.csv", "F"),
        ("identify nowhere good.csv", "nowhere"),
        ("identify rigid_1m good.csv --cutoff 900", "500 Hz"),
        ("identify rigid_1m good.csv --cutoff high", "finite number"),
        ("identify rigid_1m good.csv --order 0", "order"),
        ("identify rigid_1m good.csv --decimation 0", "decimation"),
        ("identify rigid_1m good.csv --trim 3000", "trim"),
        ("identify rigid_1m good.csv --trim a,b", "--trim"),
        ("identify rigid_1m good.csv --gain q", "NAME=VALUE"),
        ("identify rigid_1m good.csv --fix M=5 --fix M=6", "--fix M is given as 5 and as 6: give it once"),
        ("identify rigid_1m good.csv --late q=1parsec", "parsec"),
        ("identify rigid_1m good.csv --late x=1us", "no signal 'x'"),
        ("identify rigid_1m good.csv --held x", "--held x is not the force"),
        ("identify rigid_1m good.csv --nominal p.json", "SI units"),
        ("identify rigid_1m good.csv --measured z", "choose from q"),
        ("identify rigid_1m good.csv --plot figure.doc", ".png"),
        ("identify rigid_1m good.csv --json nowhere/out.json", "nowhere/out.json"),
        ("identify rigid_1m", "Missing argument"),
        ("identify rigid_1m good.csv --wrong", "--wrong"),
        ("identfy rigid_1m good.csv", "identfy"),
    ],
)
def test_every_mistake_is_one_line_and_exit_2(
    folder: Path, arguments: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sorted(folder.iterdir())
    assert run(*arguments.split()) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.count("\n") == 1
    assert shown.err.startswith("symid: ")
    assert words in shown.err
    assert sorted(folder.iterdir()) == before


def test_a_figure_is_drawn(folder: Path) -> None:
    assert run("identify", "rigid_1m", "good.csv", "--validation", "units.csv", "--plot", "figure.svg") == 0
    assert (folder / "figure.svg").read_bytes().startswith(b"<?xml")


@pytest.mark.parametrize(("suffix", "head"), [("png", b"\x89PNG"), ("SVG", b"<?xml"), ("pdf", b"%PDF")])
def test_a_figure_is_of_the_kind_of_its_name(tmp_path: Path, suffix: str, head: bytes) -> None:
    figure = Drawn()
    figure.subplots().plot([0.0, 1.0])
    save_figure(figure, tmp_path / f"figure.{suffix}")
    assert (tmp_path / f"figure.{suffix}").read_bytes().startswith(head)


def test_a_validation_of_few_rows_judges_nothing(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = Path("good.csv").read_text().splitlines()
    Path("end.csv").write_text("\n".join([lines[0], *lines[-340:]]))
    assert run("identify", "rigid_1m", "good.csv", "--cutoff", "20", "--validation", "end.csv") == 0
    assert "rows of end.csv remain" in capsys.readouterr().out
    assert run("identify", "rigid_1m", "good.csv", "--cutoff", "20", "--validation", "good.csv") == 0
    assert "to judge the prediction" not in capsys.readouterr().out


def test_help_of_each_command_has_an_example(capsys: pytest.CaptureFixture[str]) -> None:
    for command in ("demo", "show", "generate", "identify"):
        assert run(command, "--help") == 0
        assert f"Example: symid {command}" in capsys.readouterr().out


@pytest.mark.usefixtures("plain_pages")
def test_output_error_on_the_command_line(tmp_path, capsys):
    values = {"M": 40.0, "Fv": 30.0, "Fs": 12.0}
    parameters, log = tmp_path / "P.json", tmp_path / "run.parquet"
    parameters.write_text(json.dumps(values))
    simulated = ["simulate", "rigid_1m", "--parameters", str(parameters), "-o", str(log), "--rate", "500"]
    assert run(*simulated, "--noise", "q=1e-7", "--noise", "F=0.5", "--travel", "0.1") == 0
    capsys.readouterr()
    figure = tmp_path / "run.png"
    options = [
        "--method",
        "oe",
        "--held",
        "F",
        "--validation",
        str(log),
        "--plot",
        str(figure),
        "--report",
        str(tmp_path / "run.html"),
        "--json",
        "-",
    ]
    assert run("identify", "rigid_1m", str(log), *options) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["status"] == "ok"
    assert record["method"] == "oe"
    assert record["force"]["course"] == "held"
    for name, value in values.items():
        found = record["physical"][name]
        assert abs(found["value"] - value) < 5 * found["std"] + 1e-3 * value
    assert record["noise"]["q"]["std"] == pytest.approx(1e-7, rel=0.3)
    assert record["residual"]["q"]["unit"] == "m"
    assert "q" in record["validation"]["residual"]
    assert figure.stat().st_size > 10_000
    assert f"{log} (validation)" in (tmp_path / "run.html").read_text(encoding="utf-8")
    assert run("identify", "rigid_1m", str(log), "--method", "oe", "--held", "F") == 0
    assert "noise found" in capsys.readouterr().out
