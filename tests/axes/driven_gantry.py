"""A gantry whose beam turns against its guides, written by hand in coordinates of the carriages, and what it hides."""

from functools import cache

import numpy as np
from scipy.integrate import solve_ivp

from symid import Axis, Body, CoulombFriction, Drive, Geared, Log, Position, Spring, ViscousFriction

SPAN = 1.25
LEFT, RIGHT = Body("left", mass=31.5), Body("right", mass=31.5)
BEAM = Body("beam", mass="Mb", geared=(Geared(to=LEFT, ratio=0.5), Geared(to=RIGHT, ratio=0.5)))
YAW = Body("yaw", inertia="J", geared=(Geared(to=LEFT, ratio=-1 / SPAN), Geared(to=RIGHT, ratio=1 / SPAN)))
TRUE = {"Fv1": 90.0, "Fs1": 22.0, "Fv2": 130.0, "Fs2": 35.0, "Mb": 84.0, "J": 11.0, "Ky": 6e5, "Cy": 350.0}
RATE = 1000.0
STRIBECK, SLOW = 18.0, 0.03
"""Further friction of the right carriage at rest, N, and the speed at which it has mostly gone, m/s."""
COGGING, PITCH = 6.0, 0.024
"""Force ripple of the left motor, N and m."""
LOAD, LOADED = 12.0, 1.9
"""What the beam carries from a moment on, kg and s."""
RIPPLE = 0.15
"""Of the force constant of the left motor, relative to its mean, with the pitch of the cogging."""
DELAY = 1.7e-3
"""Of the left drive, s."""
GAIN, HASTE = 8e3, 50.0
"""Gains of both controllers: of the speed, N s/m, and of the position, 1/s."""
_SOFT = 2e-4
"""Speed below which friction is less than full, m/s."""
_NOISE = {"F1": 1.0, "F2": 1.0, "q1": 2e-8, "q2": 2e-8}
_APART = np.array([-1.0, 1.0]) / SPAN
_TURN = np.outer(_APART, _APART)
_STIFFNESS = TRUE["Ky"] * _TURN
_LEVELS = np.array([[TRUE["Fs1"]], [TRUE["Fs2"]]])


def axis(*, friction_on_the_right: bool = True) -> Axis:
    """The declared gantry."""
    right = (CoulombFriction(RIGHT, "Fs2"),) if friction_on_the_right else ()
    return Axis(
        "gantry",
        (
            *(LEFT, ViscousFriction(LEFT, "Fv1"), CoulombFriction(LEFT, "Fs1")),
            *(RIGHT, ViscousFriction(RIGHT, "Fv2"), *right),
            *(BEAM, YAW, Spring("guides", YAW, stiffness="Ky", damping="Cy")),
        ),
        (Drive("F1", LEFT), Drive("F2", RIGHT)),
        (Position("q1", LEFT), Position("q2", RIGHT)),
    )


class _Commanded:
    """Common moves of both carriages, small turns, and lines up to 90 Hz that differ for both drives."""

    def __init__(self, seed: int) -> None:
        draw = np.random.default_rng(seed)
        moves = 2 * np.pi * draw.uniform(0.3, 1.3, 4), draw.uniform(0, 6.3, 4), draw.uniform(0.02, 0.08, 4)
        turns = 2 * np.pi * draw.uniform(3.0, 30.0, 5), draw.uniform(0, 6.3, 5)
        lines = 2 * np.pi * (np.arange(5, 90, 5) + draw.uniform(-1, 1, 17)), draw.uniform(0, 6.3, (2, 17))
        # All waves in one sum: rows are the wanted positions of both carriages, and what shakes each of them.
        self.w = np.concatenate([moves[0], turns[0], lines[0], lines[0]])
        self.phases = np.concatenate([moves[1], turns[1], *lines[1]])
        self.sizes = np.zeros((4, self.w.size))
        self.sizes[:2, :4] = moves[2]
        self.sizes[:2, 4:9] = [[-1e-4], [1e-4]]
        self.sizes[2, 9:26] = self.sizes[3, 26:] = 8.0

    def reference(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Wanted positions of both carriages and their speeds, each of shape (2, n)."""
        angles = self.w[:, None] * t + self.phases[:, None]
        return self.sizes[:2] @ np.sin(angles), (self.sizes[:2] * self.w) @ np.cos(angles)

    def force(self, t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Of a spring and a damper to the reference, and the lines; all of shape (2, n)."""
        angles = self.w[:, None] * t + self.phases[:, None]
        waves, speed = self.sizes @ np.sin(angles), (self.sizes[:2] * self.w) @ np.cos(angles)
        return np.asarray(GAIN * (HASTE * (waves[:2] - x) + speed - v) + waves[2:])


def _resisting(hidden: str, x: np.ndarray, v: np.ndarray) -> np.ndarray:
    side = np.tanh(v / _SOFT)
    force = _LEVELS * side
    if hidden == "stribeck":
        force[1] += STRIBECK * side[1] * np.exp(-((v[1] / SLOW) ** 2))
    if hidden == "cogging":
        force[0] += COGGING * np.sin(2 * np.pi * x[0] / PITCH + 0.7)
    return np.asarray(force)


@cache
def log(
    hidden: str = "",
    seconds: float = 4.0,
    seed: int = 1,
    beam: float = TRUE["Mb"],
    friction: float = TRUE["Fv1"],
) -> Log:
    """A recorded run, on its reference from the beginning; a force that acts late is recorded ahead of its time."""
    command = _Commanded(seed)
    mass = np.diag([31.5, 31.5]) + beam / 4 + TRUE["J"] * _TURN
    inverses = [np.linalg.inv(mass + more / 4) for more in (0.0, LOAD if hidden == "payload" else 0.0)]
    damping = np.diag([friction, TRUE["Fv2"]]) + TRUE["Cy"] * _TURN
    begin = np.concatenate(command.reference(np.zeros(1)))[:, 0]

    def slope(t: float, state: np.ndarray) -> np.ndarray:
        x, v = state[:2, None], state[2:, None]
        acting = command.force(np.array([t]), x, v)
        if hidden == "force constant":
            acting[0] *= 1.0 - RIPPLE * np.sin(2 * np.pi * x[0] / PITCH)
        force = acting - damping @ v - _STIFFNESS @ x - _resisting(hidden, x, v)
        return np.concatenate([v, inverses[t > LOADED] @ force])[:, 0]

    t = np.arange(round(seconds * RATE)) / RATE
    run = solve_ivp(slope, (0.0, seconds + 0.01), begin, "LSODA", dense_output=True, rtol=1e-8, atol=1e-11)
    late = np.array([DELAY if hidden == "delay" else 0.0, 0.0])
    states = [run.sol(t + own) for own in late]
    forces = [
        command.force(t + own, state[:2], state[2:])[i]
        for i, (own, state) in enumerate(zip(late, states, strict=True))
    ]
    exact = dict(zip(_NOISE, (*forces, *run.sol(t)[:2]), strict=True))
    draw = np.random.default_rng(100 + seed)
    noisy = {name: x + _NOISE[name] * draw.standard_normal(t.size) for name, x in exact.items()}
    references = dict(zip(("reference_F1", "reference_F2"), command.reference(t)[0], strict=True))
    return Log(f"by hand, {seed}", 0.0, 1 / RATE, noisy | references)
