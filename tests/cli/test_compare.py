"""`symid compare` against differences computed by hand, and what it reads."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from command_line import run
from scipy.stats import chi2


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def recording(mass: float, seed: int, file: str) -> None:
    """M a + 3 v + 2 sign v, by hand."""
    t = np.arange(6000) / 1000
    q = 0.1 * np.sin(9 * t) + 0.02 * np.sin(23 * t)
    v, a = 0.9 * np.cos(9 * t) + 0.46 * np.cos(23 * t), -8.1 * np.sin(9 * t) - 10.58 * np.sin(23 * t)
    noise = 0.5 * np.random.default_rng(seed).standard_normal(t.size)
    pl.DataFrame({"t": t, "q": q, "F": mass * a + 3 * v + 2 * np.sign(v) + noise}).write_csv(file)


def identified(mass: float, seed: int, name: str, *options: str) -> dict:
    recording(mass, seed, f"{name}.csv")
    assert run("identify", "rigid_1m", f"{name}.csv", "--json", f"{name}.json", *options) == 0
    return json.loads(Path(f"{name}.json").read_text(encoding="utf-8"))


def compared(*files: str) -> dict:
    assert run("compare", *files, "--json", "out.json") == 0
    return json.loads(Path("out.json").read_text(encoding="utf-8"))


def test_another_mass_differs_and_the_same_does_not(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    a, b, c = (
        identified(mass, seed, name, "--cutoff", cutoff)
        for mass, seed, name, cutoff in ((5.0, 3, "a", "30"), (5.0, 4, "b", "30"), (5.5, 5, "c", "60"))
    )
    same, other = compared("a.json", "b.json"), compared("a.json", "c.json")
    capsys.readouterr()
    assert [one["differs"] for one in same["parameters"].values()] == [False, False, False]
    assert other["parameters"]["M"]["differs"]
    assert not same["together"]["differs"]
    assert other["together"]["differs"]
    assert other["settings"]["cutoff_hz"] == [30.0, 60.0]
    mass = other["parameters"]["M"]
    first, second = a["physical"]["M"], c["physical"]["M"]
    assert mass["difference"] == pytest.approx(second["value"] - first["value"])
    spread = np.hypot(first["std_corrected"], second["std_corrected"])
    assert mass["deviations"] == pytest.approx((second["value"] - first["value"]) / spread)
    difference = np.array([b["physical"][n]["value"] - a["physical"][n]["value"] for n in a["physical"]])
    covariance = np.array(a["covariance"]["physical"]) + np.array(b["covariance"]["physical"])
    square = float(difference @ np.linalg.inv(covariance) @ difference)
    assert same["together"]["chi_square"] == pytest.approx(square, rel=1e-6)
    assert same["together"]["probability"] == pytest.approx(chi2.sf(square, 3), rel=1e-6)
    assert run("compare", "a.json", "c.json") == 0
    said = capsys.readouterr().out
    assert "differs" in said
    assert "setting cutoff_hz" in said


def test_values_without_deviations_are_compared_too(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("p.json").write_text('{"M": 4.0, "Fv": 0.0, "more": 1}')
    Path("r.json").write_text('{"M": {"value": 5.0, "std": 0.25, "unit": "kg"}, "Fv": 1.0}')
    record = compared("p.json", "r.json")
    assert record["parameters"]["M"] == {
        "a": {"value": 4.0, "std": None},
        "b": {"value": 5.0, "std": 0.25},
        "difference": 1.0,
        "relative": 0.25,
        "deviations": 4.0,
        "differs": True,
        "unit": "kg",
    }
    assert record["only_in"] == [["more"], []]
    assert record["together"] is None
    assert run("compare", "p.json", "r.json") == 0
    assert "only in p.json: more" in capsys.readouterr().out


def test_a_diagnosis_counts_with_the_effects_it_found(folder: Path) -> None:
    change = {"unit": "kg", "nominal": 1.0, "reidentified": {"value": 2.0, "std": 0.1}}
    found = {**change, "explained": {"value": 3.0, "std": 0.2}}
    Path("d.json").write_text(json.dumps({"axis": "x", "verdict": "effect", "parameters": {"M": found}}))
    Path("n.json").write_text(json.dumps({"axis": "x", "parameters": {"M": change}}))
    assert compared("n.json", "d.json")["parameters"]["M"]["difference"] == 1.0


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("[]", "holds []"),
        ("{}", "holds no parameters"),
        ('{"K": 1}', "share no parameter"),
        ("{", "is not JSON"),
    ],
)
def test_mistakes_are_one_line(
    content: str, says: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("a.json").write_text('{"M": 1}')
    Path("b.json").write_text(content)
    assert run("compare", "a.json", "b.json") == 2
    said = capsys.readouterr().err
    assert says in said
    assert said.count("\n") == 1


def test_results_that_are_compared_are_not_overwritten(folder: Path) -> None:
    Path("a.json").write_text('{"M": 1}')
    assert run("compare", "a.json", "a.json", "--json", "a.json") == 2
    assert Path("a.json").read_text() == '{"M": 1}'
