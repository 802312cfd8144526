"""Equations whose parameters data determine: the regressor has full rank in motions of an ODE written by hand."""

import numpy as np
import pytest

from benchmarks import random_axes
from symid import (
    GROUND,
    Acceleration,
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    Geared,
    Position,
    Spring,
    Velocity,
    ViscousFriction,
    derive,
)
from symid.arrays import FloatArray
from symid.codegen.generated_models import compiled
from symid.signal_names import split_derivative

RATES = np.array([0.3j, 0.8j, 1.3j, 1.9j, 2.6j, 3.4j, 4.3j, 5.3j])


def conditioned(rows: FloatArray) -> float:
    """Least singular value over the largest one, of scaled rows and columns."""
    sizes = np.linalg.norm(rows, axis=1)
    rows = rows / np.where(sizes > 0, sizes, 1.0)[:, None]
    values = np.linalg.svd(rows / np.linalg.norm(rows, axis=0), compute_uv=False)
    return float(values[-1] / values[0])


def steady(
    axis: Axis, values: dict[str, float], read: dict[str, tuple[int, FloatArray]], motion: FloatArray
) -> tuple[float, float]:
    """Condition of the regressor and largest error of y = W X in steady vibrations, one for each rate.

    `motion` holds the displacements per unit force, `read` the derivative and the row that a sensor reads.
    """
    model = compiled(derive(axis, tuple(read)))
    t = np.linspace(0.0, 40.0, 300)
    waves = np.exp(np.outer(RATES, t))

    def signal(flat: str) -> FloatArray:
        name, order = split_derivative(flat)
        derivative, row = read.get(name, (0, None))
        size = np.ones(len(RATES)) if row is None else motion @ row
        return np.real((size * RATES ** (order + derivative)) @ waves)

    W, y = model.sample({name: signal(name) for name in model.signals})
    X = model.minimal_parameters(*(values[name] for name in model.physical_units))
    return conditioned(np.concatenate(list(W))), float(np.max(np.abs(W @ X - y)) / np.max(np.abs(y)))


def test_a_wheel_on_a_hub_with_a_hidden_panel() -> None:
    # The balance of the wheel, in all of whose signals that of the hub is too, is no part of the latter.
    hub = Body("hub", inertia="Jh")
    wheel, panel = Body("wheel", inertia="Jw", on=hub), Body("panel", inertia="Jp", on=hub)
    elements = (hub, wheel, ViscousFriction(wheel, "Fv"), panel, Spring("hinge", panel, "K", damping="D"))
    sensors = (Position("q", wheel), Velocity("gyro", hub))
    values = {"Jh": 4.1, "Jw": 0.3, "Fv": 0.2, "Jp": 1.2, "K": 6.0, "D": 0.3}
    mass = np.array([[4.1 + 0.3 + 1.2, 0.3, 1.2], [0.3, 0.3, 0.0], [1.2, 0.0, 1.2]])
    motion = np.array(
        [
            np.linalg.solve(mass * s**2 + np.diag([0, 0.2, 0.3]) * s + np.diag([0, 0, 6.0]), [0.0, 1.0, 0.0])
            for s in RATES
        ]
    )
    read = {"q": (0, np.array([0.0, 1.0, 0.0])), "gyro": (1, np.array([1.0, 0.0, 0.0]))}
    condition, error = steady(Axis("s", elements, Drive("T", wheel), sensors), values, read, motion)
    assert error < 1e-12
    assert condition > 1e-5  # 1e-17 with the balance of the wheel in it


def test_an_accelerometer_on_a_tip_behind_a_gear() -> None:
    # The balance of the tip, differentiated twice, holds no force: that of the motor is differentiated alike.
    motor = Body("motor", inertia=0.5)
    table = Body("table", mass="M", geared=Geared(to=motor, ratio=0.25))
    tip = Body("tip", mass="Mt", on=table)
    laws = (ViscousFriction(motor, "Fv"), CoulombFriction(table, "Fs"))
    elements = (motor, table, tip, Spring("flex", tip, "K", damping="D"), *laws)
    axis = Axis(
        "s", elements, Drive("T", motor), (Position("q", motor), Acceleration("a", tip, relative_to=GROUND))
    )
    assert derive(axis, ("q", "a")).minimal.output_names == ("T", "T_d2")


@pytest.mark.parametrize(("seed", "n"), [(40021, 3), (40103, 4), (40114, 3), (91147, 3), (91197, 3)])
def test_random_axes(seed: int, n: int) -> None:
    rng = np.random.default_rng((seed, n))
    drawn = random_axes.machine(n, rng)
    model = compiled(derive(drawn.axis, tuple(sensor.signal for sensor in drawn.axis.sensors)))
    W, _ = model.sample(drawn.signals(model.signals, rng))
    # at most 4e-16 where a multiple of another could be added
    assert conditioned(np.concatenate(list(W))) > 1e-13


def test_the_relation_of_sensors_of_known_gains_is_no_equation() -> None:
    slide, load = Body("slide", mass="M"), Body("load", mass="Ml")
    sensors = (
        Position("q", slide),
        Position("wire", load, relative_to=slide, offset="o"),
        Acceleration("a", load),
    )
    spring = Spring("s", Between(first=slide, second=load), "K")
    axis = Axis("s", (slide, load, spring, ViscousFriction(slide, "F")), Drive("F1", slide), sensors)
    written = derive(axis, ("q", "wire", "a")).minimal.written
    assert ["X" in row for row in written] == [True, True], written
