"""Tuning of axes with two drives: two sines in closed form, the gantry of tests/axes/gantry.py replayed and tuned."""

import math
from dataclasses import replace

import numpy as np
import pytest
from axes.gantry import AXIS, NOISE, TRUE, log

from symid import Axis, Body, Drive, Position, ViscousFriction, derive, tune
from symid.codegen.generated_models import compiled
from symid.simulation import chirp
from symid.tuning import tune_total
from symid.tuning.from_log import run_of_log
from symid.tuning.low_pass import standard_model

LEFT, RIGHT = Body("left", mass="M1"), Body("right", mass="M2")
APART = Axis(
    "apart",
    (LEFT, ViscousFriction(LEFT, "Fv1"), RIGHT, ViscousFriction(RIGHT, "Fv2")),
    (Drive("F1", LEFT), Drive("F2", RIGHT)),
    (Position("q1", LEFT), Position("q2", RIGHT)),
)
VALUES = {"M1": 5.0, "Fv1": 300.0, "M2": 8.0, "Fv2": 400.0}
SINES_HZ = 8.0, 5.0


@pytest.fixture(scope="module")
def tuned():
    sines = [chirp(f, f, 3.0, 0.01, sampling_period=1e-4, fade=0.5) for f in SINES_HZ]
    return tune(APART, VALUES, trajectory=sines, max_lowpass_error=0.1, max_sampling_error=0.5)


def test_the_fastest_drive_decides_the_sampling_frequency_of_all(tuned):
    # M is found too large by 1 / (sin(wT) / wT)^2, about 1 + (w T)^2 / 3
    assert tuned.sampling.frequency_hz == pytest.approx(2 * math.pi * 8.0 / math.sqrt(3 * 0.5e-2), rel=0.02)
    assert tuned.sampling.errors["M1"] == pytest.approx(0.5, rel=0.02)
    assert tuned.sampling.errors["M2"] == pytest.approx(0.5 * (5.0 / 8.0) ** 2, rel=0.02)
    # the gain is 1 / (1 + (f / fc)^8), and the forces are not filtered
    assert tuned.cutoff.frequency_hz == pytest.approx(8.0 * (0.1e-2) ** (-1 / 8), rel=0.02)
    assert tuned.cutoff.errors["M2"] == pytest.approx(0.1 * (5.0 / 8.0) ** 8, rel=0.25)  # and its fades


def test_known_masses_are_no_errors_and_stand_with_the_forces():
    known = replace(APART, known={"M1": 5.0})
    one = chirp(8.0, 8.0, 3.0, 0.01, sampling_period=2.5e-4, fade=0.5)
    found = tune(known, VALUES, trajectory=one, max_lowpass_error=0.1)
    assert found.cutoff.errors.keys() == found.sampling.errors.keys() == {"Fv1", "M2", "Fv2"}
    assert found.status == "ok"


def test_standard_model_of_the_gantry_has_each_force_in_its_balance():
    model, random = standard_model(AXIS), np.random.default_rng(0)
    values = {name: random.normal(size=20) for name in model.signals}
    W, y = model.sample(values)
    assert np.array_equal(y, [values["F1"], values["F2"], np.zeros(20)])
    beam, left = values["q_beam"], values["q_left"]
    assert np.allclose(W[0, :, model.parameters.index("K1")], left - beam)
    assert np.allclose(W[2, :, model.parameters.index("Mb")], values["q_beam_d2"])


def test_a_log_of_two_drives_is_replayed_and_tuned_to_a_small_total_error():
    model, recorded = compiled(derive(AXIS)), log(2.0)
    levels = {name: NOISE[name] for name in ("F1", "F2", "q1", "q2")}
    run = run_of_log(AXIS, model, TRUE, recorded)
    again = run.log(recorded.sampling_frequency)
    for name in ("q1", "q2", "qb"):
        moved = recorded[name] - recorded[name][0]
        assert np.abs(again[name] - moved).max() < 2e-3 * np.ptp(moved), name
    found = tune_total(AXIS, model, TRUE, [run], recorded.sampling_frequency, levels, draws=2)
    assert found.status == "ok"
    assert found.noise == levels
    assert found.total_percent < 3.0
