"""Joints of robots that move with all others (benchmarks/diagnosis/real): no law of the joint alone explains them."""

from dataclasses import replace

import pytest

from benchmarks.diagnosis.real.machines import cases
from symid import Axis, CoulombFriction
from symid.diagnosis import Diagnosis


def found_in(name: str) -> Diagnosis:
    (case,) = cases([name])
    return case.found()


def test_an_effect_stays_that_holds_without_those_that_do_not():
    """A stiffness fits two runs of the axis and not the third."""
    found = found_in("axes-2-hanging")
    (effect,) = found.effects
    assert (found.verdict, effect.effect) == ("partly", "coulomb_friction")
    assert effect.parameters["Fs"].value == pytest.approx(2.0, abs=0.2)  # plain script
    assert 0.2 < effect.removes.share < 0.6


def test_few_cycles_in_a_log_are_no_disturbance():
    """The load that the other joints leave looks like a sine of 0.37 Hz in two runs of 10 s."""
    (case,) = cases(["axes-3"])
    friction = CoulombFriction(case.axis.bodies[0], "Fc")
    axis = Axis("dry", (*case.axis.elements, friction), case.axis.drive, case.axis.sensors)
    found = replace(case, axis=axis, nominal={"J": 7.3, "Fv": 8.1, "Fc": 0.94}).found()
    assert [effect.effect for effect in found.effects] == ["offset_force"]


def test_what_no_log_determines_vetoes_no_effect():
    """The joint is so slow that its inertia does not show: with each right effect it comes out as something else."""
    found = found_in("arm-2-hanging")
    weight, friction = found.effects
    assert (weight.effect, friction.effect) == ("weight", "coulomb_friction")
    assert weight.probability > 0.7
    assert weight.outdone_by == ""
    # plain script with weight and friction
    assert weight.parameters["Gc"].value + found.parameters[2].explained == pytest.approx(1.7, abs=0.1)
    assert friction.parameters["Fs"].value == pytest.approx(0.35, abs=0.05)


def test_a_limit_that_a_third_of_the_samples_exceed_takes_no_small_rest_away():
    """Beside the friction it left noise alone in one run, and a Stribeck friction took the place of both."""
    (effect,) = found_in("arm-1-viscous").effects
    assert effect.effect == "coulomb_friction"
    assert effect.parameters["Fs"].value == pytest.approx(0.146, rel=0.05)  # plain script
