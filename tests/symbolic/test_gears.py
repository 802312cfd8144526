"""Long geared chains, trees and loops: derivation ends, and its equations hold on matrices written by hand."""

import numpy as np
import pytest

from symid import Axis, Between, Body, Drive, PendulumWeight, Position, Spring, ViscousFriction
from symid.codegen.generated_models import compiled
from symid.errors import EliminationError
from symid.symbolic import derive

SPEEDS = (3.0, 7.0, 11.0, 17.0, 23.0)


def parents_of(shape: str, n: int) -> list[int]:
    return [(i - 1) // 2 if shape == "tree" else i - 1 for i in range(1, n)]


def ratio_of(i: int) -> float:
    return 0.35 if i % 2 else 0.00159


def geared(shape: str, n: int, encoders: tuple[int, ...], closing: float | None = None) -> Axis:
    """Inertias on geared springs with dampers; `closing` is the ratio of a spring from the last to the first."""
    bodies = [Body(f"b{i}", inertia=f"J{i}") for i in range(n)]
    springs = [
        Spring(
            f"s{i}",
            Between(first=bodies[p], second=bodies[i], ratio=ratio_of(i)),
            stiffness=f"K{i}",
            damping=f"D{i}",
        )
        for i, p in enumerate(parents_of(shape, n), start=1)
    ]
    if closing:
        at = Between(first=bodies[0], second=bodies[-1], ratio=closing)
        springs.append(Spring("closing", at, stiffness="Kc", damping="Dc"))
    sensors = tuple(Position(f"q{i}", bodies[i]) for i in encoders)
    elements = (*bodies, ViscousFriction(bodies[0], "Fv"), *springs)
    return Axis("geared", elements, Drive("T", bodies[0]), sensors)


def values_of(axis: Axis) -> dict[str, float]:
    rng = np.random.default_rng(5)
    return {name: float(10 ** rng.uniform(-0.5, 0.5)) for name in axis.physical_parameters}


def response(shape: str, n: int, v: dict[str, float], s: complex, closing: float | None) -> np.ndarray:
    """Displacements for a torque of 1 at the first body: (J s^2 + sum of springs) x = e0, summed spring by spring."""
    Z = np.diag([v[f"J{i}"] * s**2 for i in range(n)]).astype(complex)
    Z[0, 0] += v["Fv"] * s
    ends = [
        (p, i, ratio_of(i), v[f"K{i}"] + v[f"D{i}"] * s) for i, p in enumerate(parents_of(shape, n), start=1)
    ]
    if closing:
        ends.append((0, n - 1, closing, v["Kc"] + v["Dc"] * s))
    for first, second, ratio, k in ends:
        direction = np.zeros(n)
        direction[second] += 1
        direction[first] -= ratio
        Z += k * np.outer(direction, direction)
    return np.linalg.solve(Z, np.eye(n)[0])


def rest_of(axis: Axis, shape: str, n: int, encoders: tuple[int, ...], closing: float | None = None) -> float:
    """Largest relative rest of the derived equations over some frequencies."""
    model = compiled(derive(axis, tuple(f"q{i}" for i in encoders)))
    v, worst = values_of(axis), 0.0
    X = model.minimal_parameters(*(v[name] for name in model.physical_units))
    t = np.linspace(0, 1, 7)
    for speed in SPEEDS:
        s = 1j * speed / 10
        x = response(shape, n, v, s, closing)
        signals = {"T": 1.0, **{f"q{i}": x[i] for i in encoders}}
        flat = {}
        for name in model.signals:
            base, _, order = name.partition("_d")
            flat[name] = (s ** int(order or 0) * signals[base] * np.exp(s * t)).real
        W, y = model.sample(flat)
        for j in range(len(y)):
            size = np.abs(W[j] * X).sum(axis=1).max() + np.abs(y[j]).max()
            worst = max(worst, float(np.abs(y[j] - W[j] @ X).max() / size))
    return worst


@pytest.mark.parametrize(
    ("shape", "n", "encoders", "closing"),
    [
        ("chain", 3, (0,), None),
        ("chain", 4, (0, 3), None),
        ("chain", 5, (0, 4), None),
        ("tree", 5, (0, 4), None),
        ("tree", 8, (0,), None),
        ("chain", 4, (0,), 0.7),
        ("chain", 4, (0, 3), 0.7),
        ("chain", 6, (0,), 0.7),
        ("chain", 7, (0,), 0.7),
        ("tree", 7, (0, 6), None),
    ],
)
def test_equations_hold(shape: str, n: int, encoders: tuple[int, ...], closing: float | None) -> None:
    axis = geared(shape, n, encoders, closing)
    assert rest_of(axis, shape, n, encoders, closing) < 1e-9


def test_each_measured_body_has_its_equation_where_those_of_lower_order_are_too_long() -> None:
    model = derive(geared("chain", 8, (0, 7)), ("q0", "q7"))
    assert any("the balance of one measured body" in text for text in model.assumptions)
    first, last = (
        {str(x) for column in (y, *row) for x in column.free_symbols}
        for y, row in zip(model.minimal.output, model.minimal.regressor, strict=True)
    )
    assert any(name.startswith("T") for name in first)
    assert not any(name.startswith("T") for name in last)  # no drive turns the last body


def test_ratios_keep_their_names_in_short_equations() -> None:
    axis = geared("chain", 2, (0,))
    regressor = str(derive(axis, ("q0",)).minimal.regressor)
    assert "ratio" in regressor or "ratio" in str(
        [p.function.expression for p in derive(axis).minimal.parameters]
    )


def test_what_leads_to_too_many_terms_is_refused_with_a_cure() -> None:
    bodies = [Body(f"b{i}", inertia=f"J{i}") for i in range(8)]
    pairs = [Between(first=bodies[i], second=bodies[j]) for j in range(8) for i in range(j)]
    springs = [Spring(f"s{k}", at, stiffness=f"K{k}", damping=f"D{k}") for k, at in enumerate(pairs)]
    axis = Axis("net", (*bodies, *springs), Drive("T", bodies[0]), (Position("q0", bodies[0]),))
    with pytest.raises(EliminationError, match="add a sensor at one of these bodies"):
        derive(axis, ("q0",))


def test_the_map_of_eight_bodies_is_known_locally() -> None:
    axis = geared("chain", 8, (0,))
    model = derive(axis, ("q0",))
    assert max(len(p.function.numerator) for p in model.minimal.parameters) > 1000
    assert set(model.parameter_map.identifiability) == set(axis.physical_parameters)
    assert "several" in model.parameter_map.identifiability.values()
    assert not model.parameter_map.counted


def test_the_force_of_a_spring_behind_a_gear_is_not_added_to_that_of_the_drive() -> None:
    """Drive train: multiplied by the ratio, the balance of the rotor cancels the shaft in that of the generator.

    The torque of the shaft at the rotor is 97 times that at the generator. In a sum that holds it, its noise moved K
    from 8.7e8 to 4.6e5 N*m/rad.
    """
    generator, rotor = Body("generator", inertia="Jg"), Body("rotor", inertia="Jr")
    shaft = Between(first=generator, second=rotor, ratio=1 / 97)
    elements = (
        generator,
        ViscousFriction(generator, "b"),
        rotor,
        PendulumWeight(rotor, "G"),
        Spring("shaft", shaft, stiffness="K"),
    )
    axis = Axis(
        "turbine", elements, Drive("T", generator), (Position("qg", generator), Position("qr", rotor))
    )
    model = compiled(derive(axis, ("qg", "qr")))
    moved = {"T": 9.0, "qg": 31.0, "qg_d1": 5.0, "qg_d2": 2.0, "qr": 0.3, "qr_d1": 0.05, "qr_d2": 0.02}
    W, y = model.sample({name: np.full(1, value) for name, value in moved.items()})
    names = list(model.physical_units)
    units = dict(zip(names, np.eye(len(names)), strict=True))
    at = {name: float(W[1, 0] @ model.minimal_parameters(*unit)) for name, unit in units.items()}
    assert y[1, 0] == 9.0
    expected = {"Jg": 2.0, "b": 5.0, "Jr": 0.02 / 97, "G": 9.80665 * np.sin(0.3) / 97, "K": 0.0}
    assert at == pytest.approx(expected, rel=1e-12)
