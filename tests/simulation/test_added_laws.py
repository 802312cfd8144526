"""Laws added to a stored axis, beside the forward dynamics that sympy derives of the whole."""

from typing import Any

import numpy as np
import pytest

from symid.axis import Axis, Body, Drive, PayloadChange, Position, Spring, load_axis
from symid.codegen.generation.dynamics_record import dynamics_record
from symid.diagnosis.effects import LIBRARY, LawEffect
from symid.simulation.plants.added_laws import stored_with_laws
from symid.simulation.plants.law_code import array_function

EVERY_LAW = [effect for effect in LIBRARY if isinstance(effect, LawEffect)]
MATRICES = ("stiffness", "damping", "mass", "drives", "constant")


def extended(axis: Axis, effect: LawEffect) -> Axis:
    """The axis with the elements of an effect in its spring, or on both of its bodies."""
    spring = next(element for element in axis.elements if isinstance(element, Spring))
    places = [spring.at] if effect.law.in_spring else list(axis.bodies)
    for i, place in enumerate(places):
        shape, amplitudes = (0.3,) * len(effect.shape_names), (1.0,) * len(effect.amplitudes)
        axis = axis.with_effect(*effect.elements(place, f"new{i}", shape, amplitudes)[0])
    return axis


def numbers(record: dict[str, Any], at: dict[str, float]) -> tuple[list[np.ndarray], np.ndarray]:
    """Matrices at parameter values, and the forces of all laws on the bodies in some motion."""
    values = np.array([at[name] for name in record["generators"]])

    def value(polynomial: list[Any]) -> float:
        return float(sum(c * np.prod(values ** np.array(powers)) for c, powers in polynomial))

    matrices = [np.array([[value(p) for p in row] for row in record[name]]) for name in MATRICES]
    forces, motion = np.zeros(len(matrices[0])), (np.array([0.4, -1.3]), np.array([2.1, -0.7]))
    for law in record["laws"]:
        direction = np.array(law["direction"])
        q, v = (float(direction @ x) for x in motion)
        forces += value(law["parameter"]) * array_function(law["code"])(q, v) * direction
    return matrices, forces


@pytest.mark.parametrize("effect", EVERY_LAW, ids=lambda effect: f"{effect.name}-{len(effect.amplitudes)}")
def test_the_terms_are_those_that_sympy_derives(effect: LawEffect) -> None:
    turns = effect.name == "weight"  # of an unknown angle: on a body that turns
    axis = extended(load_axis("motor_bench" if turns else "ballscrew_2m1s"), effect)
    found, derived = stored_with_laws(axis), dynamics_record(axis)
    assert found is not None
    assert sorted(found["generators"]) == sorted(derived["generators"])
    at = dict(
        zip(sorted(derived["generators"]), np.linspace(0.5, 3.0, len(derived["generators"])), strict=True)
    )
    (own, forces), (whole, all_forces) = numbers(found, at), numbers(derived, at)
    for one, other in zip(own, whole, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-13)
    np.testing.assert_allclose(forces, all_forces, rtol=1e-13)


def test_imperfections_behind_the_laws_change_nothing() -> None:
    axis = extended(load_axis("ballscrew_2m1s"), EVERY_LAW[0])
    heavier = axis.with_effect(PayloadChange(axis.bodies[-1], 2.0, time=1.0))
    assert stored_with_laws(heavier) == stored_with_laws(axis)


def test_an_axis_that_is_not_stored_has_no_record() -> None:
    body = Body("b", mass="M")
    assert stored_with_laws(Axis("unknown", (body,), Drive("F", body), (Position("q", body),))) is None
