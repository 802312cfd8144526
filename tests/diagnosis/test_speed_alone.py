"""A log of a speed and no position is diagnosed by the integral of the speed."""

from dataclasses import replace

import numpy as np
import pytest
from hand_made import QUIET, RIGID, motion, rigid_log

from symid import Axis, Body, CoulombFriction, Drive, Velocity, ViscousFriction
from symid.diagnosis import diagnose
from symid.diagnosis.in_motion.declared import explained_axis


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
