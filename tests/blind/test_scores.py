"""Scores of answers, computed by hand."""

import json

import pytest

from benchmarks.blind import score, table


def label(group: str, sensor_class: str, ratio: float, *effects: tuple[str, str]) -> dict:
    named = [{"effect": effect, "at": at, "numbers": {}} for effect, at in effects]
    return {"group": group, "class": sensor_class, "axis": "rigid_1m", "ratio": ratio, "effects": named}


def answer(
    verdict: str, *effects: tuple[str, str], p: float = 1.0, ties: tuple[tuple[str, str], ...] = ()
) -> dict:
    others = [{"effect": effect, "at": at} for effect, at in ties]
    named = [{"effect": e, "at": at, "probability": p, "indistinguishable_from": others} for e, at in effects]
    return {
        "answer": {"verdict": verdict, "effects": named, "gap": {"closed_fraction": 0.96}},
        "seconds": 2.0,
    }


LAG, DELAY, DRAG = ("actuator_lag", "actuator"), ("delay", "actuator"), ("quadratic_drag", "motor")


def test_scores_of_made_up_answers():
    pairs = [
        (label("single", "rigid", 20, LAG), answer("effect", LAG, p=0.9)),
        (label("single", "rigid", 20, LAG), answer("effect", DELAY, p=0.6, ties=(LAG,))),
        (label("single", "rigid", 20, LAG), answer("effect", DELAY, p=0.4, ties=(LAG, DRAG))),
        (label("single", "rigid", 20, LAG), {"answer": None, "seconds": 9.0}),
        (label("single", "rigid", 3, LAG), answer("no_gap")),
        (label("none", "motor only", 0), answer("no_gap")),
        (label("none", "motor only", 0), answer("parameters")),
        (label("parameters", "rigid", 0), answer("parameters")),
        (label("parameters", "rigid", 0), answer("unexplained")),
        (label("two", "rigid", 30, LAG, DRAG), answer("effect", DRAG, LAG, p=1.0)),
        (label("two", "rigid", 30, LAG, DRAG), answer("effect", LAG, DELAY, p=1.0)),
        (label("foreign", "rigid", 30, ("sticky_zone", "motor")), answer("unexplained")),
        (label("foreign", "rigid", 30, ("sticky_zone", "motor")), answer("effect", DRAG, p=0.8)),
    ]
    verdicts = [score.verdict(*pair) for pair in pairs]
    reached = {aim.name: (aim.value, aim.cases, aim.met) for aim in score.aims(verdicts)}
    assert reached["rigid: right effect and place first"] == (0.25, 4, False)
    assert reached["rigid: in the stated set"] == (0.5, 4, False)
    assert reached["motor only: in the stated set"][1:] == (0, False)
    assert reached["false alarms on exact axes and wrong values"] == (0.0, 4, True)
    assert reached["both of two effects"] == (0.5, 2, False)
    assert reached["kinds left out: unexplained or unsure"] == (0.5, 2, False)
    assert reached["median closed fraction"] == (0.96, 4, True)
    expected = (0.1**2 + 0.6**2 + 0.4**2 + 0.8**2) / 6
    assert reached["Brier score of the first effect"][:2] == (pytest.approx(expected), 6)
    assert [v.right for v in verdicts[5:9]] == [True, True, True, False]
    assert score.by_ratio(verdicts) == {"rigid": [(0, 0), (0, 1), (0, 0), (0, 0), (1, 4), (0, 0)]}
    counts = score.confusion(verdicts)["actuator_lag at actuator"]
    assert counts == {"delay at actuator": 2, "actuator_lag at actuator": 1, "no answer": 1}
    assert score.calibration(verdicts)[-1] == (0.99, 1.0, 2, 1.0, 1.0, 1.0)
    assert score.time_quantiles(verdicts)["longest"] == 9.0
    printed = table.text(verdicts)
    assert "Without an answer: 1 of 13" in printed
    assert json.loads(json.dumps(table.record(verdicts, "0" * 64)))["no_answer"] == 1


def test_partly_counts_where_it_is_right_and_as_an_alarm_where_nothing_is_hidden():
    pairs = [
        (label("single", "rigid", 20, LAG), answer("partly", LAG)),
        (label("none", "rigid", 0), answer("partly", LAG)),
        (label("parameters", "rigid", 0), answer("recording")),
        (label("parameters", "rigid", 0), answer("unexplained")),
        (label("foreign", "rigid", 30, ("sticky_zone", "motor")), answer("partly", DRAG, p=0.4)),
    ]
    verdicts = [score.verdict(*pair) for pair in pairs]
    assert [v.right for v in verdicts] == [True, False, False, False, True]
    reached = {aim.name: (aim.value, aim.cases) for aim in score.aims(verdicts)}
    assert reached["false alarms on exact axes and wrong values"] == (pytest.approx(2 / 3), 3)


def worldly(*found: tuple[str, str], left: float | None, low: float = 0.0, ties: tuple = ()) -> dict:
    record = answer("partly" if found else "no_gap", *found, p=0.8, ties=ties)
    record["answer"]["gap"]["unexplained_share"] = left
    for effect in record["answer"]["effects"]:
        effect["removes"] = {"share": 0.8, "low": low, "high": 0.9}
    return record


def test_scores_of_worldly_cases():
    hidden = label("worldly", "rigid", 20, LAG, DRAG) | {"removed": {"0": 0.85, "01": 1.0}}
    nothing = label("worldly none", "rigid", 0)
    pairs = [
        (hidden, worldly(LAG, left=0.2)),  # 80 % removed where 85 are true
        (hidden, worldly(LAG, DRAG, left=0.2, low=0.88)),  # 80 % where both remove everything
        (hidden, worldly(DELAY, DRAG, left=0.02, ties=(LAG, DRAG))),  # right by a tie
        (hidden, worldly(DRAG, left=0.2, ties=(LAG,))),  # by a tie with a small one
        (hidden, worldly(DRAG, LAG, left=0.02)),  # a small one first
        (nothing, worldly(left=None)),
        (nothing, worldly(DRAG, left=0.5)),
    ]
    verdicts = [score.verdict(*pair) for pair in pairs]
    assert [v.right for v in verdicts] == [True, True, True, True, False, True, False]
    assert [v.truth for v in verdicts] == [0.85, 1.0, 1.0, 0.85, None, None, None]
    assert [v.miss for v in verdicts[:2]] == [pytest.approx(-0.05), pytest.approx(-0.2)]
    figures = {figure.name: (figure.value, figure.cases) for figure in score.worldly(verdicts)}
    assert figures["strongest first or tied, all"] == (0.8, 5)
    assert figures["strongest itself first"] == (0.4, 5)
    assert figures["no effect: a cause is named"] == (0.5, 2)
    assert figures["right: closed share within 10 points of the truth"] == (0.75, 4)
    assert figures["first: interval of what it removes holds the truth"] == (0.5, 2)
    assert figures["Brier score, first effect"] == (pytest.approx((2 * 0.2**2 + 4 * 0.8**2) / 6), 6)
    assert figures["Brier score, first effect or its ties"] == (
        pytest.approx((4 * 0.2**2 + 2 * 0.8**2) / 6),
        6,
    )
    assert score.calibration(verdicts) == [
        (0.8, 0.9, 6, pytest.approx(0.8), pytest.approx(1 / 3), pytest.approx(2 / 3))
    ]
    assert score.confusion(verdicts)["worldly none"] == {"no_gap": 1, "quadratic_drag at motor": 1}
    printed = table.text(verdicts)
    assert printed.startswith("Worldly cases")
    assert json.loads(json.dumps(table.record(verdicts, "0" * 64)))["worldly"][0]["cases"] == 5
