"""A log of a speed and no position is diagnosed by the integral of the speed."""

from dataclasses import replace

import numpy as np
import pytest
import scipy
from hand_made import QUIET, RIGID, motion, rigid_log

from symid import Axis, Body, CoulombFriction, Drive, Log, Velocity, ViscousFriction
from symid.diagnosis import diagnose
from symid.diagnosis.in_motion.declared import explained_axis
from symid.diagnosis.prediction.motion_band import motion_band
from symid.diagnosis.prediction.preparation import with_positions

TABLE = Body("table", mass="M")
FAN = Axis("fan", (TABLE,), Drive("F", TABLE), (Velocity("w", TABLE),))


def test_a_log_of_a_speed_is_diagnosed() -> None:
    table = Body("table", mass="M")
    axis = Axis("fan", (table, ViscousFriction(table, "Fv")), Drive("F", table), (Velocity("w", table),))
    log = rigid_log()  # with Coulomb friction, which this axis lacks
    rng = np.random.default_rng(3)
    speed = motion(1).at(log.time, 1) + 1e-5 * rng.standard_normal(log.n_samples)
    found = diagnose(axis, replace(log, signals={"F": log["F"], "w": speed}))
    assert (found.verdict, found.effects[0].effect) == ("effect", "coulomb_friction")
    assert found.effects[0].parameters["Fs"].value == pytest.approx(RIGID["Fs"], rel=0.05)
    assert found.gap.explained.rms < 3 * QUIET["F"]
    assert any("integral" in text for text in found.assumptions)
    written = explained_axis(found).axis
    assert [sensor.quantity for sensor in written.sensors] == ["velocity"]
    assert any(isinstance(element, CoulombFriction) for element in written.elements)


def integrated(speed: np.ndarray) -> np.ndarray:
    log = Log.from_arrays({"w": speed, "F": np.ones(speed.size)}, sampling_period=1e-3)
    return with_positions(FAN, [log])[1][0]["w"]


def test_a_speed_is_integrated_up_to_high_frequencies() -> None:
    t, omega = np.arange(4000) / 1000, 2 * np.pi * 300.3
    whole = 0.2 * t + 0.5 * t**2 / 2 + np.sin(omega * t) / omega
    error = (integrated(0.2 + 0.5 * t + np.cos(omega * t)) - whole)[200:-200]
    assert np.abs(error - error.mean()).max() < 0.02 / omega


def test_counts_that_a_drive_differentiates_and_filters_are_no_motion() -> None:
    t = np.arange(8000) / 1000
    q = 0.3 * np.sin(2 * np.pi * 1.1 * t) + 0.2 * np.sin(2 * np.pi * 0.37 * t)
    pole = np.exp(-2 * np.pi * 60 / 1000)
    step = 2e-4
    speed = scipy.signal.lfilter([1 - pole], [1, -pole], np.gradient(np.round(q / step) * step, 1e-3))
    assert motion_band(integrated(speed), 1000.0) < 40.0
