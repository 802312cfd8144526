"""Known and shared parameters in derived models, against equations of motion written by hand."""

import math

import numpy as np
import pytest

from symid import (
    Axis,
    Between,
    Body,
    Cogging,
    CoulombFriction,
    Drive,
    Geared,
    Position,
    Spring,
    ViscousFriction,
    load_axis,
)
from symid.axis import Element
from symid.codegen.generated_models import compiled
from symid.simulation import plant_of
from symid.symbolic import derive

VALUES = {"Ms": 3899.0, "Fvs": 5000.0, "Ks": 3.2e8, "Mm": 362.6, "Fvm": 1500.0, "Fsm": 40.0}


def regression(axis: Axis, sensors: tuple[str, ...], flat: dict[str, np.ndarray], values: dict[str, float]):
    """Rest y - W X of a model at true parameters, relative to the output's own signal."""
    model = compiled(derive(axis, sensors))
    W, y = model.sample(flat)
    X = model.minimal_parameters(*(values[name] for name in model.physical_units))
    return model, np.abs(y - W @ X).max() / np.abs(y).max()


def two_masses(w: float, t: np.ndarray) -> dict[str, np.ndarray]:
    """Steady oscillation of the paper's axis without Coulomb friction, from its two balances at one frequency."""
    v, s = VALUES, 1j * w
    # x: structure, q: motor against structure; F drives the motor and pushes back on the structure
    structure = np.array([v["Ms"] * s**2 + v["Fvs"] * s + v["Ks"], -v["Fvm"] * s])
    motor = np.array([v["Mm"] * s**2, v["Mm"] * s**2 + v["Fvm"] * s])
    x, q = np.linalg.solve(np.array([structure, motor]), np.array([-1.0, 1.0]))
    flat = {}
    for name, value, first, last in (("Fm", 1.0, 0, 4), ("q2", q, 0, 5), ("ddq1", s**2 * x, 0, 3)):
        for order in range(first, last):
            flat[name if order == 0 else f"{name}_d{order}"] = (s**order * value * np.exp(s * t)).real
    return flat


@pytest.mark.parametrize("sensors", [("q2",), ("q2", "ddq1")])
@pytest.mark.parametrize("known", [("Ms",), ("Mm", "Ks"), ("Ms", "Fvs", "Fvm"), ("Ks", "Ms", "Mm")])
def test_known_parameters_leave_the_unknown_ones(sensors: tuple[str, ...], known: tuple[str, ...]) -> None:
    axis = load_axis("direct_2m1s")
    # no Coulomb friction
    plain = axis.without(axis.laws[-1]).with_known({name: VALUES[name] for name in known})
    model, rest = regression(plain, sensors, two_masses(2 * math.pi * 31, np.linspace(0, 0.1, 50)), VALUES)
    assert rest < 1e-9
    assert not set(known) & set(model.physical_units)
    assert dict(model.known) == {name: (VALUES[name], unit) for name, (_, unit) in model.known.items()}
    truth = [VALUES[name] for name in model.physical_units]
    assert model.physical_parameters is not None
    X = model.minimal_parameters(*truth)
    branches = [model.physical_parameters(*X, branch=i) for i in range(model.branches)]
    assert min(np.abs(found / truth - 1).max() for found in branches) < 1e-6


def test_units_of_minimal_parameters_follow_those_of_known_ones() -> None:
    axis = load_axis("direct_2m1s")
    free, known = (derive(a, ("q2",)) for a in (axis, axis.with_known({"Ms": 3899.0, "Ks": 3.2e8})))
    units = {
        str(row): str(p.unit)
        for row, p in zip(zip(*free.minimal.regressor, strict=True), free.minimal.parameters, strict=True)
    }
    for column, parameter in zip(
        zip(*known.minimal.regressor, strict=True), known.minimal.parameters, strict=True
    ):
        if str(parameter.function.expression) not in axis.physical_parameters:
            assert units[str(column)] == str(parameter.unit)


def test_a_known_mass_of_zero_is_a_node_without_mass() -> None:
    """Two springs in series: a node between motor and load is the spring K1 K2/(K1 + K2)."""
    motor, node, load = Body("motor", mass="Mm"), Body("node", mass=0.0), Body("load", mass="Ml")
    elements: tuple[Element, ...] = (
        motor,
        ViscousFriction(motor, "Fv"),
        node,
        Spring("first", Between(first=motor, second=node), stiffness="K1"),
        load,
        Spring("second", Between(first=node, second=load), stiffness="K2"),
    )
    axis = Axis("series", elements, Drive("F", motor), (Position("q", motor),))
    K, Mm, Ml, Fv = 1 / (1 / 3e6 + 1 / 7e6), 12.0, 40.0, 90.0
    s, t = 2j * math.pi * 17, np.linspace(0, 0.2, 40)
    q = 1 / (Mm * s**2 + Fv * s + K - K**2 / (Ml * s**2 + K))
    flat = {"F": np.exp(s * t).real}
    for order in range(5):
        flat["q" if order == 0 else f"q_d{order}"] = (s**order * q * np.exp(s * t)).real
        flat["F" if order == 0 else f"F_d{order}"] = (s**order * np.exp(s * t)).real
    _, rest = regression(axis, ("q",), flat, {"Mm": Mm, "Ml": Ml, "Fv": Fv, "K1": 3e6, "K2": 7e6})
    assert rest < 1e-9
    assert derive(axis, ("q",)).parameter_map.identifiability["K1"] == "none"


def test_shared_parameters_are_one_column() -> None:
    """Two equal carriages behind one pinion: M and Fv act twice, levers add in squares."""
    screw = Body("screw", inertia="J")
    left = Body("left", mass="M", geared=Geared(to=screw, ratio=0.02))
    right = Body("right", mass="M", geared=Geared(to=screw, ratio=-0.03))
    elements: tuple[Element, ...] = (
        screw,
        left,
        right,
        ViscousFriction(left, "Fv"),
        ViscousFriction(right, "Fv"),
        CoulombFriction(screw, 0.7),
    )
    axis = Axis("twins", elements, Drive("T", screw), (Position("q", screw),))
    assert list(axis.physical_parameters) == ["J", "M", "Fv"]
    model = compiled(derive(axis, ("q",)))
    rng = np.random.default_rng(3)
    flat = {name: rng.standard_normal(30) for name in model.signals}
    W, y = model.sample(flat)
    lever = 0.02**2 + 0.03**2
    J, M, Fv = 2e-3, 5.0, 80.0
    torque = (J + M * lever) * flat["q_d2"] + Fv * lever * flat["q_d1"] + 0.7 * np.sign(flat["q_d1"])
    W, y = model.sample({**flat, "T": torque})
    assert np.allclose(W[0] @ model.minimal_parameters(J, M, Fv), y[0], rtol=1e-12)
    assert derive(axis, ("q",)).parameter_map.identifiability["Fv"] == "unique"


def test_a_law_that_is_known_to_be_zero_adds_nothing() -> None:
    table = Body("table", mass="M")
    laws = (CoulombFriction(table, 0.0), Cogging(table, 0.0, 4.0, pitch=0.05))
    idle = Axis("idle", (table, *laws), Drive("F", table), (Position("q", table),))
    # 4 cos(2 pi q/p) at q = p/2
    assert sum(law.force(0.025, -1.0) for law in plant_of(idle, {"M": 5.0}).laws) == pytest.approx(-4.0)
    assert "sin(" not in str(derive(idle))
