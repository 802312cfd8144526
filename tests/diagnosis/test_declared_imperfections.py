"""Imperfections that an axis declares: their numbers are identified with the parameters, and not found again."""

from dataclasses import fields, replace

import pytest

from benchmarks.effect_machines import LOOP, MOTOR, RIGID, VALUES, machine
from symid import (
    ActuatorDelay,
    ActuatorLag,
    EncoderRipple,
    ForceConstantRipple,
    ForceLimit,
    FrictionDrift,
    FrictionTrend,
    GainAsymmetry,
    GainNonlinearity,
    Imperfection,
    LoadDependentFriction,
    PayloadChange,
    PeriodicForce,
    PreslidingFriction,
)
from symid.diagnosis import diagnose


@pytest.mark.parametrize(
    "element",
    [
        ActuatorDelay(8e-4),
        ActuatorLag(0.004),
        GainNonlinearity(4e-4, power=2),
        GainAsymmetry(0.05),
        EncoderRipple("q", 2e-6, 1e-6, 0.02),
        ForceConstantRipple(0.08, 0.03, 0.02),
        PeriodicForce(MOTOR, 4.0, 3.0, frequency=17.0),
        PayloadChange(MOTOR, 5.0, time=1.5),
        FrictionDrift(MOTOR, 5.0, 30.0, time_constant=2.0),
        FrictionTrend(MOTOR, 2.0, 0.0),
        PreslidingFriction(MOTOR, 12.0, reach=3e-4),
        LoadDependentFriction(MOTOR, 0.05),
    ],
    ids=lambda element: type(element).__name__,
)
def test_what_is_declared_is_identified_and_not_found(element: Imperfection) -> None:
    places = {"at", "body", "signal", "drive", "power", "frequency", "pitch"}
    own = {field.name: getattr(element, field.name) for field in fields(element) if field.name not in places}
    declared = replace(element, **{name: 1.1 * value for name, value in own.items()})
    nominal = {name: 1.05 * VALUES[name] for name in RIGID.physical_parameters}
    logs = [machine(RIGID.with_effect(element), VALUES, seed) for seed in (1, 2)]
    found = diagnose(
        RIGID.with_effect(declared), logs[0], validation=logs[1], nominal=nominal, held=True, controller=LOOP
    )
    assert found.verdict in ("no_gap", "parameters")
    assert not found.effects
    assert "Declared, and identified with the parameters" in found.assumptions[-1]
    changes = [change for change in found.parameters if "." in change.name]
    assert changes
    for change in changes:
        if not change.name.endswith("t0"):  # a moment lies anywhere between two accelerations
            scaled = not change.name.endswith((".pitch", ".f"))
            off = abs(change.reidentified - change.nominal / (1.1 if scaled else 1.0))
            assert off < 4 * change.reidentified_std + 0.02 * abs(change.nominal)


def test_a_steep_ripple_repeats_along_the_true_position() -> None:
    """Taken along the reading, a ripple with a slope of 2 % leaves a second harmonic."""
    declared = RIGID.with_effect(EncoderRipple("q", 2e-5, 1e-5, 0.007))
    nominal = {name: VALUES[name] for name in RIGID.physical_parameters}
    found = diagnose(
        declared, machine(declared, VALUES, 1), nominal=nominal, held=True, controller=LOOP, library=()
    )
    assert found.verdict == "no_gap"


def test_a_declared_coefficient_of_friction_stays_possible() -> None:
    nominal = {name: VALUES[name] for name in RIGID.physical_parameters}
    log = machine(RIGID, VALUES, 1)  # whose noise speaks for a coefficient below 0
    declared = RIGID.with_effect(LoadDependentFriction(MOTOR, 0.05))
    found = diagnose(declared, log, nominal=nominal, held=True, controller=LOOP, library=())
    values = {change.name: change.reidentified for change in found.parameters}
    assert 0 <= values["load_dependent_friction.mu"] < 1e-4
    assert values["M"] == pytest.approx(VALUES["M"], rel=1e-3)


def test_a_declared_limit_is_identified() -> None:
    nominal = {name: VALUES[name] for name in RIGID.physical_parameters}
    log = machine(RIGID.with_effect(ForceLimit(110.0)), VALUES, 1)
    found = diagnose(RIGID.with_effect(ForceLimit(118.0)), log, nominal=nominal, held=True, controller=LOOP)
    limit = next(change for change in found.parameters if change.name == "saturation.limit")
    assert limit.reidentified == pytest.approx(110.0, rel=0.01)
    assert all(one.effect != "saturation" for one in found.effects)


def test_several_declared_imperfections_of_a_kind_keep_their_values_apart() -> None:
    declared = RIGID.with_effect(
        PeriodicForce(MOTOR, 4.0, 3.0, frequency=17.0), PeriodicForce(MOTOR, 2.0, 1.0, frequency=29.0)
    )
    nominal = {name: VALUES[name] for name in RIGID.physical_parameters}
    found = diagnose(declared, machine(declared, VALUES, 1), nominal=nominal, held=True, library=())
    names = [change.name for change in found.parameters]
    assert len(set(names)) == len(names)
    values = {change.name: change.reidentified for change in found.parameters}
    assert values["periodic_disturbance.f"] == pytest.approx(17.0, rel=1e-3)
    assert values["periodic_disturbance_2.f"] == pytest.approx(29.0, rel=1e-3)


def test_an_imperfection_that_no_effect_stands_for_is_passed_over() -> None:
    nominal = {name: VALUES[name] for name in RIGID.physical_parameters}
    idle = RIGID.with_effect(FrictionTrend(MOTOR, 0.0, 0.0))
    found = diagnose(idle, machine(RIGID, VALUES, 1), nominal=nominal, held=True, library=(), controller=LOOP)
    assert found.verdict in ("no_gap", "parameters")
    assert "1 declared imperfections are passed over" in found.assumptions[-1]
