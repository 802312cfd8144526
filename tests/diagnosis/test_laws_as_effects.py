"""Every law of the library as an effect: its force is that of its elements, for arrays as for numbers."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from symid import Axis, Body, Drive, Log, PendulumWeight, Position, Unbalance, load_axis
from symid.axis import Between, Spring
from symid.diagnosis import LIBRARY, diagnose
from symid.diagnosis.effects import LawEffect, effects_named
from symid.diagnosis.prediction.hidden_motion import Pointwise
from symid.diagnosis.prediction.prediction import Prediction, prediction_of
from symid.diagnosis.prediction.record import record_of
from symid.errors import SettingError
from symid.simulation import forward_dynamics, plant_of
from symid.simulation.compiled_loop.evaluation import evaluate

LAWS = [effect for effect in LIBRARY if isinstance(effect, LawEffect)]
EVERY_LAW = pytest.mark.parametrize("effect", LAWS, ids=lambda e: f"{e.name}-{'-'.join(e.amplitudes)}")
LEAN = {"M": 100.0}
SCREW = {"Mm": 120.0, "Fvm": 90.0, "Fsm": 50.0, "Kt": 8e6, "Ft": 700.0, "Ml": 200.0, "Fvl": 110.0}


@cache
def scene_for(effect: LawEffect) -> Prediction:
    """A log of an axis that has what the effect needs and lacks what it adds; motion with several reversals."""
    t = np.arange(4000) / 1000
    q, force = 0.2 + 0.05 * np.sin(7 * t) + 0.002 * np.sin(40 * t), 30 * np.cos(11 * t)
    if effect.law.in_spring:
        axis, values = load_axis("ballscrew_2m1s"), dict(SCREW)
        if effect.law.once:
            del values["Ft"]
            bare = (replace(e, damping=None) if isinstance(e, Spring) else e for e in axis.elements)
            axis = replace(axis, elements=tuple(bare))
        signals = {"qm": q, "ql": q - 2e-5 * np.sin(9 * t), "Fm": force}
    else:
        body = Body("table", inertia="M")
        beside = [law(body, law.__name__) for law in effect.hypothesis.beside]
        values = LEAN | {law.__name__: 5.0 for law in effect.hypothesis.beside}
        axis = Axis("lean", (body, *beside), Drive("F", body), (Position("q", body),))
        signals = {"q": q, "F": force}
    record = record_of(forward_dynamics(axis), Log("by hand", 0.0, 1e-3, signals), 40.0)
    return prediction_of(record, values)


def trial(effect: LawEffect) -> tuple[str, tuple[float, ...], tuple[float, ...]]:
    """A place, a shape and amplitudes; what varies along the stroke leaves a level above 0."""
    prediction = scene_for(effect)
    place = next(iter(effect.places(prediction)))
    shape = next(
        iter(effect.shapes(prediction, place, lambda response: np.ones(prediction.record.fine_time.size)))
    )
    many = len(effect.amplitudes)
    return place, shape, (3.0, *np.linspace(0.4, 0.7, many - 1)) if many > 1 else (3.0,)


def force_at(law: Pointwise, q: float, v: float) -> float:
    """By the program that the compiled steps run."""
    own, arguments = law.program, np.array([q, v, 1.0, 0.0, 0.0, *law.values.values()])
    return float(evaluate(own.operations, own.operands, arguments, np.zeros(own.depth)))


def a_body(effect: LawEffect) -> Body:
    """A body that slides where the one of the log does, else turns."""
    return Body("b", mass="M") if effect.law.in_spring else Body("b", inertia="M")


def elements_alone(effect: LawEffect) -> Axis:
    """A body with nothing but the elements that a diagnosis would add."""
    place, shape, amplitudes = trial(effect)
    body = a_body(effect)
    found, _ = effect.elements(body, place, shape, amplitudes)
    return Axis("alone", (body, *found), Drive("F", body), (Position("q", body),))


@EVERY_LAW
def test_the_force_is_that_of_the_elements(effect: LawEffect) -> None:
    """In the simulation, but for what lies above the band of the log."""
    place, shape, amplitudes = trial(effect)
    prediction, axis = scene_for(effect), elements_alone(effect)
    joint = effect.joint(prediction, place)
    _, values = effect.elements(axis.bodies[0], place, shape, amplitudes)
    plant = plant_of(axis, {"M": 1.0, **values})
    course = np.tensordot(amplitudes, LawEffect.courses(effect, joint, shape), 1)
    inside = np.flatnonzero(prediction.record.in_log)[::37]
    linear = plant.stiffness.item() * joint.q + plant.damping.item() * joint.v - plant.constant.item()
    expected = [
        linear[k] + sum(law.force(float(joint.q[k]), float(joint.v[k])) for law in plant.laws) for k in inside
    ]
    np.testing.assert_allclose(course[inside], expected, rtol=1e-11, atol=1e-12 * np.abs(course).max())


@EVERY_LAW
def test_numbers_have_the_force_of_arrays(effect: LawEffect) -> None:
    """But for what lies above the band; of dry friction the numbers are the level, which is not below 0."""
    place, shape, amplitudes = trial(effect)
    prediction = scene_for(effect)
    joint = effect.joint(prediction, place)
    law = effect.point_by_point(shape, amplitudes)
    course = np.tensordot(amplitudes, LawEffect.courses(effect, joint, shape), 1)
    if law.dry:
        course = course * np.sign(joint.v)
    if effect.varies_along_stroke:
        course = np.maximum(course, 0.0)
    for k in np.flatnonzero(prediction.record.in_log)[::37]:
        force = force_at(law, joint.q[k], joint.v[k])
        assert force == pytest.approx(course[k], rel=1e-11, abs=1e-12 * np.abs(course).max())


@EVERY_LAW
def test_units_are_those_of_the_elements(effect: LawEffect) -> None:
    place, shape, amplitudes = trial(effect)
    prediction = scene_for(effect)
    _, values = effect.elements(a_body(effect), place, shape, amplitudes)
    units = elements_alone(effect).physical_parameters
    given = effect.units(prediction, place)
    assert len(given) == len(effect.amplitudes) + len(effect.shape_names)
    for name, unit in zip(effect.amplitudes, given, strict=False):
        assert str(units[f"{place}_{name}"]) == unit
    assert set(values) == set(units) - {"M"}


@EVERY_LAW
def test_it_is_not_proposed_where_it_would_say_nothing_new(effect: LawEffect) -> None:
    """Not where a law that is declared once only is declared; not without the laws that it goes with."""
    prediction = scene_for(effect)
    assert effect.places(prediction)
    for law in effect.hypothesis.beside:
        assert any(isinstance(own, law) for own in prediction.axis.elements)
    if effect.law.in_spring and effect.law.once:  # the screw of the others has what this one adds
        damped = forward_dynamics(load_axis("ballscrew_2m1s"))
        assert not effect.places(prediction_of(record_of(damped, prediction.record.log, 40.0), SCREW))
    elif any(law.once for law in effect.laws):
        declared = elements_alone(effect)
        values = dict.fromkeys(declared.physical_parameters, 1.0)
        again = prediction_of(record_of(forward_dynamics(declared), prediction.record.log, 40.0), values)
        assert "b" not in effect.places(again)


def test_a_stiffness_is_not_sought_where_a_spring_is() -> None:
    (stiffness,) = (effect for effect in LAWS if effect.name == "position_stiffness")
    motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
    springs = Spring("coupling", Between(first=motor, second=load), "K"), Spring("guide", load, "G")
    axis = Axis("sprung", (motor, load, *springs), Drive("F", motor), (Position("q", motor),))
    t = np.arange(4000) / 1000
    log = Log("by hand", 0.0, 1e-3, {"q": 0.05 * np.sin(7 * t), "F": 30 * np.cos(11 * t)})
    values = {"Mm": 100.0, "Ml": 50.0, "K": 1e6, "G": 1e4}
    assert stiffness.places(prediction_of(record_of(forward_dynamics(axis), log, 40.0), values)) == ["motor"]


@pytest.mark.parametrize("name", ["backlash", "stiffness_nonlinearity"])
def test_a_strong_law_in_a_spring_pushes_as_the_spring_does(name: str) -> None:
    (effect,) = (e for e in LAWS if e.name == name)
    prediction = scene_for(effect)
    largest = max(map(abs, prediction.springs["transmission"].range))
    strong = list(effect.strong_starts(prediction.springs["transmission"], 8e6))
    assert len(strong) == 4
    for (shape, amplitudes), share in zip(strong, (0.3, 1.0, 2.5, 5.0), strict=True):
        force = abs(force_at(effect.point_by_point(shape, amplitudes), largest, 0.0))
        expected = share if name == "stiffness_nonlinearity" else min(share / 2, 1.0)
        assert force == pytest.approx(expected * 8e6 * largest)


def test_a_weight_is_sought_where_a_body_turns_and_none_is_declared() -> None:
    """Beside a declared one only its zero may be wrong."""
    whole, zero = (effect for effect in LAWS if effect.name == "weight")
    slide, table = Body("slide", mass="M"), Body("table", inertia="J")
    for body, known, places in (
        (slide, (), ([], [])),
        (table, (), (["table"], [])),
        (table, (PendulumWeight(table, "ml"),), ([], ["table"])),
        (table, (Unbalance(table, "Gs", "Gc"),), ([], [])),
    ):
        axis = Axis("turning", (body, *known), Drive("F", body), (Position("q", body),))
        t = np.arange(4000) / 1000
        log = Log("by hand", 0.0, 1e-3, {"q": np.sin(7 * t), "F": 30 * np.cos(11 * t)})
        values = dict.fromkeys(axis.physical_parameters, 1.0)
        prediction = prediction_of(record_of(forward_dynamics(axis), log, 40.0), values)
        assert (list(whole.places(prediction)), list(zero.places(prediction))) == places


def test_a_stroke_without_bound_takes_bounded_memory() -> None:
    """Micrometres that are read as metres: the shortest pitch that is sought grows with the stroke."""
    (cogging,) = (effect for effect in LAWS if effect.name == "cogging")
    t = np.arange(4000) / 1000
    log = Log("by hand", 0.0, 1e-3, {"q": 2e5 * np.sin(7 * t), "F": 30 * np.cos(11 * t)})
    prediction = prediction_of(
        record_of(forward_dynamics(load_axis("rigid_1m")), log, 40.0), LEAN | {"Fv": 1.0, "Fs": 1.0}
    )
    noise = np.random.default_rng(1).standard_normal(prediction.record.fine_time.size)
    tracemalloc.start()
    pitches = [pitch for (pitch,) in cogging.shapes(prediction, "motor", lambda _: noise)]
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(pitches) == 5  # four peaks, and the stroke
    assert peak < 300e6


def test_a_library_takes_effects_by_name() -> None:
    drifts = [effect for effect in LIBRARY if effect.name == "friction_drift"]
    assert effects_named(["friction_drift", LAWS[0]]) == (*drifts, LAWS[0])
    assert effects_named("friction_drift") == tuple(drifts)
    with pytest.raises(SettingError, match="no effect is named drag; those of the library are cogging, "):
        diagnose("rigid_1m", [], library=["drag"])
