"""Maps between minimal and physical parameters, what sensors determine, units and limits."""

import numpy as np
import pytest
import sympy as sp
from axes.catalogue import cases, derived, every_set, generated
from axes.plant import Array
from hypothesis import given, settings, strategies as st

from symid import (
    GROUND,
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    Position,
    Spring,
    ViscousFriction,
    load_axis,
)
from symid.axis import sketch
from symid.codegen import GeneratedModel
from symid.codegen.generated_models import compiled
from symid.symbolic import derive

factors = st.floats(0.5, 2.0)


def varied(data: st.DataObject, values: dict[str, float]) -> dict[str, float]:
    """Values times factors that hypothesis draws."""
    drawn = data.draw(st.tuples(*(factors for _ in values)))
    return {name: value * factor for (name, value), factor in zip(values.items(), drawn, strict=True)}


def physical_branches(model: GeneratedModel, X: Array) -> list[Array]:
    assert model.physical_parameters is not None
    return [model.physical_parameters(*X, branch=branch) for branch in range(model.branches)]


@pytest.mark.parametrize(("name", "chosen"), every_set())
@settings(max_examples=12)
@given(data=st.data())
def test_some_branch_of_the_inverse_map_gives_the_parameters_back(
    name: str, chosen: tuple[str, ...], data: st.DataObject
) -> None:
    model = generated(name, chosen)
    if not model.branches:
        assert model.physical_parameters is None
        return
    values = varied(data, dict(cases()[name].values))
    hidden = cases()[name].hidden.get(chosen, ())
    expected = np.array([np.nan if key in hidden else value for key, value in values.items()])
    found = physical_branches(model, model.minimal_parameters(**values))
    closest = min(found, key=lambda x: np.nanmax(np.abs(x / expected - 1)))
    assert closest == pytest.approx(expected, rel=1e-5, nan_ok=True)


def jacobian(model: GeneratedModel, values: dict[str, float]) -> Array:
    """Relative derivatives of the minimal parameters by the physical ones, by the complex step: exact to rounding."""
    step = 1e-30
    columns = [
        model.minimal_parameters(**{**values, name: value * (1 + step * 1j)}).imag / step
        for name, value in values.items()
    ]
    scale = model.minimal_parameters(**values)
    return np.array(columns).T / scale[:, None]


# Counting the solutions of 3M3S takes a Groebner basis of ten seconds; 2M2S and 4M4S stand for it.
COUNTED = [pair for pair in every_set() if pair != ("chain_3m3s_2", ("q2",))]


@pytest.mark.parametrize(("name", "chosen"), COUNTED)
def test_parameter_map_agrees_with_the_generated_module(name: str, chosen: tuple[str, ...]) -> None:
    """Same numbers; undetermined are those parameters that move in the null space of the numeric derivatives."""
    values = dict(cases()[name].values)
    model, maps = derived(name, chosen), derived(name, chosen).parameter_map
    numbers = {sp.Symbol(k): v for k, v in {**values, **model.minimal.source.source.constants}.items()}
    shown = [float(expression.subs(numbers)) for expression in maps.minimal.values()]
    assert list(maps.minimal) == list(generated(name, chosen).minimal_units)
    assert generated(name, chosen).minimal_parameters(**values) == pytest.approx(shown, rel=1e-9)
    matrix = jacobian(generated(name, chosen), values)
    _, sizes, directions = np.linalg.svd(matrix)
    rank = int(np.sum(sizes > 1e-10 * sizes[0]))
    moving = np.abs(directions[rank:]).max(axis=0, initial=0.0) > 1e-8
    assert [key for key, free in zip(values, moving, strict=True) if free] == [
        key for key, state in maps.identifiability.items() if state == "none"
    ]
    assert maps.relations == len(matrix) - rank
    assert len(maps.inverse) == generated(name, chosen).branches


def test_the_paper_s_axis_is_unique_from_every_set_of_sensors() -> None:
    for chosen in load_axis("direct_2m1s").sensor_sets:
        assert set(derived("direct_2m1s", chosen).parameter_map.identifiability.values()) == {"unique"}


def test_a_ball_screw_seen_from_its_motor_has_one_solution_with_the_declared_signs() -> None:
    maps = derived("ballscrew_2m1s", ("qm",)).parameter_map
    assert len(maps.inverse) == 2
    assert set(maps.identifiability.values()) == {"unique"}
    assert set(derived("ballscrew_2m1s", ("qm", "ql")).parameter_map.identifiability.values()) == {"unique"}


def test_both_solutions_of_the_ball_screw_have_the_same_minimal_parameters() -> None:
    model = generated("ballscrew_2m1s", ("qm",))
    X = model.minimal_parameters(**cases()["ballscrew_2m1s"].values)
    first, second = physical_branches(model, X)
    names = list(model.physical_units)
    for solution in (first, second):
        assert model.minimal_parameters(**dict(zip(names, solution, strict=True))) == pytest.approx(
            X, rel=1e-9
        )
    differing = {name for name, a, b in zip(names, first, second, strict=True) if abs(a - b) > 1e-3 * abs(a)}
    assert differing == {"Fvm", "Kt", "Ft", "Ml", "Fvl"}


def swapped(p: dict[str, float]) -> dict[str, float]:
    """The other axis 3M2S with the same motion of the motor, by partial fractions.

    With f = Fm - Fvm q2', q2 / f is the compliance of the structure, 1 / (Ms s^2 + Fvs s + Ks), plus that of motor and
    load: 1 / (M s^2) + 1 / (a s^2 + b s + c), with M = Mm + Ml, a = Mm M / Ml, b = Fl (M / Ml)^2 and c = Kl (M / Ml)^2.
    The two vibrating parts may change places.
    """
    M = p["Mm"] + p["Ml"]
    new_load = M**2 / (M + p["Ms"])
    return {
        "Ms": p["Mm"] * M / p["Ml"],
        "Fvs": p["Fl"] * (M / p["Ml"]) ** 2,
        "Ks": p["Kl"] * (M / p["Ml"]) ** 2,
        "Mm": M - new_load,
        "Fvm": p["Fvm"],
        "Fsm": p["Fsm"],
        "Kl": p["Ks"] * (new_load / M) ** 2,
        "Fl": p["Fvs"] * (new_load / M) ** 2,
        "Ml": new_load,
    }


@given(data=st.data())
def test_structure_and_load_of_3m2s_may_change_places_behind_the_motor(data: st.DataObject) -> None:
    model = generated("direct_3m2s", ("q2",))
    values = varied(data, dict(cases()["direct_3m2s"].values))
    other = swapped(values)
    assert min(other.values()) > 0
    assert model.minimal_parameters(**other) == pytest.approx(model.minimal_parameters(**values), rel=1e-10)
    assert swapped(other) == pytest.approx(values, rel=1e-10)
    assert other["Ms"] != pytest.approx(values["Ms"], rel=1e-3)


def test_3m2s_has_several_solutions_from_the_motor_and_one_from_all_sensors() -> None:
    alone = derived("direct_3m2s", ("q2",)).parameter_map.identifiability
    values = cases()["direct_3m2s"].values
    other = swapped(dict(values))
    differing = {name for name in values if abs(other[name] - values[name]) > 1e-6 * values[name]}
    assert {name for name, state in alone.items() if state == "several"} == differing
    assert {name for name, state in alone.items() if state == "unique"} == {"Fvm", "Fsm"}
    everything = derived("direct_3m2s", ("q2", "ddq1", "ddql")).parameter_map.identifiability
    assert set(everything.values()) == {"unique"}


def test_a_first_sketch_of_three_bodies_is_not_counted_and_says_so() -> None:
    """Five unknowns are left over: a Groebner basis of them takes longer than any user waits."""
    maps = derive(sketch("first", 3)).parameter_map
    assert not maps.counted
    assert {name for name, state in maps.identifiability.items() if state == "unique"} == {"Mm", "Fsm"}
    assert "none" not in maps.identifiability.values()


def test_masses_side_by_side_are_determined_as_their_sum() -> None:
    maps = derived("parallel_masses", ("q",)).parameter_map
    assert maps.identifiability == {"M1": "none", "Fv": "unique", "M2": "none"}
    assert [str(combination) for combination in maps.combinations] == ["M1 + M2"]


def test_springs_side_by_side_are_determined_as_their_sum() -> None:
    maps = derived("two_springs", ("q",)).parameter_map
    assert maps.identifiability == {"M": "unique", "F": "unique", "K1": "none", "K2": "none"}
    assert [str(combination) for combination in maps.combinations] == ["K1 + K2"]
    assert maps.inverse == ()


def test_a_rigid_gear_hides_what_lies_on_either_side() -> None:
    maps = derived("overdrive_gear", ("qm",)).parameter_map
    assert set(maps.identifiability.values()) == {"none"}
    assert [str(function) for function in maps.combinations] == ["Jm + 4*Mt", "Fvm + 4*Fvt", "Fsm + 2*Fst"]


def test_a_structure_that_the_sensor_does_not_feel_is_not_determined() -> None:
    structure = Body("structure", mass="Ms")
    motor = Body("motor", mass="Mm", on=structure)
    axis = Axis(
        "absolute",
        (structure, Spring("foundation", structure, stiffness="Ks"), motor),
        Drive("F", motor),
        (Position("x", motor, relative_to=GROUND),),
    )
    model = derive(axis)
    assert [str(entry) for entry in model.minimal.regressor[0]] == ["x_d2"]
    assert model.parameter_map.identifiability == {"Ms": "none", "Ks": "none", "Mm": "unique"}


def test_3m2s_without_coulomb_friction_has_ten_minimal_parameters_for_eight_physical_ones() -> None:
    axis = load_axis("direct_3m2s")
    smooth = axis.without(*(law for law in axis.laws if isinstance(law, CoulombFriction)))
    model = derive(smooth)
    assert (len(model.minimal.parameters), len(smooth.physical_parameters)) == (10, 8)
    assert model.parameter_map.relations == 2


def test_the_sign_of_a_parameter_is_free_only_where_a_law_says_so() -> None:
    assert cases()["emps"].declared.signed_parameters == ("OF",)
    assert generated("motor_bench", ("qm", "ql")).signed == ("Pt",)
    assert cases()["direct_2m1s"].declared.signed_parameters == ()


def test_a_viscous_chain_of_one_is_linear_and_needs_no_inverse() -> None:
    body = Body("body", mass="M")
    axis = Axis("one", (body, ViscousFriction(body, "F")), Drive("f", body), (Position("q", body),))
    model = compiled(derive(axis))
    assert model.minimal_parameters(M=2.0, F=3.0).tolist() == [2.0, 3.0]
    assert model.physical_parameters is not None
    assert model.physical_parameters(2.0, 3.0).tolist() == [2.0, 3.0]


def test_a_star_whose_closed_inverse_takes_minutes_is_inverted_numerically() -> None:
    """Damping in one of two springs and friction at the other's end: common divisors of its coefficients explode."""
    hub, one, other = (Body(name, mass=f"M{i}") for i, name in enumerate(("hub", "one", "other")))
    springs = (
        Spring("stiff", Between(first=hub, second=one), stiffness="K1"),
        Spring("soft", Between(first=hub, second=other), stiffness="K2", damping="C2"),
    )
    laws = (ViscousFriction(one, "F1"),)
    axis = Axis("star", (hub, one, other, *springs, *laws), Drive("F", hub), (Position("q", hub),))
    model = compiled(derive(axis, ("q",)))
    assert model.physical_parameters is None
    assert len(model.minimal_parameters(M0=1.0, M1=2.0, M2=3.0, K1=4e4, K2=5e4, C2=60.0, F1=7.0)) >= 7
