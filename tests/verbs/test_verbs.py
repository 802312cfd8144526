"""An axis, its name or a model, with logs, files or frames: the same result, derived on the spot where needed."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from command_line import run
from fleet_logs import TRUE, write_log

import symid
from symid.axis import shipped_folder
from symid.errors import SettingError, SymidError
from symid.fleet.batch_settings import BatchSettings
from symid.fleet.plan import fleet_axes
from symid.simulation import plant_of


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write_log(Path("a.csv"), 1)
    return tmp_path


def own(friction: str = "Fv") -> symid.Axis:
    body = symid.Body("body", mass="M")
    laws = (body, symid.ViscousFriction(body, friction), symid.CoulombFriction(body, "Fs"))
    return symid.Axis("own_verbs", laws, symid.Drive("F", body), (symid.Position("q", body),))


def test_all_ways_of_naming_an_axis_and_a_log_are_alike(folder: Path) -> None:
    axis, frame = symid.load_axis("rigid_1m"), pd.read_csv("a.csv")
    log = symid.read_axis_log(axis, "a.csv")
    found = [
        symid.identify(given, source).physical_parameters
        for given in ("rigid_1m", axis, symid.load_generated("rigid_1m"), symid.derive("rigid_1m"))
        for source in (log, "a.csv", Path("a.csv"), frame, [frame], {name: frame[name] for name in frame})
    ]
    assert all(one == found[0] for one in found)
    assert found[0] == pytest.approx(TRUE, rel=0.02)


def test_an_axis_without_module_is_derived_once(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = symid.identify(own("Fvisc"), "a.csv")
    assert found.physical_parameters["Fvisc"] == pytest.approx(TRUE["Fv"], rel=0.05)
    monkeypatch.setattr(
        "symid.codegen.generation.module.module_text", lambda *_: pytest.fail("derived again")
    )
    assert symid.identify(own("Fvisc"), "a.csv").status == found.status
    assert not (folder / "generated").exists()


def test_the_command_line_needs_no_generate(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("new", "line", "--bodies", "1") == 0
    source = Path("models/line.py").read_text(encoding="utf-8")
    axis = symid.load_axis("line")
    columns = [f"--column={axis.drive.signal}=F", f"--column={axis.sensors[0].signal}=q"]
    assert run("identify", "line", "a.csv", *columns) == 0
    assert run("batch", "line", "a.csv", "-o", "r.parquet", "--jobs", "1", *columns) == 0
    assert "rows: r.parquet" in capsys.readouterr().out
    assert (Path("models/line.py").read_text(encoding="utf-8"), Path("generated").exists()) == (source, False)


def test_a_stale_module_is_not_used(folder: Path) -> None:
    assert run("new", "aged", "--bodies", "1") == 0
    assert run("generate", "aged") == 0
    text = Path("models/aged.py").read_text(encoding="utf-8")
    changed = text.replace('mass="', 'mass="new')
    Path("models/aged.py").write_text(changed, encoding="utf-8")
    assert changed != text
    axis = symid.load_axis("aged")
    with pytest.raises(SymidError, match="older than the declaration"):
        symid.load_generated("aged")
    frame = pd.read_csv("a.csv").rename(columns={"F": axis.drive.signal, "q": axis.sensors[0].signal})
    assert set(symid.identify("aged", frame).physical_parameters) == set(axis.physical_parameters)


def test_diagnose_takes_names_and_frames(folder: Path) -> None:
    axis, log = symid.load_axis("rigid_1m"), symid.read_axis_log("rigid_1m", "a.csv")
    given = {"nominal": TRUE, "library": ()}
    by_name = symid.diagnose("rigid_1m", pd.read_csv("a.csv"), validation="a.csv", **given)
    by_log = symid.diagnose(axis, log, validation=log, **given)
    for name in ("nominal", "reidentified"):
        assert getattr(by_name.gap, name).rms == pytest.approx(getattr(by_log.gap, name).rms)
    assert by_log.axis == axis
    several = symid.diagnose(axis, ["a.csv", "a.csv"], **given)
    assert several.gap.reidentified.rms == pytest.approx(by_log.gap.reidentified.rms)


def test_diagnose_of_a_declaration_needs_no_nominal_values(folder: Path) -> None:
    axis = own("Fbegins")
    log = symid.read_axis_log(axis, "a.csv")
    for found in (symid.diagnose(axis, "a.csv"), symid.diagnose(axis, log)):
        values = {change.name: change.reidentified for change in found.parameters}
        assert values["M"] == pytest.approx(TRUE["M"], rel=0.02)


def test_results_are_frames(folder: Path) -> None:
    table = symid.identify("rigid_1m", "a.csv").to_frame()
    assert table.columns == ["kind", "name", "value", "std", "unit"]
    assert table.filter(kind="physical")["name"].to_list() == ["M", "Fv", "Fs"]
    assert symid.identify_batch("rigid_1m", "a.csv", jobs=1).to_frame().height == 1


@pytest.mark.parametrize("given", [5, None, ["rigid_1m"]])
def test_what_is_no_axis_is_refused(given: object) -> None:
    with pytest.raises(SettingError, match="is not an axis"):
        symid.derive(given)
    with pytest.raises(SymidError):
        symid.identify("no_axis", {"t": [0.0]})


@pytest.mark.parametrize("log", ["a.csv", "read"])
@pytest.mark.parametrize(
    ("verb", "setting", "says"),
    [
        (symid.identify, {"cutoff": 30.0}, r"preparation=Preparation\(cutoff_hz=\.\.\.\)"),
        (symid.identify, {"layuot": None}, "no setting 'layuot'.* columns, units"),
        (symid.diagnose, {"column": {"q": "x"}}, "no setting 'column'"),
    ],
)
def test_a_setting_that_does_not_exist_is_refused(
    verb: Callable[..., object], setting: dict[str, object], says: str, log: str, folder: Path
) -> None:
    given = symid.read_axis_log("rigid_1m", "a.csv") if log == "read" else log
    for axis in (
        ("rigid_1m", symid.load_generated("rigid_1m", ("q",))) if verb is symid.identify else ("rigid_1m",)
    ):
        with pytest.raises(SettingError, match=says):
            verb(axis, given, **setting)


def test_a_log_has_no_columns_to_map(folder: Path) -> None:
    with pytest.raises(SettingError, match="'columns' is for files and frames"):
        symid.identify("rigid_1m", symid.read_axis_log("rigid_1m", "a.csv"), columns={"q": "x"})


def test_what_is_predicted_is_shown_in_a_line(folder: Path) -> None:
    assert len(repr(symid.identify("rigid_1m", "a.csv").predict("a.csv"))) < 400


def test_what_is_typed_says_so() -> None:
    assert (Path(symid.__file__).parent / "py.typed").is_file()


def test_there_is_one_version() -> None:
    root = Path(__file__).parents[2]
    assert f"version: {symid.__version__}" in (root / "CITATION.cff").read_text(encoding="utf-8")
    assert symid.__version__ not in (root / "pyproject.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize("still", ["q", "F"])
def test_a_constant_channel_of_a_log_is_refused_as_that_of_a_file(folder: Path, still: str) -> None:
    frame = pd.read_csv("a.csv")
    frame[still] = 0.25
    frame.to_csv("still.csv", index=False)
    signals = {name: frame[name].to_numpy() for name in ("q", "F")}
    log = symid.Log.from_arrays(signals, sampling_period=float(frame["t"][1] - frame["t"][0]))
    for axis in ("rigid_1m", symid.load_generated("rigid_1m")):
        for given in (log, "still.csv"):
            for settings in ({}, {"method": "oe"}, {"fixed": {"Fs": 1.0}}):
                with pytest.raises(SymidError, match=f"'{still}' is constant"):
                    symid.identify(axis, given, **settings)


AXIS = symid.load_axis("rigid_1m")
WAYS = {
    "declaration": AXIS,
    "name": "rigid_1m",
    "path": shipped_folder("models") / "rigid_1m.py",
    "derived": symid.derive(AXIS),
    "generated": symid.load_generated(AXIS),
}


@pytest.mark.parametrize("way", WAYS)
def test_an_axis_is_welcome_in_every_form(way: str, tmp_path: Path) -> None:
    axis = WAYS[way]
    assert symid.compiled(axis).signature == symid.load_generated(axis).signature == AXIS.signature
    assert symid.axis_source(axis) == symid.axis_source(AXIS)
    assert symid.write_axis(axis, tmp_path / "copy.py").name == "copy"
    assert plant_of(axis, {"M": 2.0, "Fv": 3.0, "Fs": 4.0}).mass.tolist() == [[2.0]]
    assert symid.generate(axis) == []
    assert [one.axis for one in fleet_axes(axis, BatchSettings())] == [AXIS]


def test_an_axis_of_no_file_is_not_generated(folder: Path) -> None:
    body = symid.Body("table", mass="M")
    of_none = symid.Axis("of_none", (body,), symid.Drive("F", body), (symid.Position("q", body),))
    with pytest.raises(
        SettingError, match=r"declared in no file: write it with write_axis\(axis, 'models/of_none.py'\)"
    ):
        symid.generate(of_none)


def test_a_generated_model_shows_itself(folder: Path) -> None:
    model = symid.load_generated("rigid_1m", ("q",))
    assert repr(model) == "<GeneratedModel rigid_1m from q: parameters M, Fv, Fs>"
    assert "physical parameters: M [kg], Fv [N*s/m], Fs [N]" in model.summary()
    assert "rigid_1m" in model._repr_html_()
