"""`symid compare` against differences computed by hand, and what it reads."""

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from command_line import run
from scipy.stats import chi2

from symid.estimation.correlation import correlation_matrix
from symid.report.tables.number_text import with_deviation


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
    spread = np.hypot(first["deviation"], second["deviation"])
    assert mass["difference"] == pytest.approx({"value": second["value"] - first["value"], "std": spread})
    assert mass["deviations"] == pytest.approx((second["value"] - first["value"]) / spread)
    difference = np.array([b["physical"][n]["value"] - a["physical"][n]["value"] for n in a["physical"]])
    covariance = np.zeros((3, 3))
    for one in (a, b):
        deviations = [p["deviation"] for p in one["physical"].values()]
        covariance += correlation_matrix(np.array(one["covariance"]["physical"])) * np.outer(
            deviations, deviations
        )
    square = float(difference @ np.linalg.inv(covariance) @ difference)
    assert same["together"]["chi_square"] == pytest.approx(square, rel=1e-6)
    assert same["together"]["probability"] == pytest.approx(chi2.sf(square, 3), rel=1e-6)
    assert run("compare", "a.json", "c.json") == 0
    printed = capsys.readouterr().out
    assert "differs" in printed
    assert "setting cutoff_hz" in printed


@pytest.mark.usefixtures("plain_pages")
def test_the_console_prints_the_deviation_of_page_and_comparison(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recording(5.0, 3, "a.csv")
    identify = ("identify", "rigid_1m", "a.csv", "--filter", "motion")  # which biases the mass
    assert run(*identify, "--json", "a.json", "--report", "a.html") == 0
    mass = json.loads(Path("a.json").read_text(encoding="utf-8"))["physical"]["M"]
    assert mass["deviation"] > 1.05 * mass["std_corrected"]
    capsys.readouterr()
    assert run(*identify) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    columns = next(line for line in lines if line[:2] == ["value", "deviation"])
    assert columns[2:] == ["%", "of", "value", "bias", "white", "std", "unit"]
    printed = next(line for line in lines if line[:1] == ["M"])
    assert printed[2] == f"{mass['deviation']:.4g}"
    shown = with_deviation(mass["value"], mass["deviation"])
    assert shown in Path("a.html").read_text(encoding="utf-8")


def test_values_without_deviations_are_compared_too(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("p.json").write_text('{"M": 4.0, "Fv": 0.0, "more": 1}')
    Path("r.json").write_text('{"M": {"value": 5.0, "std": 0.25, "unit": "kg"}, "Fv": 1.0}')
    record = compared("p.json", "r.json")
    assert record["parameters"]["M"] == {
        "a": {"value": 4.0, "std": None},
        "b": {"value": 5.0, "std": 0.25},
        "difference": {"value": 1.0, "std": 0.25},
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
    assert compared("n.json", "d.json")["parameters"]["M"]["difference"]["value"] == 1.0


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
    printed = capsys.readouterr().err
    assert says in printed
    assert printed.count("\n") == 1


def test_the_page_holds_both_results_side_by_side(folder: Path) -> None:
    residual = {"F": {"rms": 0.25, "unit": "N"}}
    first = {
        "axis": "rigid_1m",
        "log": ["a<b.csv"],
        "measured": ["q"],
        "physical": {"M": {"value": 4.0, "std": 0.1, "unit": "kg"}, "Fv": {"value": 0.0, "unit": "N*s/m"}},
        "residual": residual,
        "validation": {"residual": residual},
    }
    gap = {
        "signal": "F",
        "unit": "N",
        "nominal": None,
        "explained": {"rms": 0.75},
        "reidentified": {"rms": 1.5},
    }
    effect = {"effect": "stribeck_friction", "at": "motor"}
    other = {"M": 5.0, "more": 1}
    second = {"axis": "rigid_1m", "verdict": "effect", "gap": gap, "effects": [effect], "parameters": other}
    Path("a.json").write_text(json.dumps(first))
    Path("b.json").write_text(json.dumps(second))
    assert run("compare", "a.json", "b.json", "--report", "page.html", "--json", "out.json") == 0
    record = json.loads(Path("out.json").read_text())
    assert record["errors"]["rms of the residual of F on the validation"] == {
        "a": 0.25,
        "b": None,
        "unit": "N",
    }
    assert record["errors"]["error of F, with the effects found"] == {"a": None, "b": 0.75, "unit": "N"}
    page = Path("page.html").read_text(encoding="utf-8")
    assert "A and B differ in M" in page
    assert "Stribeck friction at motor" in page
    assert "a&lt;b.csv" in page
    assert "Only in A: Fv" in page
    assert "Only in B: more" in page
    assert page.count("<svg ") == 2  # for a desk and for a phone


@pytest.mark.parametrize(
    ("first", "second", "sentence"),
    [
        ({"value": 1.0, "std": 0.1}, {"value": 1.2, "std": 0.1}, "A and B do not differ"),
        (1.0, 2.0, "whether they differ is not known"),
        ({"value": 0.0, "std": 0.1}, {"value": 1.2, "std": 0.1}, "A and B differ in M"),
    ],
)
def test_the_page_begins_with_a_sentence(first: object, second: object, sentence: str, folder: Path) -> None:
    for name, entry in (("a.json", first), ("b.json", second)):
        Path(name).write_text(json.dumps({"M": entry}))
    assert run("compare", "a.json", "b.json", "--report", "page.html") == 0
    assert sentence in Path("page.html").read_text(encoding="utf-8")


def test_results_that_are_compared_are_not_overwritten(folder: Path) -> None:
    Path("a.json").write_text('{"M": 1}')
    assert run("compare", "a.json", "a.json", "--json", "a.json") == 2
    assert Path("a.json").read_text() == '{"M": 1}'


def test_a_covariance_beyond_all_numbers_leaves_out_the_test_of_the_whole(folder: Path) -> None:
    record = identified(5.0, 3, "a", "--cutoff", "30")
    record["covariance"]["physical"][2][1] = 1e308
    Path("huge.json").write_text(json.dumps(record), encoding="utf-8")
    assert compared("huge.json", "huge.json")["together"] is None
