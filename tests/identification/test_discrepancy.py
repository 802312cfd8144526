"""Deviations cover what effects that the model lacks may have done to the parameters."""

from dataclasses import replace

import numpy as np
import pytest

from symid import (
    Axis,
    Body,
    CoulombFriction,
    Drive,
    Log,
    Position,
    Unbalance,
    ViscousFriction,
    derive,
)
from symid.codegen import load_generated
from symid.identification import Identification, identify_by_least_squares
from symid.identification.deviations.discrepancy import Discrepancy
from symid.identification.deviations.motion_shapes import QUARTER, Motion, waves
from symid.identification.results.reliability import with_discrepancies

M, FV, FS = 40.0, 120.0, 30.0
RATE = 1000.0


def slide(lacking=lambda q, v: 0.0 * v, noise: float = 0.05) -> Identification:
    """Identification of a mass with friction along a motion of two tones, with a force that its model lacks."""
    t = np.arange(8000) / RATE
    q = 0.2 * np.sin(2 * np.pi * 0.4 * t) + 0.05 * np.sin(2 * np.pi * 1.3 * t + 1.0)
    v = 0.2 * 0.8 * np.pi * np.cos(0.8 * np.pi * t) + 0.05 * 2.6 * np.pi * np.cos(2.6 * np.pi * t + 1.0)
    a = -0.2 * (0.8 * np.pi) ** 2 * np.sin(0.8 * np.pi * t) - 0.05 * (2.6 * np.pi) ** 2 * np.sin(
        2.6 * np.pi * t + 1.0
    )
    rng = np.random.default_rng(5)
    F = M * a + FV * v + FS * np.sign(v) + lacking(q, v) + noise * rng.standard_normal(t.size)
    return identify_by_least_squares(
        load_generated("rigid_1m"), Log.from_arrays({"q": q, "F": F}, sampling_period=1 / RATE)
    )


def off(found: Identification) -> np.ndarray:
    return np.abs(np.array(list(found.physical_parameters.values())) - [M, FV, FS])


def drag(q, v):
    return 12.0 * v * np.abs(v)


# a force in N, and the noise beside which it is not found for certain
LACKING = {
    "stribeck": (lambda q, v: 4.0 * np.sign(v) * np.exp(-np.abs(v) / 0.08), 6.0),
    "drag": (drag, 6.0),
    "cable": (lambda q, v: 5.0 * q, 1.0),
    "root of the speed": (lambda q, v: 5.0 * np.sign(v) * np.sqrt(np.abs(v)), 1.0),
}


@pytest.mark.parametrize("effect", LACKING)
def test_a_lacking_effect_is_within_the_printed_intervals(effect):
    found = slide(*LACKING[effect])
    without = replace(found, discrepancies=())
    assert found.status == "ok"
    assert np.any(off(found) > 3 * without.physical_deviations)
    assert np.all(off(found) < 2 * found.physical_deviations)


def test_a_quarter_of_the_force_beside_noise_is_no_small_effect():
    found = slide(lambda q, v: 48.0 * np.sin(2 * np.pi * 2.9 * np.arange(q.size) / RATE + 40 * q), noise=0.05)
    assert 0.2 < found.fit.relative_error < 0.3
    assert found.status == "poor_fit"
    assert "more than noise explains" in found.message


def test_a_constant_force_hides_no_other_effect():
    found = slide(lambda q, v: drag(q, v) + 3.0, noise=6.0)
    assert [one.effect for one in found.discrepancies if one.moves()] == [
        "a constant force",
        "friction with the square of the speed",
    ]
    assert np.all(off(found) < 2 * found.physical_deviations)


def test_without_lacking_effects_deviations_are_those_of_the_noise():
    found = slide()
    assert found.status == "ok"
    assert not any(one.moves() for one in found.discrepancies)
    assert np.all(found.physical_deviations < 0.002 * np.array([M, FV, FS]))


def test_a_note_says_what_deviations_hold():
    found = slide(drag, noise=6.0)
    assert found.status == "ok"
    assert any(
        "mostly what the model may lack" in note and "square of the speed" in note for note in found.notes
    )


def test_what_is_not_determined_for_a_lacking_effect_is_not_to_be_excited_more():
    found = slide()
    lacking = Discrepancy("cogging", 2.0 * found.fit.solution[None], np.zeros((3, 3)))
    wider = with_discrepancies(found, (lacking,))
    assert (found.status, wider.status) == ("ok", "undetermined")
    assert "the model may lack an effect that moves them (cogging)" in wider.message


def test_a_change_between_bands_counts_beyond_its_noise_alone():
    change = Discrepancy("band", np.array([[5.0, 1.5]]), np.diag([1.0, 1.0]))
    assert change.variance(np.eye(2)).tolist() == [25.0, 0.0]


def test_a_change_that_is_certain_in_one_parameter_counts_with_less_in_others():
    change = Discrepancy("band", np.array([[5.0, 3.5], [3.5, 3.9]]), np.diag([1.0, 1.0]))
    assert change.variance(np.eye(2)).tolist() == [25.0, 3.25]
    assert not Discrepancy("band", np.array([[3.5, 3.9]]), np.diag([1.0, 1.0])).moves()


def test_a_change_may_be_certain_in_a_combination_of_parameters_alone():
    change = Discrepancy("band", np.array([[3.5, -3.5]]), np.array([[1.0, 0.9], [0.9, 1.0]]))
    assert not change.moves()
    assert change.moves(np.array([[1.0, -1.0]]))


@pytest.mark.parametrize("phase", [0.3, 1.9, 4.0])
def test_cogging_of_any_phase_is_one_column(phase):
    position = 0.2 * np.sin(np.arange(2000) / 300)
    rest = 2.0 * np.cos(2 * np.pi * position / 0.05 + phase)
    motion = Motion(np.gradient(position, 1e-3), position, 1e-3, np.arange(2000) * 1e-3)
    (found,) = waves([motion], [rest])
    assert np.corrcoef(found["cogging"], rest)[0, 1] > 0.999
    assert abs(np.corrcoef(found[QUARTER], found["cogging"])[0, 1]) < 0.2


@pytest.mark.parametrize("stroke", [1.0, 0.45])
def test_a_constant_force_that_a_weight_nearly_imitates_is_within_the_intervals(stroke):
    arm = Body("arm", inertia="J")
    axis = Axis(
        "turned",
        (arm, ViscousFriction(arm, "Fv"), CoulombFriction(arm, "Fc"), Unbalance(arm, "Gs", "Gc")),
        Drive("T", arm, unit="N*m"),
        (Position("q", arm),),
    )
    t = np.arange(12000) / RATE
    w = 2 * np.pi * np.array([[0.3], [0.9], [1.7]])
    size, phase = stroke * np.array([[0.35], [0.05], [0.02]]), np.array([[0.0], [1.0], [2.0]])
    q = np.sum(size * np.sin(w * t + phase), axis=0)
    v = np.sum(size * w * np.cos(w * t + phase), axis=0)
    a = -np.sum(size * w**2 * np.sin(w * t + phase), axis=0)
    noise = 0.02 * np.random.default_rng(8).standard_normal(t.size)
    T = 0.6 * a + 1.8 * v + 1.5 * np.sign(v) + 8.0 * np.sin(q) + 3.0 * np.cos(q) + 0.3 + noise
    log = Log.from_arrays({"q": q, "T": T}, sampling_period=1 / RATE)
    found = identify_by_least_squares(derive(axis, ("q",)), log)
    truth = np.array([0.6, 1.8, 1.5, 3.0, 8.0])
    assert list(found.physical_parameters) == ["J", "Fv", "Fc", "Gc", "Gs"]
    error = np.abs(np.array(list(found.physical_parameters.values())) - truth)
    assert found.status == "ok"
    assert error[3] > 0.05 * truth[3]
    assert np.all(error < 2 * found.physical_deviations)


def test_friction_with_the_force_of_the_drive_is_within_the_intervals():
    # mu |F| sign(v) with F on both sides: F (1 - mu sign(F v)) is what the motion and a held load of 60 N take
    t = np.arange(8000) / RATE
    w = 2 * np.pi * np.array([[0.7], [1.9], [4.3]])
    size = np.array([[0.1], [0.03], [0.008]])
    q, v, a = (np.sum(size * w**k * np.sin(w * t + k * np.pi / 2), axis=0) for k in range(3))
    free = 5.0 * a + FV * v + FS * np.sign(v) + 60.0
    noise = 0.05 * np.random.default_rng(3).standard_normal(t.size)
    F = free / (1 - 0.05 * np.sign(free * v)) + noise
    found = identify_by_least_squares(
        load_generated("emps"), Log.from_arrays({"q": q, "F": F}, sampling_period=1 / RATE)
    )
    error = np.abs(np.array(list(found.physical_parameters.values())) - [5.0, FV, FS, 60.0])
    assert found.status == "ok"
    assert np.any(error > 3 * replace(found, discrepancies=()).physical_deviations)
    assert np.all(error < 3 * found.physical_deviations)


@pytest.mark.parametrize("noise", [0.2, 2.0])  # with less noise it was called the drift of a clock
@pytest.mark.parametrize("drifting", ["Coulomb", "viscous"])
def test_friction_that_drifts_beside_a_growing_speed_is_within_the_intervals(drifting, noise):
    t = np.arange(8000) / RATE
    grown, w = 0.2 + 0.8 * t / 8, 2 * np.pi * 1.1
    q = 0.1 * grown * np.sin(w * t)
    v = 0.1 * (0.1 * np.sin(w * t) + w * grown * np.cos(w * t))
    a = 0.1 * (0.2 * w * np.cos(w * t) - w**2 * grown * np.sin(w * t))
    warm = 1.08 - 0.16 * t / 8  # 1 in the mean
    factors = (1.0, warm) if drifting == "Coulomb" else (warm, 1.0)
    F = M * a + FV * factors[0] * v + FS * factors[1] * np.sign(v)
    F += noise * np.random.default_rng(4).standard_normal(t.size)
    found = identify_by_least_squares(
        load_generated("rigid_1m"), Log.from_arrays({"q": q, "F": F}, sampling_period=1 / RATE)
    )
    assert found.status == "ok"
    assert [one.effect for one in found.discrepancies if one.moves()] == [f"{drifting} friction that drifts"]
    assert np.all(off(found) < 2 * found.physical_deviations)


def test_drag_that_viscous_friction_nearly_imitates_is_within_the_intervals():
    t = np.arange(4000) / RATE
    w = 2 * np.pi * 1.5
    q, v, a = 0.05 * np.sin(w * t), 0.05 * w * np.cos(w * t), -0.05 * w**2 * np.sin(w * t)
    noise = 6.0 * np.random.default_rng(9).standard_normal(t.size)
    F = M * a + FV * v + FS * np.sign(v) + 60.0 * v * np.abs(v) + noise
    found = identify_by_least_squares(
        load_generated("rigid_1m"), Log.from_arrays({"q": q, "F": F}, sampling_period=1 / RATE)
    )
    assert found.status == "ok"
    assert (
        next(one.effect for one in found.discrepancies if one.moves())
        == "friction with the square of the speed"
    )
    assert off(found)[1] > 0.05 * FV
    assert np.all(off(found) < found.physical_deviations)
