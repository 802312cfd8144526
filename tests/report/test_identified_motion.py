"""The identified axis simulated along its log: positions against those of another solver, failures in words."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hand_made import RIGID, rigid_log
from scipy.signal import StateSpace, lsim

import symid
from symid.diagnosis.in_motion.identified_motion import identified_motion
from symid.report.pages.identification_page import write_identification_html

AXIS = symid.load_axis("rigid_1m")
LINEAR = {"M": 112.0, "Fv": 150.0, "Fs": 0.0}
QUIET = {"F": 0.0, "q": 0.0}


def frictionless():
    """A log of the mass without dry friction, and of a mass of which 12 kg are not known."""
    return rigid_log(lambda t, q, v, a, path: -RIGID["Fs"] * np.sign(v), noise=QUIET)


def test_the_position_is_that_of_another_solver() -> None:
    log = frictionless()
    (motion,) = identified_motion(AXIS, LINEAR, log).motions
    assert motion.driver == "observer"
    kp, kv = motion.gains["Kpp"], motion.gains["Kpv"]
    m, c = LINEAR["M"], LINEAR["Fv"]
    t, q = log.sampling_period * np.arange(log.n_samples), log["q"]
    speed = np.gradient(q, log.sampling_period, edge_order=2)
    pull = log["F"] + kv * (kp * q + speed)
    system = StateSpace([[0, 1], [-kv * kp / m, -(c + kv) / m]], [[0], [1 / m]], [[1, 0]], [[0]])
    simulated = lsim(system, pull, t, X0=[q[0], speed[0]])[1]
    rms = np.sqrt(np.mean((simulated - q) ** 2))
    fit = 100 * (1 - np.linalg.norm(simulated - q) / np.linalg.norm(q - q.mean()))
    assert rms > 1e-4  # 12 kg too many are seen
    assert motion.explained.position_rms == pytest.approx(rms, rel=0.02)
    assert motion.explained.position_fit == pytest.approx(fit, abs=0.02)


def test_a_force_that_acts_late_is_simulated_late() -> None:
    log = frictionless()
    right = {**LINEAR, "M": RIGID["M"]}
    late = replace(log, signals={**log.signals, "F": np.roll(log["F"], -8)})  # recorded 4 ms too early
    errors = [
        identified_motion(AXIS, right, run, by).motions[0].explained.position_rms
        for run, by in ((log, {}), (late, {"F": -4e-3}), (late, {}))
    ]
    assert errors[1] < 2 * errors[0] < 0.2 * errors[2]


def test_a_sensor_that_is_late_is_read_late() -> None:
    log = frictionless()
    right = {**LINEAR, "M": RIGID["M"]}
    behind = replace(log, signals={**log.signals, "q": np.roll(log["q"], 8)})
    with_it, without = (
        identified_motion(AXIS, right, behind.window(8, 12_000), by).motions[0].explained.position_rms
        for by in ({"q": 4e-3}, {})
    )
    assert with_it < 0.2 * without


@pytest.mark.parametrize(
    ("values", "statement"),
    [
        ({}, "determines no physical parameters"),
        ({**RIGID, "M": -3.0}, "M = -3 is impossible"),
        ({**RIGID, "Fv": -1e5}, "runs away"),
        ({**RIGID, "Fv": np.nan}, "."),
    ],
)
def test_what_cannot_be_simulated_is_reported(values: dict[str, float], statement: str) -> None:
    found = identified_motion(AXIS, values, rigid_log(seconds=2.0))
    assert found.motions == ()
    assert statement in found.message or (statement == "." and found.message)


def test_an_axis_that_reads_no_position() -> None:
    log = rigid_log(seconds=2.0)
    fast = replace(log, signals={"F": log["F"], "v": np.gradient(log["q"], log.sampling_period)})
    assert identified_motion(AXIS, RIGID, fast).message == "none of its signals is a position"


@pytest.mark.usefixtures("plain_pages")
def test_the_page_says_how_the_axis_was_driven(tmp_path: Path) -> None:
    log = rigid_log(seconds=4.0)
    found = symid.identify(AXIS, log)
    file = tmp_path / "p.html"
    write_identification_html(found, file, axis=AXIS, runs=[log])
    page = file.read_text(encoding="utf-8")
    (motion,) = identified_motion(AXIS, found.physical_parameters, log).motions
    assert f"{1e6 * motion.explained.position_rms:.3g} um" in page
    assert "with a slow observer" in page
    write_identification_html(replace(found, axis=None, runs=()), file)
    assert "Nothing was simulated" in file.read_text(encoding="utf-8")
    broken = replace(found, physical=())
    write_identification_html(broken, file, axis=AXIS, runs=[log])
    assert re.search("was not simulated: the log determines no", file.read_text(encoding="utf-8"))
