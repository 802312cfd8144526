"""The three axes: their bodies and joints, parameters drawn as in real machines, controllers that suit them."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from benchmarks.draws import log_uniform

from .engine import ROW

GROUND = -1


@dataclass(frozen=True)
class Kind:
    """One axis of the catalogue: joints of bodies in order, where the drive acts, what may be measured."""

    name: str
    bodies: tuple[str, ...]
    joints: tuple[tuple[int, int], ...]  # of each body: the body itself, and what it slides on
    drive: str
    springs: tuple[str, ...]  # places that have a spring
    sensors: tuple[tuple[str, ...], ...]
    position: dict[str, str]  # position sensors and the joints that they read


KINDS = {
    "rigid_1m": Kind("rigid_1m", ("motor",), ((0, GROUND),), "F", (), (("q",),), {"q": "motor"}),
    "direct_2m1s": Kind(
        "direct_2m1s",
        ("structure", "motor"),
        ((0, GROUND), (1, 0)),
        "Fm",
        ("structure",),
        (("q2",), ("q2", "ddq1")),
        {"q2": "motor"},
    ),
    "ballscrew_2m1s": Kind(
        "ballscrew_2m1s",
        ("motor", "load"),
        ((0, GROUND), (1, GROUND)),
        "Fm",
        ("transmission",),
        (("qm",), ("qm", "ql")),
        {"qm": "motor", "ql": "load"},
    ),
}


@dataclass(frozen=True)
class Machine:
    """Arrays of a plant in the order in which `engine.loop` takes them."""

    mass: np.ndarray
    plus: np.ndarray
    minus: np.ndarray
    viscous: np.ndarray
    coulomb: np.ndarray
    springs: np.ndarray
    rows: np.ndarray
    outside: np.ndarray
    payload: np.ndarray
    drive: np.ndarray
    actuator: np.ndarray
    ripple: np.ndarray

    def arguments(self) -> tuple[np.ndarray, ...]:
        """In the order of `engine.loop`."""
        return tuple(getattr(self, name) for name in self.__dataclass_fields__)


def draw_parameters(axis: str, rng: np.random.Generator) -> dict[str, float]:
    """True values in SI units; springs by the frequency and damping ratio that they give."""
    between = partial(log_uniform, rng)
    if axis == "rigid_1m":
        return {"M": between(50, 280), "Fv": between(80, 300), "Fs": between(20, 120)}
    if axis == "direct_2m1s":
        Ms, w, damping = between(1500, 4000), 2 * np.pi * between(35, 60), between(0.015, 0.035)
        Ks = Ms * w**2
        motor = {"Mm": between(220, 500), "Fvm": between(60, 400), "Fsm": between(60, 200)}
        return {"Ms": Ms, "Fvs": 2 * damping * Ms * w, "Ks": Ks} | motor
    Ml, w, damping = between(120, 300), 2 * np.pi * between(18, 45), between(0.008, 0.02)
    motor = {"Mm": between(60, 180), "Fvm": between(60, 200), "Fsm": between(30, 110)}
    return motor | {"Kt": Ml * w**2, "Ft": 2 * damping * Ml * w, "Ml": Ml, "Fvl": between(50, 200)}


def draw_nominal(
    true: dict[str, float], error: tuple[float, float], rng: np.random.Generator
) -> dict[str, float]:
    """Values wrong by a relative error between the two given ones, up or down; exact for (0, 0)."""
    sign = rng.choice([-1.0, 1.0], len(true))
    return {
        name: value * (1 + s * rng.uniform(*error))
        for (name, value), s in zip(true.items(), sign, strict=True)
    }


def draw_controller(axis: str, true: dict[str, float], rng: np.random.Generator) -> dict[str, float]:
    """Velocity loop of 18 to 25 Hz, position loop six times slower, both set with some freedom."""
    moved = {"rigid_1m": ("M",), "direct_2m1s": ("Mm",), "ballscrew_2m1s": ("Mm", "Ml")}[axis]
    mass, w = sum(true[name] for name in moved), 2 * np.pi * (25 if axis == "rigid_1m" else 18)
    Kpp, Kpv = w / 6 * rng.uniform(0.9, 1.1), w * mass * rng.uniform(0.85, 1.15)
    return {"Kpp": float(Kpp), "Kpv": float(Kpv), "Kiv": float(Kpv * w / 6 * rng.uniform(0.8, 1.2))}


def machine(axis: str, true: dict[str, float]) -> Machine:
    """The axis without any effect."""
    kind = KINDS[axis]
    springs = np.zeros((0, 6))
    if axis == "rigid_1m":
        mass, viscous, coulomb = [true["M"]], [true["Fv"]], [true["Fs"]]
    elif axis == "direct_2m1s":
        mass, viscous, coulomb = [true["Ms"], true["Mm"]], [true["Fvs"], true["Fvm"]], [0.0, true["Fsm"]]
        springs = np.array([[0, GROUND, true["Ks"], 0.0, 0, 0]])
    else:
        mass, viscous, coulomb = [true["Mm"], true["Ml"]], [true["Fvm"], true["Fvl"]], [true["Fsm"], 0.0]
        springs = np.array([[1, 0, true["Kt"], true["Ft"], 0, 0]])
    joints = np.array(kind.joints)
    return Machine(
        np.array(mass, float),
        joints[:, 0].copy(),
        joints[:, 1].copy(),
        np.array(viscous, float),
        np.array(coulomb, float),
        springs,
        np.zeros((0, ROW)),
        np.zeros(2),
        np.array([-1.0, 0, 0]),
        joints[kind.bodies.index("motor")],
        np.array([0.0, 0, np.inf, 0, 0]),
        np.array([0.0, 1, 0]),
    )


def with_row(plant: Machine, law: int, joint: int, *numbers: float) -> Machine:
    """One more law along a joint."""
    row = np.zeros((1, ROW))
    row[0, : 2 + len(numbers)] = (law, joint, *numbers)
    return replace(plant, rows=np.vstack([plant.rows, row]))
