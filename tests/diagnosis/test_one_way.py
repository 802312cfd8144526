"""Moves in one direction tell no dry friction from a constant force; other effects are found all the same."""

from types import SimpleNamespace

import numpy as np
import pytest
from hand_made import QUIET, RATE, RIGID, motion

from symid import Axis, Log, OffsetForce, load_axis
from symid.diagnosis import diagnose
from symid.diagnosis.prediction.preparation import indistinct_constant_forces
from symid.diagnosis.selection.screening import Candidate
from symid.diagnosis.selection.stages import ties

SPEED, PITCH = 1.5, 0.3


@pytest.fixture(scope="module")
def axis() -> Axis:
    plain = load_axis("rigid_1m")
    return plain.with_effect(OffsetForce(plain.bodies[0], "OF"))


@pytest.fixture(scope="module")
def log() -> Log:
    t, path, rng = np.arange(round(4 * RATE)) / RATE, motion(1), np.random.default_rng(3)
    q, v = path.at(t) + SPEED * t, path.at(t, 1) + SPEED
    assert v.min() > 0
    force = RIGID["M"] * path.at(t, 2) + RIGID["Fv"] * v + RIGID["Fs"] + 20
    signals = {"F": force + 30 * np.sin(2 * np.pi * q / PITCH), "q": q}
    noisy = {name: x + QUIET[name] * rng.standard_normal(t.size) for name, x in signals.items()}
    return Log.from_arrays(noisy, sampling_period=1 / RATE)


@pytest.mark.parametrize("constant", [0.0, 20.0])
def test_cogging_is_found_beside_friction_and_a_constant_force(axis: Axis, log: Log, constant: float) -> None:
    found = diagnose(axis, log, nominal=RIGID | {"OF": constant} if constant else None)
    (effect,) = found.effects
    assert {"cogging", "position_dependent_friction"} == {effect.effect, effect.indistinguishable_from[0][0]}
    assert effect.parameters["pitch"].value == pytest.approx(PITCH, rel=1e-3)
    level = next(p for p in found.parameters if p.name == "Fs")
    assert level.explained == pytest.approx(28 - constant, abs=4 * level.explained_std)
    assert level.explained_std < 3
    assert any(f"OF is taken as {constant:.4g} N" in note for note in found.assumptions)


def test_a_way_back_tells_them_apart(axis: Axis, log: Log) -> None:
    back = Log.from_arrays(
        {name: np.concatenate([x, x[::-1]]) for name, x in log.signals.items()}, sampling_period=1 / RATE
    )
    assert indistinct_constant_forces(axis, [log], None)[0] == {"OF": 0.0}
    assert (
        indistinct_constant_forces(axis, [log, back], None)
        == indistinct_constant_forces(axis, [back], None)
        == ({}, ())
    )
    assert indistinct_constant_forces(load_axis("rigid_1m"), [log], None) == ({}, ())


def test_effects_with_the_gain_of_a_chosen_one_are_fitted_too() -> None:
    names = ("gain", "ripple", "offset", "coulomb", "drag")
    placed = [SimpleNamespace(effect=name) for name in names]
    found = [
        Candidate(p, gain, 0.0) for p, gain in zip(placed, (50.0, 30.0, 21.33, 21.32, 11.6), strict=True)
    ]
    assert [c.placed.effect for c in ties(found, found[:3])] == ["coulomb"]
    assert ties(found, found[:2]) == []
