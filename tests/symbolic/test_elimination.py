"""Elimination: transfer functions, lowest orders of derivative, and refusals that say what to do."""

import numpy as np
import pytest
from axes.case import Case
from axes.catalogue import cases, derived, every_set
from axes.chains import chain_plant, chain_values
from axes.plant import Array, Values

from symid import (
    Acceleration,
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    PendulumWeight,
    Position,
    Spring,
    Velocity,
    ViscousFriction,
    chain,
    load_axis,
)
from symid.codegen import GeneratedModel
from symid.codegen.generated_models import compiled
from symid.errors import EliminationError
from symid.signal_names import split_derivative
from symid.symbolic import derive


def transfer_function(
    model: GeneratedModel, names: list[str], X: Array, s: complex, signal: str, force: str
) -> complex:
    """Force over position from the columns of a motor-only model."""
    motion, forces = 0j, 1 + 0j
    for column, value in zip(names, X, strict=True):
        base, order = split_derivative(column.removeprefix("-"))
        assert (base == force) == column.startswith("-")
        if base == force:
            forces += value * s**order
        else:
            assert base == signal
            motion += value * s**order
    return motion / forces


@pytest.mark.parametrize(
    ("masses", "springs", "driven"),
    [
        (n, k, driven)
        for n in range(2, 7)
        for driven in (1, 2)
        for k in (n - 1, n)
        if n < 6 or (k == 5 and driven == 2)
    ],
)
def test_motor_only_model_of_a_chain_is_its_transfer_function(masses: int, springs: int, driven: int) -> None:
    axis = chain("chain", masses, springs, driven=driven, coulomb=False)
    derived_model = derive(axis)
    names = [str(entry) for entry in derived_model.minimal.regressor[0]]
    model = compiled(derived_model)
    draw = np.random.default_rng(masses)
    values = {
        name: float(draw.uniform(0.5, 2.0))
        for name in chain_values(masses, springs, driven, coulomb_level=None)
    }
    assert list(values) == list(model.physical_units)
    X = model.minimal_parameters(**values)
    machine = chain_plant(Values(values), masses, springs, driven)
    for s in draw.normal(size=6) + 1j * draw.normal(size=6):
        response = np.linalg.solve(machine.M * s**2 + machine.C * s + machine.K, machine.B.astype(complex))
        expected = 1 / (machine.B @ response)
        assert transfer_function(model, names, X, s, f"q{driven}", "F") == pytest.approx(expected, rel=1e-9)
    assert model.highest_derivatives == {"F": 2 * masses - 2, f"q{driven}": 2 * masses}


@pytest.mark.parametrize(
    ("name", "force_order", "motion_order"),
    [("direct_2m1s", 2, 4), ("ballscrew_2m1s", 2, 4), ("direct_3m2s", 4, 6)],
)
def test_orders_of_the_shipped_axes_from_the_motor_alone(
    name: str, force_order: int, motion_order: int
) -> None:
    axis = load_axis(name)
    model = compiled(derive(axis))
    assert model.highest_derivatives == {axis.drive.signal: force_order, axis.sensors[0].signal: motion_order}


ORDERS_COMPARED = [
    (name, chosen)
    for name, chosen in every_set()
    if name.startswith(("chain_2", "chain_3"))
    or name
    in (
        "direct_2m1s",
        "ballscrew_2m1s",
        "direct_3m2s",
        "motor_bench",
        "turning_bench",
        "triangle",
        "both_ends",
        "redundant_sensors",
        "accelerometer_only",
        "friction_in_the_spring",
        "vertical_2m1s",
        "hardening_spring",
    )
]


def lowest_degrees(case: Case, chosen: tuple[str, ...], most: int = 7) -> list[int]:
    """Degrees of a minimal basis of multipliers, from the number of multipliers up to each degree.

    A multiplier l(s) of degree d is n (d + 1) numbers. It must make the columns of unknown displacements vanish, and
    those known from an m-th derivative only divisible by s^m: linear conditions, whose solutions are counted.
    """
    draw = np.random.default_rng(7)
    machine = case.plant(**{name: float(draw.uniform(0.5, 1.5)) for name in case.values})
    n = machine.bodies
    rows, orders = [], []
    for sensor in sorted((case.sensors[signal] for signal in chosen), key=lambda sensor: sensor.order):
        if np.linalg.matrix_rank(np.array([*rows, sensor.row])) > len(rows):
            rows.append(sensor.row)
            orders.append(sensor.order)
    seen = len(rows)
    for unit in np.eye(n):
        if np.linalg.matrix_rank(np.array([*rows, unit])) > len(rows):
            rows.append(tuple(unit))
    operators = [matrix @ np.linalg.inv(np.array(rows)) for matrix in (machine.K, machine.C, machine.M)]
    counts = [0]
    for degree in range(most + 1):
        conditions = []
        for column in range(n):
            for power in range(degree + 3 if column >= seen else orders[column]):
                condition = np.zeros((degree + 1, n))
                for k, operator in enumerate(operators):
                    if 0 <= power - k <= degree:
                        condition[power - k] = operator[:, column]
                conditions.append(condition.ravel())
        rank = np.linalg.matrix_rank(np.array(conditions), tol=1e-9) if conditions else 0
        counts.append(n * (degree + 1) - int(rank))
    new = np.diff(counts)  # multipliers of degree d: one more for each basis row of degree <= d
    assert new[-1] == seen
    return [degree for degree, more in enumerate(np.diff([0, *new])) for _ in range(int(more))]


@pytest.mark.parametrize(("name", "chosen"), ORDERS_COMPARED)
def test_balances_are_differentiated_as_little_as_possible(name: str, chosen: tuple[str, ...]) -> None:
    equations = derived(name, chosen).minimal.source.equations
    found = [max(part.degree(0) for part in equation.multipliers.values()) for equation in equations]
    assert sorted(found) == lowest_degrees(cases()[name], chosen)


def test_the_unseen_middle_of_three_bodies_needs_one_derivative_in_each_equation() -> None:
    """Spring-dampers beside the middle make first-order multipliers: (K + F s) of one side for the other."""
    assert lowest_degrees(cases()["both_ends"], ("qa", "qc")) == [1, 1]


@pytest.mark.parametrize(("name", "chosen"), every_set())
def test_there_are_as_many_equations_as_independent_sensors(name: str, chosen: tuple[str, ...]) -> None:
    rows = np.array([cases()[name].sensors[signal].row for signal in chosen])
    assert len(derived(name, chosen).minimal.output) == np.linalg.matrix_rank(rows)


@pytest.mark.parametrize(("name", "chosen"), every_set())
def test_no_signal_is_integrated_and_every_equation_has_an_output(name: str, chosen: tuple[str, ...]) -> None:
    minimal = derived(name, chosen).minimal
    assert all(output != 0 for output in minimal.output)
    known = {cases()[name].declared.drive.signal, *chosen, *minimal.source.source.constants}
    entries = [*minimal.output, *(entry for row in minimal.regressor for entry in row)]
    assert {split_derivative(str(s))[0] for entry in entries for s in entry.free_symbols} <= known


def motor_and_load() -> tuple[Body, Body, Spring]:
    motor, load = Body("motor", mass="Mm"), Body("load", mass="Ml")
    return motor, load, Spring("coupling", Between(first=motor, second=load), stiffness="K")


def test_coulomb_friction_of_an_unseen_load_is_refused_with_the_sensor_that_helps() -> None:
    motor, load, spring = motor_and_load()
    axis = Axis(
        "unseen",
        (motor, spring, load, CoulombFriction(load, "Fs")),
        Drive("F", motor),
        (Position("qm", motor), Position("ql", load)),
    )
    with pytest.raises(EliminationError) as refused:
        derive(axis, ("qm",))
    message = str(refused.value)
    assert "CoulombFriction at 'load'" in message
    assert "measure ql too" in message
    assert "\n" not in message
    assert len(derive(axis, ("qm", "ql")).minimal.output) == 2
    alone = Axis("unseen", axis.elements, Drive("F", motor), (Position("qm", motor),))
    with pytest.raises(
        EliminationError, match="add a position or velocity sensor of 'load' relative to 'ground'"
    ):
        derive(alone, ("qm",))


def test_a_velocity_sensor_is_enough_for_friction_but_not_for_a_pendulum() -> None:
    motor = Body("motor", inertia="Jm")
    arm = Body("arm", inertia="Ja")
    spring = Spring("coupling", Between(first=motor, second=arm), stiffness="K")
    sensors = (Position("qm", motor), Velocity("dqa", arm))
    with_friction = Axis(
        "friction", (motor, spring, arm, CoulombFriction(arm, "Fs")), Drive("T", motor), sensors
    )
    assert len(derive(with_friction, ("qm", "dqa")).minimal.output) == 2
    with_weight = Axis("weight", (motor, spring, arm, PendulumWeight(arm, "ml")), Drive("T", motor), sensors)
    with pytest.raises(
        EliminationError,
        match=r"PendulumWeight of 'arm'.*add a position sensor of 'arm' relative to 'ground'",
    ):
        derive(with_weight, ("qm", "dqa"))


def test_an_accelerometer_is_not_enough_for_friction() -> None:
    body = Body("body", mass="M")
    axis = Axis(
        "acceleration", (body, CoulombFriction(body, "Fs")), Drive("F", body), (Acceleration("ddq", body),)
    )
    with pytest.raises(EliminationError, match=r"CoulombFriction at 'body'.*position or velocity sensor"):
        derive(axis)


def test_friction_between_two_bodies_names_both() -> None:
    motor, load, spring = motor_and_load()
    across = Between(first=motor, second=load)
    axis = Axis(
        "across",
        (motor, spring, load, CoulombFriction(across, "Fs")),
        Drive("F", motor),
        (Position("qm", motor),),
    )
    with pytest.raises(EliminationError, match="sensor of 'load' relative to 'motor'"):
        derive(axis)


def test_a_sensor_that_repeats_others_is_named_only_if_it_is_not_used() -> None:
    body = Body("body", mass="M")
    sensors = (Position("q", body), Velocity("dq", body), Acceleration("ddq", body), Position("laser", body))
    axis = Axis("repeated", (body, ViscousFriction(body, "Fv")), Drive("F", body), sensors)
    used = derive(axis, ("q", "dq", "ddq"))
    assert [str(entry) for entry in used.minimal.regressor[0]] == ["ddq", "dq"]
    assert used.assumptions == ()
    assert derive(axis, ("q", "laser")).assumptions == (
        "laser repeats what the other sensors measure and is not used",
    )
