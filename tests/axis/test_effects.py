"""Laws of effects: forces by hand, faults of their numbers, and their parameters back from simulated logs."""

import math
from dataclasses import replace

import numpy as np
import pytest
from axes.effects import EFFECTS, values_of, with_effect

from symid import (
    AsymmetricFriction,
    Axis,
    Backlash,
    Body,
    Cogging,
    CoulombFriction,
    Drive,
    FrictionAsymmetry,
    Log,
    PeriodicFriction,
    Position,
    Preparation,
    Spring,
    SpringDamping,
    StribeckFriction,
    ViscousFriction,
    compiled,
    derive,
    identify,
    load_axis,
)
from symid.errors import DeclarationError, EliminationError
from symid.output_error import identify_output_error
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

IN_A_JOINT = [name for name, effect in EFFECTS.items() if not effect.in_spring]
IN_A_SPRING = [name for name, effect in EFFECTS.items() if effect.in_spring]


def alone(name: str) -> Axis:
    """One body and nothing but the law."""
    body = Body("motor", mass="M")
    return Axis("alone", (body, EFFECTS[name].law(body)), Drive("F", body), (Position("q", body),))


def simulated(axis: Axis, values: dict[str, float], rate: float) -> Log:
    """Short and long, slow and fast moves under a cascade whose force is held."""
    reference = trapezoids(
        [0.2], [0.03, 0.1, 0.4], acceleration=4.0, jerk=200.0, dwell=0.1, sampling_period=1 / rate
    )
    signal = axis.sensors[0].signal
    controller = tuned_cascade(plant_of(axis, values), signal, bandwidth_hz=8.0)
    return simulate(axis, values, reference, controller).log


@pytest.mark.parametrize("name", EFFECTS)
def test_the_force_of_the_simulation_is_that_by_hand(name: str) -> None:
    plant = plant_of(alone(name), {"M": 1.0, **EFFECTS[name].values})
    for (q, v), force in EFFECTS[name].forces.items():
        nonlinear = sum(law.force(q, v) for law in plant.laws)
        linear = plant.stiffness.item() * q - plant.constant.item()
        assert linear + nonlinear == pytest.approx(force, rel=1e-12, abs=1e-12), (q, v)


@pytest.mark.parametrize("name", EFFECTS)
def test_the_column_of_the_regressor_is_the_force_by_hand(name: str) -> None:
    model = compiled(derive(alone(name)))
    X = model.minimal_parameters(M=0.0, **EFFECTS[name].values)
    for (q, v), force in EFFECTS[name].forces.items():
        signals = {"F": 0.0, "q": q, "q_d1": v, "q_d2": 7.0}
        W = model.regressor(*(signals[signal] for signal in model.signals))
        assert W[0, 0] @ X == pytest.approx(force, rel=1e-12, abs=1e-12), (q, v)


@pytest.mark.parametrize("name", EFFECTS)
def test_units(name: str) -> None:
    units = alone(name).physical_parameters
    assert tuple(str(units[parameter]) for parameter in EFFECTS[name].values) == EFFECTS[name].units


def test_all_faults_of_numbers_are_reported_at_once() -> None:
    body = Body("motor", mass="M")
    laws = (
        StribeckFriction(body, "F1", velocity=0.0),
        Cogging(body, "A1", "A2", pitch=-0.03),
        PeriodicFriction(body, "A3", "A4", pitch=math.inf),
        Backlash(body, "K", gap=math.nan),
        Cogging(body, "A5", "A6", pitch="30 mm"),
        StribeckFriction(body, "F6", velocity=True),
    )
    with pytest.raises(DeclarationError) as refused:
        Axis("faulty", (body, *laws), Drive("F", body), (Position("q", body),))
    assert set(refused.value.faults) == {
        "StribeckFriction at 'motor': velocity is 0.0: it must be a positive finite number",
        "Cogging at 'motor': pitch is -0.03: it must be a positive finite number",
        "PeriodicFriction at 'motor': pitch is inf: it must be a positive finite number",
        "Backlash at 'motor': gap is nan: it must be a positive finite number",
        "Cogging at 'motor': pitch is '30 mm': it must be a positive finite number",
        "StribeckFriction at 'motor': velocity is True: it must be a positive finite number",
    }


def test_a_number_says_the_same_in_every_type() -> None:
    axis = load_axis("rigid_1m")
    laws = [StribeckFriction(axis.bodies[0], "dF", velocity=v) for v in (1, 1.0, np.float64(1.0))]
    assert len({axis.with_effect(law).signature for law in laws}) == 1
    assert axis.with_effect(StribeckFriction(axis.bodies[0], "dF", velocity=1.1)).signature not in {
        axis.with_effect(law).signature for law in laws
    }


def test_parameters_that_may_be_negative() -> None:
    signed = {name: with_effect(name).signed_parameters for name in EFFECTS}
    never = {"stribeck", "drag", "backlash", "gap_damping"}
    assert {name for name, parameters in signed.items() if not parameters} == never
    assert all(signed[name] == tuple(EFFECTS[name].values) for name in EFFECTS if name not in never)


@pytest.mark.parametrize("name", IN_A_SPRING)
def test_a_law_that_no_sensor_sees_is_named_with_its_cure(name: str) -> None:
    with pytest.raises(EliminationError, match="measure ql too"):
        derive(with_effect(name), ("qm",))


def test_a_stiffness_needs_no_sensor_and_is_that_of_a_spring() -> None:
    axis = load_axis("ballscrew_2m1s")
    load = axis.bodies[1]
    from_law = derive(axis.with_effect(EFFECTS["stiffness"].law(load)), ("qm",))
    from_spring = derive(axis.with_effect(Spring("guide", load, "k")), ("qm",))
    assert from_law.minimal.regressor == from_spring.minimal.regressor
    assert [p.function for p in from_law.minimal.parameters] == [
        p.function for p in from_spring.minimal.parameters
    ]


def test_damping_of_a_spring_is_that_of_its_declaration() -> None:
    axis = load_axis("ballscrew_2m1s")
    (spring,) = (element for element in axis.elements if isinstance(element, Spring))
    others = tuple(element for element in axis.elements if element is not spring)
    apart = replace(axis, elements=(*others, replace(spring, damping=None), SpringDamping(spring.at, "Ft")))
    assert {str(p.function) for p in derive(apart, ("qm",)).minimal.parameters} == {
        str(p.function) for p in derive(axis, ("qm",)).minimal.parameters
    }


def test_an_asymmetry_beside_friction_is_asymmetric_friction() -> None:
    """Levels 25 and 15, coefficients 90 and 110 are 20 -+ 5 and 100 +- 10."""
    body = Body("motor", mass="M")
    drive, sensors = Drive("F", body), (Position("q", body),)
    halves = (ViscousFriction(body, "Fv"), CoulombFriction(body, "Fs"), FrictionAsymmetry(body, "dFs", "dFv"))
    sides = AsymmetricFriction(body, viscous=("Fvp", "Fvn"), coulomb=("Fsp", "Fsn"))
    first = plant_of(
        Axis("halves", (body, *halves), drive, sensors),
        {"M": 1.0, "Fv": 100.0, "Fs": 20.0, "dFs": 5.0, "dFv": -10.0},
    )
    second = plant_of(
        Axis("sides", (body, sides), drive, sensors),
        {"M": 1.0, "Fvp": 90.0, "Fvn": 110.0, "Fsp": 25.0, "Fsn": 15.0},
    )
    for v in (-2.0, -1e-3, 1e-3, 0.7):
        total = (
            sum(law.force(0.0, v) for law in first.laws) + first.damping.item() * v - first.constant.item()
        )
        assert total == pytest.approx(sum(law.force(0.0, v) for law in second.laws))


def test_derivatives_that_are_left_out_are_reported() -> None:
    """The second derivative of abs jumps: without Coulomb friction nothing else would say so."""
    axis = load_axis("direct_2m1s")
    smooth = axis.without(axis.elements[-1])
    assert derive(smooth).assumptions == ()
    backlash = smooth.with_effect(Backlash(axis.bodies[1], "Kb", gap=0.5))
    assert derive(backlash).assumptions == (
        "derivatives of sign(q2 + 0.25) are taken as zero",
        "derivatives of sign(q2 - 0.25) are taken as zero",
    )
    assert compiled(derive(backlash)).sliding == ((),)


def test_a_cube_is_a_law_column_and_a_stiffness_is_not() -> None:
    assert compiled(derive(alone("hardening"))).law_columns == ((0, 1),)
    assert compiled(derive(alone("stiffness"))).law_columns == ()


@pytest.mark.parametrize("name", EFFECTS)
def test_least_squares_finds_the_effect_of_a_simulated_log(name: str) -> None:
    axis, values, rate = with_effect(name), values_of(name), 4000.0
    model = compiled(derive(axis, tuple(sensor.signal for sensor in axis.sensors)))
    late = {axis.drive.signal: -0.5 / rate}
    found = identify(model, simulated(axis, values, rate), preparation=Preparation(late=late), examine=False)
    assert found.status == "ok"
    for parameter in EFFECTS[name].values:
        assert found.physical_parameters[parameter] == pytest.approx(values[parameter], rel=0.01), parameter


@pytest.mark.parametrize("name", IN_A_JOINT)
def test_output_error_finds_the_effect_of_a_simulated_log(name: str) -> None:
    axis, values = with_effect(name), values_of(name)
    exact = simulated(axis, values, 500.0)
    random = np.random.default_rng(1)
    noise = {"q": 1e-9, "F": 3e-2}
    signals = {key: exact[key] + noise[key] * random.standard_normal(exact.n_samples) for key in noise}
    log = Log.from_arrays(signals, sampling_period=1 / 500.0)
    found = identify_output_error(axis, compiled(derive(axis)), log, preparation=Preparation(held=True))
    assert found.status == "ok"
    for parameter, value in values.items():
        assert found.physical_parameters[parameter] == pytest.approx(value, rel=0.01), parameter
