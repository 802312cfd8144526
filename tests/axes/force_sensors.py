"""A motor that pulls a load by a spring with a load cell in it, with its equations written by hand."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.integrate import solve_ivp

from symid import Axis, Between, Body, Drive, Force, Position, Sensor, Spring, ViscousFriction

MOTOR, LOAD = Body("motor", mass="Mm"), Body("load", mass="Ml")
SHAFT = Spring("shaft", Between(first=MOTOR, second=LOAD), stiffness="K", damping="D")
DRIVE = Drive("F", MOTOR, held=True, noise=0.1)
ELEMENTS = (MOTOR, ViscousFriction(MOTOR, "Fvm"), SHAFT, LOAD, ViscousFriction(LOAD, "Fvl"))
VALUES = {"Mm": 20.0, "Fvm": 30.0, "K": 4e5, "D": 60.0, "Ml": 35.0, "Fvl": 25.0}
CELL = Force("cell", SHAFT, noise=0.05)
MOTOR_SCALE, LOAD_SCALE = Position("qm", MOTOR, noise=1e-8), Position("ql", LOAD, noise=1e-8)


def celled(sensors: Sequence[Sensor] = (MOTOR_SCALE, LOAD_SCALE, CELL), drive: Drive = DRIVE) -> Axis:
    """The axis with some sensors."""
    return Axis("celled", ELEMENTS, drive, tuple(sensors))


def phasors(omega: float) -> dict[str, complex]:
    """Steady motion of both bodies, force of the spring and of the drive, at a circular frequency."""
    v, s = VALUES, 1j * omega
    coupling = v["K"] + v["D"] * s
    balances = np.array(
        [
            [v["Mm"] * s**2 + v["Fvm"] * s + coupling, -coupling],
            [-coupling, v["Ml"] * s**2 + v["Fvl"] * s + coupling],
        ]
    )
    qm, ql = np.linalg.solve(balances, [1000.0, 0.0])
    return {"qm": qm, "ql": ql, "cell": coupling * (ql - qm), "F": 1000.0 + 0j}


def integrated(
    force: np.ndarray, period: float, bend: Callable[[float], float] = lambda _: 0.0
) -> np.ndarray:
    """Displacements and velocities at the samples under a held force, of shape (n_samples, 4).

    `bend` is a further force of the spring, by its deflection.
    """
    v, states = VALUES, [np.zeros(4)]

    def rates(_: float, x: np.ndarray, pushed: float) -> list[float]:
        pull = v["K"] * (x[1] - x[0]) + v["D"] * (x[3] - x[2]) + bend(x[1] - x[0])
        return [x[2], x[3], (pushed - v["Fvm"] * x[2] + pull) / v["Mm"], (-v["Fvl"] * x[3] - pull) / v["Ml"]]

    for pushed in force[:-1]:
        found = solve_ivp(rates, (0.0, period), states[-1], args=(pushed,), rtol=1e-11, atol=1e-13)
        states.append(found.y[:, -1])
    return np.array(states)
