"""Minimal parameters under a change of units, and in the limit of stiff springs."""

import numpy as np
import pytest
from axes.catalogue import cases, derived, every_set, generated
from hypothesis import given, settings, strategies as st

from symid import Axis, Between, Body, Drive, Law, PendulumWeight, Position, Spring, Weight, derive
from symid.units import BASE_UNITS, Unit


def knows_a_number(axis: Axis) -> bool:
    """Whether an axis is declared with a ratio, a pitch or gravity."""
    joints = [getattr(element, "at", None) for element in axis.elements]
    ratios = [joint.ratio for joint in joints if isinstance(joint, Between)]
    ratios += [body.geared.ratio for body in axis.bodies if body.geared]
    weighs = any(isinstance(element, (Weight, PendulumWeight)) for element in axis.elements)
    shaped = any(isinstance(element, Law) and element.shape for element in axis.elements)
    return weighs or shaped or any(ratio != 1 for ratio in ratios)


@pytest.mark.parametrize(("name", "chosen"), every_set())
@settings(max_examples=12)
@given(powers=st.tuples(*(st.floats(-3, 3) for _ in BASE_UNITS)))
def test_minimal_parameters_change_with_the_units_as_their_own_unit_says(
    name: str, chosen: tuple[str, ...], powers: tuple[float, ...]
) -> None:
    """Known ratios (m/rad), gravity (m/s^2) and pitches keep their numbers: beside them only kg and A may change."""
    model, derivation = generated(name, chosen), derived(name, chosen)
    free = ("kg", "A") if knows_a_number(cases()[name].declared) else BASE_UNITS
    sizes = {
        unit: 10.0**power if unit in free else 1.0 for unit, power in zip(BASE_UNITS, powers, strict=True)
    }

    def factor(unit: Unit) -> float:
        return float(np.prod([sizes[base] ** -e for base, e in zip(BASE_UNITS, unit.exponents, strict=True)]))

    values, units = cases()[name].values, cases()[name].declared.physical_parameters
    changed = {key: value * factor(units[key]) for key, value in values.items()}
    expected = [
        x * factor(parameter.unit)
        for x, parameter in zip(
            model.minimal_parameters(**values), derivation.minimal.parameters, strict=True
        )
    ]
    assert model.minimal_parameters(**changed) == pytest.approx(expected, rel=1e-9)


def test_millimetres_scale_the_paper_s_parameters_by_hand() -> None:
    """Force stays in newtons: what has metres above the line shrinks by 1000 for each power."""
    assert dict(generated("direct_2m1s", ("q2",)).minimal_units) == {
        "X1": "s^2",
        "X2": "s",
        "X3": "N*s/m",
        "X4": "N",
        "X5": "kg",
        "X6": "kg*s",
        "X7": "kg*s^2",
    }


def test_units_of_minimal_parameters_include_those_of_the_ratio_of_a_screw() -> None:
    """The screw's shares of the slide's mass and weight are an inertia and a torque, over the constant in N*m/A."""
    slide, screw = Body("slide", mass="M"), Body("screw", inertia="J")
    nut = Spring("nut", Between(first=screw, second=slide, ratio=0.00159), stiffness="K")
    drive = Drive("iq", screw, gain="Kt", unit="A")
    model = derive(Axis("hoist", (slide, screw, nut, Weight(slide)), drive, (Position("q", screw),)))
    (row,) = model.minimal.regressor
    units = {str(c): str(p.unit) for c, p in zip(row, model.minimal.parameters, strict=True)}
    assert units == {"-iq_d2": "s^2", "q_d2": "A*s^2/rad", "q_d4": "A*s^4/rad", "1": "A"}


def test_a_stiff_foundation_leaves_the_rigid_motor() -> None:
    """Columns of higher derivatives fade as 1/Ks, the others tend to Fvm, Fsm and Mm."""
    model, values = generated("direct_2m1s", ("q2",)), cases()["direct_2m1s"].values
    previous = np.inf
    for stiffness in (1e9, 1e11, 1e13, 1e15):
        X = model.minimal_parameters(**{**values, "Ks": stiffness})
        rigid = [0, 0, values["Fvm"], values["Fsm"], values["Mm"], 0, 0]
        distance = float(np.max(np.abs(X - rigid) / values["Mm"]))
        assert distance <= 1.01e-2 * previous
        previous = distance
    assert previous < 1e-8


def test_a_stiff_transmission_adds_the_masses() -> None:
    model, values = generated("ballscrew_2m1s", ("qm",)), cases()["ballscrew_2m1s"].values
    X = model.minimal_parameters(**{**values, "Kt": 1e18})
    summed = [0, 0, values["Fvm"] + values["Fvl"], values["Fsm"], values["Mm"] + values["Ml"], 0, 0]
    assert pytest.approx(summed, rel=1e-9, abs=1e-9) == X


def test_stiff_springs_add_the_masses_of_3m2s_behind_a_screw() -> None:
    case, model = cases()["geared_ballscrew_3m2s"], generated("geared_ballscrew_3m2s", ("qs",))
    p, ratio = case.values, 0.01 / (2 * np.pi)
    columns = map(str, derived(case.name, ("qs",)).minimal.regressor[0])
    X = dict(zip(columns, model.minimal_parameters(**{**p, "Kn": 1e20, "Kl": 1e20}), strict=True))
    inertia = p["Js"] + ratio**2 * (p["Mt"] + p["Ml"])
    expected = {"qs_d1": p["Fvs"] + ratio**2 * p["Fvt"], "sign(qs_d1)": p["Fsm"], "qs_d2": inertia}
    assert {name: X.pop(name) for name in expected} == pytest.approx(expected, rel=1e-9)
    assert max(map(abs, X.values())) < 1e-9
