"""Drawing, sealing and answering of benchmarks/blind."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from click.testing import CliRunner

from benchmarks.blind import answers, draw, laws, plan, score, seal
from benchmarks.blind.__main__ import blind
from benchmarks.blind.axes import KINDS

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    """A set of one short case, an offset on a rigid axis, with its label."""
    folder = tmp_path_factory.mktemp("drawn")
    one = plan.Plan("case000", "single", "rigid", "rigid_1m", ("q",), (("offset_force", "motor"),), (1, 2))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(draw, "SECONDS", {"identification": 4.0, "validation": 3.0})
        label = plan.draw_case(one, folder)
    seal.close(folder, {"case000": label})
    return folder, label


@pytest.fixture(scope="module")
def rigid() -> draw.Setting:
    """A rigid axis on motions of 4 s."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(draw, "SECONDS", {"identification": 4.0, "validation": 4.0})
        return draw.draw_setting("rigid_1m", ("q",), np.random.default_rng(5))


def test_the_simulator_shares_nothing_with_symid():
    code = (
        "import sys, benchmarks.blind.__main__; print([m for m in sys.modules if m.split('.')[0] == 'symid'])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_kind_at_every_place_comes_in_turn():
    plans = [p for p in plan.plans(600, seed=3) if p.group == "single"]
    drawn = {(p.axis, p.sensors, *p.effects[0]) for p in plans}
    expected = {(a, s, *place) for a in KINDS for s in KINDS[a].sensors for place in laws.places(a, s)}
    assert drawn == expected
    assert {effect for _, _, effect, _ in expected} == set(laws.LAWS) - {"viscous_friction"}
    assert {p.group for p in plan.plans(40, seed=3)} == set(plan.SHARES)
    assert plan.plans(40, seed=3) == plan.plans(40, seed=3) != plan.plans(40, seed=4)


def test_a_set_is_confined_to_what_is_wished():
    wish = plan.Wish(
        kind="presliding_friction", at="motor", axes=("rigid_1m", "ballscrew_2m1s"), size=(1e-5, 2e-4)
    )
    plans = plan.plans(12, 3, wish)
    assert {p.effects for p in plans} == {(("presliding_friction", "motor"),)}
    assert {p.axis for p in plans} == set(wish.axes)
    assert {p.group for p in plan.plans(40, 3, plan.Wish(worldly=True))} == set(plan.WORLDLY)
    for wrong in ({"size": (1.0, 2.0)}, {"kind": "cogging", "size": (1.0, 2.0), "worldly": True}):
        with pytest.raises(ValueError, match="bounds of a size"):
            plan.Wish(**wrong)
    refused = CliRunner().invoke(blind, ["draw", "/nowhere", "--kind", "cogging", "--at", "structure"])
    assert refused.exit_code == 2
    assert "no axis has such an effect there" in refused.output


def test_a_case_is_written_without_its_label(drawn: tuple[Path, dict]):
    folder, label = drawn
    case = folder / "case000"
    assert {path.name for path in case.iterdir()} == {*answers.LOGS, "case.json", "nominal.json"}
    record = json.loads((case / "case.json").read_text())
    assert set(record) == {"model", "sampling_frequency_hz", "nominal", "controller", "columns"}
    log = pl.read_parquet(case / "identification.parquet")
    assert log.columns == list(record["columns"]) == ["t", "reference", "F", "q"]
    assert (log.height, pl.read_parquet(case / "validation.parquet").height) == (16_000, 12_000)
    assert np.abs(log["reference"].to_numpy() - log["q"].to_numpy()).max() < 5e-3
    errors = [abs(record["nominal"][name] / value - 1) for name, value in label["true"].items()]
    assert 0 < max(errors) <= 0.12
    assert label["effects"][0]["numbers"]["force"] > 0


def test_the_missing_force_by_hand_is_the_gap(rigid: draw.Setting):
    """A constant force on one mass: the ratio by a straight fit, differences and a running mean in place of `gap`."""
    offset = laws.draw("offset_force", "motor", np.random.default_rng(1)).sized(20.0)
    run = draw.simulate(rigid, (offset,), "validation", disturbed=False)
    v = run.velocity
    moving = np.convolve(np.abs(v) < 2e-3, np.ones(161), "same") == 0
    W = np.stack([np.gradient(v) * 4000, v, np.sign(v)], axis=1)[moving]
    missing = np.full(v.size, 20.0)[moving]
    left = missing - W @ np.linalg.lstsq(W, missing, rcond=None)[0]
    assert draw.gap_ratio(rigid, (offset,)) == pytest.approx(
        2 * draw.gap_ratio(rigid, (offset.sized(10),)), rel=0.02
    )
    noise = np.sqrt(np.mean(left**2)) / draw.gap_ratio(rigid, (offset,))
    band = rigid.noise["F"] * np.sqrt(2 * 100 / 4000)
    assert band < noise < 3 * band + rigid.true["M"] * (2 * np.pi * 100) ** 2 * 3e-7
    assert draw.gap_ratio(rigid, ()) < 0.2


def test_the_record_of_a_worldly_case_wanders_from_zero_in_whole_quanta(rigid: draw.Setting):
    rough, white = draw.wandering(rigid, np.random.default_rng(6)), rigid.noise["F"]
    readings = {"F": np.zeros(16_000), "q": np.zeros(16_000)}
    force = draw.measured(rough, readings, "identification")["F"] / rough.noise["quantum"]
    np.testing.assert_allclose(force, np.round(force), atol=1e-9)
    slow = force.reshape(-1, 200).mean(axis=1) * rough.noise["quantum"]  # means of 50 ms
    assert 0.5 < slow.std() / rough.noise["wander"] < 1.5
    assert abs(force[:20].mean() * rough.noise["quantum"]) < white
    assert np.diff(force).std() * rough.noise["quantum"] == pytest.approx(np.sqrt(2) * white, rel=0.1)
    assert not np.array_equal(draw.measured(rigid, readings, "identification")["F"], force)


def strength(setting: draw.Setting, effects: tuple[laws.Effect, ...]) -> float:
    """A gap-to-noise ratio in place of the simulated one: squares of relative sizes add up."""
    sizes = [effect.numbers[effect.size] / laws.LAWS[effect.effect].guess for effect in effects]
    return 5 * float(np.linalg.norm(sizes))


def test_a_worldly_case_has_one_strong_effect_and_three_small_ones(monkeypatch: pytest.MonkeyPatch):
    """Of them none is a delay: here it grows with what acts besides."""
    setting = draw.draw_setting("ballscrew_2m1s", ("qm", "ql"), np.random.default_rng(5))
    raised = {"delay": 6.0}
    monkeypatch.setattr(draw, "force_ratio", strength)
    monkeypatch.setattr(
        draw,
        "missing_square",
        lambda setting, effects: sum(
            (raised.get(e.effect, 1) * strength(setting, (e,))) ** 2 for e in effects
        ),
    )
    seen = set()
    for seed in range(40):
        one = plan.Plan(
            "case000",
            "worldly",
            "second sensor",
            setting.axis,
            setting.sensors,
            (("cogging", "load"),),
            (1, seed),
        )
        effects = plan._hidden(one, setting, np.random.default_rng(one.seed))
        assert (effects[0].effect, effects[0].at) == ("cogging", "load")
        assert len({effect.effect for effect in effects}) == 1 + plan.OTHERS
        strongest, *small = (strength(setting, (effect,)) for effect in effects)
        assert all(plan.SMALL[0] <= one / strongest <= plan.SMALL[1] for one in small)
        removed = draw.removed(setting, effects)
        assert removed["0"] == pytest.approx(strongest**2 / (strongest**2 + np.sum(np.square(small))))
        assert removed["0123"] == 1
        seen |= {effect.effect for effect in effects}
    assert "delay" not in seen
    assert len(seen) > 10


def test_what_an_effect_removes_is_its_share_of_the_square(rigid: draw.Setting):
    """Two forces at frequencies that share nothing: their squares add up."""
    wave = laws.draw("periodic_disturbance", "motor", np.random.default_rng(1))
    waves = tuple(
        replace(wave, numbers=wave.numbers | {"force": force, "frequency": hertz})
        for force, hertz in ((20.0, 23.0), (8.0, 37.0))
    )
    large, small = (draw.missing_square(rigid, (wave,)) for wave in waves)
    assert small / large == pytest.approx((8 / 20) ** 2, rel=0.1)
    assert draw.removed(rigid, waves) == {"0": pytest.approx(large / (large + small), abs=0.03), "01": 1}


def test_labels_stay_sealed_until_all_is_answered(drawn: tuple[Path, dict], tmp_path: Path):
    labels = {"case000": drawn[1]}
    (tmp_path / "case000").mkdir()
    first = seal.close(tmp_path, labels)
    assert b"offset" not in (tmp_path / seal.SEALED).read_bytes()
    assert seal.close(tmp_path, labels) != first, "the nonce is fresh"
    with pytest.raises(PermissionError, match="1 cases"):
        seal.open_labels(tmp_path)
    (tmp_path / "answers").mkdir()
    (tmp_path / "answers" / "case000.json").write_text("{}")
    assert seal.open_labels(tmp_path) == labels


@pytest.mark.parametrize(
    ("code", "ended"),
    [
        ("import os, json; print(json.dumps(sorted(os.listdir())))", "exit 0"),
        ("import sys; sys.exit('no such thing')", "exit 1 no such thing"),
        ("print('{')", "exit 0"),
    ],
)
def test_a_diagnosis_sees_logs_and_nominal_values_only(drawn: tuple[Path, dict], code: str, ended: str):
    found = answers.diagnose(drawn[0] / "case000", 20.0, (sys.executable, "-c", code))
    assert found["ended"] == ended
    seen = ["identification.parquet", "nominal.json", "validation.parquet"]
    assert found["answer"] == (seen if "listdir" in code else None)


@pytest.mark.parametrize(
    ("code", "timeout", "ended"),
    [
        ("while True: pass", 1.0, "stopped after 1 s of processor time"),
        ("import time; time.sleep(60)", 0.2, "stopped after 2 s"),
    ],
)
def test_a_diagnosis_that_does_not_end_is_stopped(
    drawn: tuple[Path, dict], code: str, timeout: float, ended: str
):
    found = answers.diagnose(drawn[0] / "case000", timeout, (sys.executable, "-c", code))
    assert (found["answer"], found["ended"]) == (None, ended)


def test_the_command_scores_once_all_is_answered(drawn: tuple[Path, dict], tmp_path: Path):
    folder, runner = drawn[0], CliRunner()
    refused = runner.invoke(blind, ["score", str(folder)])
    assert refused.exit_code == 1
    assert "stay sealed" in refused.output
    named = {"effect": "offset_force", "at": "motor", "probability": 0.98, "indistinguishable_from": []}
    given = json.dumps({"verdict": "effect", "effects": [named], "gap": {"closed_fraction": 0.96}})
    found = answers.diagnose_set(folder, 1, 20.0, (sys.executable, "-c", f"print({given!r})"))
    assert [record["case"] for record in found] == ["case000"]
    scored = runner.invoke(blind, ["score", str(folder), "--json", str(tmp_path / "score.json")])
    assert "offset_force at motor" in scored.output or drawn[1]["ratio"] < score.CLEAR
    assert json.loads((tmp_path / "score.json").read_text())["sha256"] == seal.fingerprint(folder)
    assert "offset_force at motor" in runner.invoke(blind, ["peek", str(folder)]).output
