"""A gantry written by hand: two driven carriages, a beam between them, its yaw; matrices, ODE and its log."""

from functools import cache

import numpy as np
from scipy.integrate import solve_ivp

from symid import Axis, Between, Body, CoulombFriction, Drive, Log, Position, Spring, ViscousFriction

LEFT, RIGHT, BEAM = Body("left", mass="M1"), Body("right", mass="M2"), Body("beam", mass="Mb")
AXIS = Axis(
    "gantry",
    (
        LEFT,
        ViscousFriction(LEFT, "Fv1"),
        CoulombFriction(LEFT, "Fs1"),
        RIGHT,
        ViscousFriction(RIGHT, "Fv2"),
        CoulombFriction(RIGHT, "Fs2"),
        BEAM,
        Spring("guide1", Between(first=LEFT, second=BEAM), stiffness="K1"),
        Spring("guide2", Between(first=RIGHT, second=BEAM), stiffness="K2"),
        Spring("yaw", Between(first=LEFT, second=RIGHT), stiffness="Ky", damping="Cy"),
    ),
    (Drive("F1", LEFT), Drive("F2", RIGHT)),
    (Position("q1", LEFT), Position("q2", RIGHT), Position("qb", BEAM)),
)
TRUE = {
    "M1": 40.0,
    "Fv1": 200.0,
    "Fs1": 25.0,
    "M2": 55.0,
    "Fv2": 260.0,
    "Fs2": 40.0,
    "Mb": 60.0,
    "K1": 4e6,
    "K2": 5e6,
    "Ky": 1e6,
    "Cy": 900.0,
}
RATE = 2000.0
NOISE = {"F1": 0.3, "F2": 0.3, "q1": 1e-9, "q2": 1e-9, "qb": 1e-9}
"""Standard deviations, N and m."""
_SOFT = 2e-4
"""Speed below which friction is less than full, m/s: rows near standstill are left out."""


def matrices(p: dict[str, float] = TRUE) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """M, C and K in the displacements of left, right and beam."""
    M = np.diag([p["M1"], p["M2"], p["Mb"]])
    C = np.array([[p["Fv1"] + p["Cy"], -p["Cy"], 0], [-p["Cy"], p["Fv2"] + p["Cy"], 0], [0, 0, 0]])
    K = np.array(
        [
            [p["K1"] + p["Ky"], -p["Ky"], -p["K1"]],
            [-p["Ky"], p["K2"] + p["Ky"], -p["K2"]],
            [-p["K1"], -p["K2"], p["K1"] + p["K2"]],
        ]
    )
    return M, C, K


def reference(t: float) -> tuple[np.ndarray, np.ndarray]:
    """Commanded positions of both carriages, m, and their velocities."""
    stroke = 0.05 * np.sin(1.9 * t) + 0.02 * np.sin(5.3 * t)
    speed = 0.095 * np.cos(1.9 * t) + 0.106 * np.cos(5.3 * t)
    turn, turning = 2e-4 * np.sin(11.0 * t), 2.2e-3 * np.cos(11.0 * t)
    return np.array([stroke + turn, stroke - turn]), np.array([speed + turning, speed - turning])


_LINES = 2 * np.pi * (np.arange(6, 90, 6.0) + np.array([[0.0], [2.3]]))
_PHASES = np.array([[0.07], [0.05]]) * np.arange(6, 90, 6.0) ** 2


def shaken(t: float) -> np.ndarray:
    """Forces that are added to both drives, N: lines up to 90 Hz, other ones for each drive."""
    return np.asarray(40.0 * np.sin(_LINES * t + _PHASES).sum(axis=1))


@cache
def log(seconds: float = 4.0, seed: int = 1) -> Log:
    """A recorded run of `TRUE`: both carriages under a spring and damper to the reference, and shaken."""
    M, C, K = matrices()
    levels = np.array([TRUE["Fs1"], TRUE["Fs2"]])

    def sent(t: float, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        wanted, speed = reference(t)
        return np.asarray(4e5 * (wanted - x[:2]) + 6e3 * (speed - v[:2]) + shaken(t))

    def slope(t: float, state: np.ndarray) -> np.ndarray:
        x, v = state[:3], state[3:]
        force = -C @ v - K @ x
        force[:2] += sent(t, x, v) - levels * np.tanh(v[:2] / _SOFT)
        return np.concatenate([v, force / np.diag(M)])

    t = np.arange(round(seconds * RATE)) / RATE
    run = solve_ivp(slope, (0.0, t[-1]), np.zeros(6), "LSODA", t, rtol=1e-9, atol=1e-13)
    forces = np.array([sent(*row) for row in zip(t, run.y[:3].T, run.y[3:].T, strict=True)]).T
    rng = np.random.default_rng(seed)
    exact = dict(zip(("F1", "F2", "q1", "q2", "qb"), (*forces, *run.y[:3]), strict=True))
    noisy = {name: x + NOISE[name] * rng.standard_normal(t.size) for name, x in exact.items()}
    return Log("by hand", 0.0, 1 / RATE, noisy)
