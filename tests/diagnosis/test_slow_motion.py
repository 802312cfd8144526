"""Slow axes, whose logs show friction and weight but hardly the inertia."""

import re
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.diagnosis.real import recordings
from symid import Log, diagnose, load_axis
from symid.diagnosis.findings.feedback import negative_friction
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.state import first_state
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined

TIME = np.arange(0, 40, 0.01)
RATES = 2 * np.pi * np.array([0.11, 0.19, 0.31])  # rad/s, of a motion of at most 0.3 m/s^2


def slow_log(*, level: float, weight: float, seed: int = 5) -> Log:
    """Log of a mass of 2 kg, given by its equation of motion; the noise hides most of its inertia."""
    rng = np.random.default_rng(seed)
    angles = np.outer(RATES, TIME) + np.array([[0.3], [1.1], [2.0]])
    amplitudes = np.array([0.08, 0.05, 0.02])
    q = amplitudes @ np.sin(angles)
    v = (amplitudes * RATES) @ np.cos(angles)
    a = -(amplitudes * RATES**2) @ np.sin(angles)
    force = 2.0 * a + 3.0 * v + level * np.sign(v) + weight
    noise = np.array([[1e-6], [0.05]]) * rng.standard_normal((2, TIME.size))
    return Log("by hand", 0.0, 0.01, {"q": q + noise[0], "F": force + noise[1]})


def test_a_missing_weight_is_found_though_it_hid_the_inertia() -> None:
    found = diagnose(load_axis("rigid_1m"), slow_log(level=0.65, weight=4.0))
    assert (found.verdict, found.effects[0].effect) == ("effect", "offset_force")
    assert found.effects[0].parameters["F0"].value == pytest.approx(4.0, abs=0.02)


def test_a_force_that_friction_alone_shows_to_be_reversed_is_said() -> None:
    log = slow_log(level=0.65, weight=0.0)
    found = diagnose(load_axis("rigid_1m"), replace(log, signals={"q": log["q"], "F": -log["F"]}))
    assert found.verdict == "recording"
    assert "the sign of F or of a position is wrong" in found.sentence


@pytest.mark.parametrize(("sign", "said"), [(1.0, False), (-1.0, True)])
def test_a_drive_that_supplies_energy_is_not_reversed_whatever_a_model_says(sign: float, said: bool) -> None:
    """Friction of a model that lacks much may come out negative."""
    log = slow_log(level=0.65, weight=0.0)
    turned = replace(log, signals={"q": log["q"], "F": sign * log["F"]})
    data = data_of(load_axis("rigid_1m"), (joined([turned]), None), Recording({}, None))
    model = Fit(*first_state(data.record, {"M": 2.0, "Fv": -3.0, "Fs": -0.65}))
    plain = Fit(*first_state(data.record, {"M": 2.0, "Fv": 1.0, "Fs": -0.4}))
    sentence = negative_friction(model, plain)
    assert bool(sentence) is said
    assert ("(Fs -0.4)" in sentence) is said  # the value in the table of parameters


def test_a_joint_of_a_robot_with_a_negative_torque_constant_is_called_reversed() -> None:
    run = recordings.tiago("arm_3_joint").between(10.0, 68.0)  # the published constant is -0.087
    log = Log(run.source, run.start, run.period, {"q": run["q"], "F": run["F"]})
    found = diagnose(load_axis("rigid_1m"), log)
    assert found.verdict == "recording"
    assert "the sign of F or of a position is wrong" in found.sentence
    turned = diagnose(load_axis("rigid_1m"), replace(log, signals={"q": log["q"], "F": -log["F"]}))
    assert "sign" not in turned.sentence


def test_an_error_of_a_moment_says_when_it_was() -> None:
    log = slow_log(level=0.65, weight=0.0)
    struck = log["F"] - 5.0 * ((log.time > 17.0) & (log.time < 18.0))
    found = diagnose(load_axis("rigid_1m"), replace(log, signals={"q": log["q"], "F": struck}))
    assert found.verdict == "unexplained"
    begin, end = re.findall(r"between ([\d.]+) and ([\d.]+) s", found.next_experiment)[0]
    assert 16.8 < float(begin) < float(end) < 18.2
