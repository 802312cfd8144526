"""An axis that moves in one direction only: dry friction is then a constant force like any other."""

import numpy as np
import pytest

from symid import Axis, Body, CoulombFriction, Drive, Log, OffsetForce, Position, Unbalance, derive
from symid.codegen import load_generated
from symid.identification import Identification, identify_by_least_squares

RATE = 500.0
SPEEDS, EVERY = (0.1, 0.3, 0.2, 0.4, 0.15), 1.2


def moved(model: str, back: float) -> Identification:
    """Identification of moves with rests, each second one of them backwards by a part of the speed."""
    t = np.arange(int(EVERY * len(SPEEDS) * RATE)) / RATE
    q, v, a = np.zeros((3, t.size))
    for k, speed in enumerate(SPEEDS):
        # quintic moves of 0.8 s, then a rest
        x = np.clip((t - k * EVERY) / 0.8, 0.0, 1.0)
        size = speed * (-back if k % 2 else 1.0)
        q += size * (10 * x**3 - 15 * x**4 + 6 * x**5)
        v += size * 30 * x**2 * (1 - x) ** 2 / 0.8
        a += size * 60 * x * (1 - x) * (1 - 2 * x) / 0.8**2
    held = 0.4  # of its level, by friction at rest
    F = 20.0 * a + 30.0 * v + 6.0 * np.where(v == 0, held, np.sign(v)) + 15.0
    F += 0.01 * np.random.default_rng(1).standard_normal(t.size)
    log = Log.from_arrays({"q": q, "F": F}, sampling_period=1 / RATE)
    return identify_by_least_squares(load_generated(model), log)


def test_friction_and_a_constant_force_are_not_told_apart() -> None:
    found = moved("emps", back=-1.0)
    assert found.status == "undetermined"
    assert "moves in one direction only, in which X3 and others are one force" in found.message


def test_a_note_says_what_friction_holds() -> None:
    found = moved("rigid_1m", back=-1.0)
    assert found.status == "ok"
    assert found.physical_parameters["Fs"] == pytest.approx(21.0, rel=0.02)
    assert any("a constant force, such as a weight or an offset of F, counts as" in n for n in found.notes)


def test_both_directions_tell_them_apart() -> None:
    found = moved("emps", back=0.5)
    assert found.status == "ok"
    assert not any("one direction" in note for note in found.notes)
    assert found.physical_parameters["Fc"] == pytest.approx(6.0, rel=0.02)


def test_a_weight_near_the_top_is_no_friction() -> None:
    arm = Body("arm", inertia="J")
    laws = (CoulombFriction(arm, "Fc"), Unbalance(arm, "Gs", "Gc"), OffsetForce(arm, "OF"))
    axis = Axis("swung", (arm, *laws), Drive("T", arm), (Position("q", arm),))
    t = np.arange(2000) / RATE
    q, v, a = 0.1 * np.sin(6 * t), 0.6 * np.cos(6 * t), -3.6 * np.sin(6 * t)
    T = (
        0.3 * a
        + 0.4 * np.sign(v)
        + 2.0 * np.cos(q)
        + 1.0
        + 1e-3 * np.random.default_rng(2).standard_normal(t.size)
    )
    found = identify_by_least_squares(
        derive(axis), Log.from_arrays({"q": q, "T": T}, sampling_period=1 / RATE)
    )
    assert "one direction" not in found.message
    assert not any("one direction" in note for note in found.notes)
