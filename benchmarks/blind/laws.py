"""Every hidden effect: where it may sit, how its shape is drawn, which number is its size, how it enters a plant.

The names are those of `symid diagnose`; an effect outside its library has the group "foreign".
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.draws import log_uniform

from . import engine
from .axes import KINDS, Machine, with_row
from .engine import CONTROL_HZ, SUBSTEPS

Draw = Callable[[np.random.Generator], dict[str, float]]


@dataclass(frozen=True)
class Effect:
    """A hidden effect with its numbers; `size` names the one that makes it weak or strong."""

    effect: str
    at: str
    size: str
    numbers: dict[str, float]
    most: float
    foreign: bool = False

    def sized(self, value: float) -> Effect:
        return replace(self, numbers=self.numbers | {self.size: float(value)})


@dataclass(frozen=True)
class Law:
    """How one effect is drawn: its size (first guess, largest) and the shape that goes with it."""

    size: str
    guess: float
    most: float
    shape: Draw


def _turn(rng: np.random.Generator) -> float:
    return float(rng.uniform(0, 2 * np.pi))


def _none(rng: np.random.Generator) -> dict[str, float]:
    return {}


# Sizes are relative: forces to 100 N, masses to the mass of the body, and so on; see `enter`.
LAWS = {
    "viscous_friction": Law("Fv", 100.0, 1e5, _none),
    "coulomb_friction": Law("Fs", 20.0, 300, _none),
    "stribeck_friction": Law("dF", 20.0, 100, lambda r: {"vs": log_uniform(r, 0.006, 0.05)}),
    "asymmetric_friction": Law("difference", 20.0, 120, lambda r: {"side": float(r.choice([-1, 1]))}),
    "presliding_friction": Law("reach", 2e-5, 4e-4, _none),
    "load_dependent_friction": Law("mu", 0.02, 0.3, _none),
    "position_dependent_friction": Law(
        "dF", 15.0, 100, lambda r: {"pitch": log_uniform(r, 0.05, 0.4), "phase": _turn(r)}
    ),
    "friction_drift": Law("relative", 0.2, 2.0, lambda r: {"time": log_uniform(r, 1.0, 8.0)}),
    "quadratic_drag": Law("c", 100.0, 1e7, _none),
    "offset_force": Law("force", 10.0, 400, lambda r: {"side": float(r.choice([-1, 1]))}),
    "position_stiffness": Law("k", 100.0, 5000, _none),
    "cogging": Law("force", 10.0, 200, lambda r: {"pitch": log_uniform(r, 0.008, 0.06), "phase": _turn(r)}),
    "periodic_disturbance": Law(
        "force", 10.0, 200, lambda r: {"frequency": log_uniform(r, 0.6, 60), "phase": _turn(r)}
    ),
    "payload_change": Law("mass", 0.05, 0.7, lambda r: {"time": float(r.uniform(1.2, 4.8))}),
    "backlash": Law("gap", 5e-6, 4e-4, _none),
    "stiffness_nonlinearity": Law("bend", 0.05, 3.0, _none),
    "flexible_mode": Law(
        "mass",
        0.1,
        0.6,
        lambda r: {"frequency": log_uniform(r, 12, 60), "damping": log_uniform(r, 0.01, 0.05)},
    ),
    "delay": Law("time", 2e-4, 4e-3, _none),
    "actuator_lag": Law("time", 2e-4, 4e-3, _none),
    "saturation": Law("cut", 0.1, 0.5, _none),
    "gain_nonlinearity": Law("bend", 0.03, 0.35, lambda r: {"cubic": float(r.random() < 0.5)}),
    "force_constant_ripple": Law(
        "ripple", 0.02, 0.2, lambda r: {"pitch": log_uniform(r, 0.008, 0.06), "phase": _turn(r)}
    ),
    "encoder_ripple": Law(
        "amplitude", 3e-7, 3e-5, lambda r: {"pitch": log_uniform(r, 0.002, 0.03), "phase": _turn(r)}
    ),
}
FOREIGN = {
    "relay_chatter": Law(
        "force", 10.0, 150, lambda r: {"seed": float(r.integers(1 << 31)), "rate": log_uniform(r, 2, 20)}
    ),
    "random_walk_force": Law(
        "force", 10.0, 150, lambda r: {"seed": float(r.integers(1 << 31)), "rate": log_uniform(r, 0.3, 3)}
    ),
    "sticky_zone": Law(
        "force",
        20.0,
        200,
        lambda r: {"place": float(r.uniform(-0.06, 0.06)), "half": log_uniform(r, 0.01, 0.05)},
    ),
    "coupled_inertia": Law("mass", 30.0, 200, lambda r: {"side": float(r.choice([-1, 1]))}),
    "cubic_stiffness": Law("force", 1e4, 5e5, _none),
    "root_friction": Law("force", 20.0, 300, _none),
    "acceleration_squared": Law("force", 0.5, 12, lambda r: {"side": float(r.choice([-1, 1]))}),
}

_ANYWHERE = {
    "load_dependent_friction",
    "stribeck_friction",
    "presliding_friction",
    "friction_drift",
    "payload_change",
}
_ANYWHERE |= {"quadratic_drag", "periodic_disturbance", "flexible_mode"}
_SLIDING = {
    "asymmetric_friction",
    "position_dependent_friction",
    "offset_force",
    "position_stiffness",
    "cogging",
}
_RELATIVE = {
    "payload_change",
    "flexible_mode",
    "load_dependent_friction",
    "backlash",
    "stiffness_nonlinearity",
}
ACTUATOR = ("delay", "actuator_lag", "saturation", "gain_nonlinearity", "force_constant_ripple")


def places(axis: str, sensors: tuple[str, ...]) -> list[tuple[str, str]]:
    """All (effect, place) of the library that an axis can have and that its sensors can see.

    The structure moves by micrometres about one place: what depends on position along a stroke, acts constantly or
    is a linear spring there is no effect of its own, and its own weak damping hides whatever changes in it. A constant
    force on the load is one on the motor where only the motor is measured. Viscous and Coulomb friction are hidden
    where the model has none.
    """
    kind = KINDS[axis]
    found = [(effect, "actuator") for effect in ACTUATOR]
    found += [("encoder_ripple", sensor) for sensor in sensors if sensor in kind.position]
    found += [(effect, place) for place in kind.springs for effect in ("backlash", "stiffness_nonlinearity")]
    for body in kind.bodies:
        found += [
            (effect, body)
            for effect in sorted(_ANYWHERE)
            if (effect, body) != ("friction_drift", "structure")
        ]
        if body != "structure":
            found += [(effect, body) for effect in sorted(_SLIDING)]
        if body != "motor":
            found.append(("coulomb_friction", body))
    if axis == "ballscrew_2m1s" and "ql" not in sensors:
        found.remove(("offset_force", "load"))
    return found


def draw(effect: str, at: str, rng: np.random.Generator) -> Effect:
    """An effect with its first size."""
    foreign = effect in FOREIGN
    law = FOREIGN[effect] if foreign else LAWS[effect]
    numbers = {law.size: law.guess} | law.shape(rng)
    most, size = law.most * (10 if at == "structure" and effect not in _RELATIVE else 1), law.size
    if at == "structure":  # it moves by micrometres, and needs larger forces to be felt
        numbers |= {"vs": log_uniform(rng, 3e-4, 3e-3)} if effect == "stribeck_friction" else {}
        numbers |= {"c": 1e6} if effect == "quadratic_drag" else {}
        numbers |= {"frequency": log_uniform(rng, 8, 80)} if effect == "periodic_disturbance" else {}
    if effect == "presliding_friction" and at != "motor":  # the model has no Coulomb friction there
        reach = (2e-7, 2e-6) if at == "structure" else (1e-6, 3e-5)
        numbers, size, most = {"level": 40.0, "reach": log_uniform(rng, *reach)}, "level", 1000.0
    return Effect(effect, at, size, numbers, most, foreign)


def enter(plant: Machine, effect: Effect, axis: str, travel: dict[str, float]) -> Machine:
    """The plant with the effect; `travel` holds the peaks of drive force and spring deflection without it."""
    n, at = effect.numbers, effect.at
    if effect.effect == "force_constant_ripple":
        motor = KINDS[axis].bodies.index("motor")
        return with_row(plant, engine.FORCE_CONSTANT, motor, n["ripple"], n["pitch"], n["phase"])
    if at == "actuator":
        return replace(plant, actuator=_actuator(plant.actuator.copy(), effect, travel["force"]))
    if effect.effect == "encoder_ripple":
        ripple = np.array([n["amplitude"], n["pitch"], n["phase"]])
        return replace(plant, ripple=ripple) if KINDS[axis].position[at] == "motor" else plant
    if effect.effect in ("backlash", "stiffness_nonlinearity"):
        springs = plant.springs.copy()
        springs[0, 5] = n.get("gap", 0.0) / 2
        springs[0, 4] = n.get("bend", 0.0) * springs[0, 2] / travel["deflection"] ** 2
        return replace(plant, springs=springs)
    body = KINDS[axis].bodies.index(at)
    if effect.effect == "payload_change":
        return replace(plant, payload=np.array([body, n["mass"] * plant.mass[body], n["time"]]))
    if effect.effect == "flexible_mode":
        return _with_mode(plant, body, n)
    if effect.effect in ("relay_chatter", "random_walk_force"):
        plant = replace(plant, outside=_outside(effect))
    return _along_joint(plant, effect, body)


def _actuator(values: np.ndarray, effect: Effect, peak: float) -> np.ndarray:
    size = effect.numbers[effect.size]
    if effect.effect == "delay":
        values[0] = round(size * CONTROL_HZ * SUBSTEPS)
    elif effect.effect == "actuator_lag":
        values[1] = size
    elif effect.effect == "saturation":
        values[2] = peak * (1 - size)
    elif effect.numbers["cubic"]:
        values[4] = size / peak**2
    else:
        values[3] = size / peak
    return values


def _with_mode(plant: Machine, body: int, n: dict[str, float]) -> Machine:
    mass, w = n["mass"] * plant.mass[body], 2 * np.pi * n["frequency"]
    spring = [[plant.mass.size, body, mass * w**2, 2 * n["damping"] * mass * w, 0, 0]]
    return replace(plant, mass=np.append(plant.mass, mass), springs=np.vstack([plant.springs, spring]))


def _outside(effect: Effect) -> np.ndarray:
    """A random force of unit size at 4 kHz: signs that flip, or a walk that is drawn back slowly."""
    rng, n = np.random.default_rng(int(effect.numbers["seed"])), 10 * CONTROL_HZ // 4 + 1
    rate = effect.numbers["rate"]
    if effect.effect == "relay_chatter":
        return np.where(np.cumsum(rng.random(n) < rate / 4000) % 2, 1.0, -1.0)
    walk, back = np.zeros(n), np.exp(-2 * np.pi * rate / 4000)
    for k, push in enumerate(rng.standard_normal(n - 1) * np.sqrt(1 - back**2)):
        walk[k + 1] = back * walk[k] + push
    return walk


def _along_joint(plant: Machine, effect: Effect, joint: int) -> Machine:
    n, size, name = effect.numbers, effect.numbers[effect.size], effect.effect
    side, level = n.get("side", 1.0), plant.coulomb[joint]
    wave, mean = (min(size, 0.95 * level), 0.0) if level else (size, size)
    entries: dict[str, tuple[float, ...]] = {
        "viscous_friction": (engine.VISCOUS, size),
        "coulomb_friction": (engine.COULOMB, size, size),
        "stribeck_friction": (engine.STRIBECK, size, n.get("vs", 0)),
        "asymmetric_friction": (engine.COULOMB, max(size * side, 0), max(-size * side, 0)),
        "load_dependent_friction": (engine.LOAD_DEPENDENT, size),
        "position_dependent_friction": (
            engine.POSITION_DEPENDENT,
            wave,
            n.get("pitch", 0),
            n.get("phase", 0),
            mean,
        ),
        "friction_drift": (engine.DRIFT, size, n.get("time", 0)),
        "quadratic_drag": (engine.DRAG, size),
        "offset_force": (engine.OFFSET, size * side),
        "position_stiffness": (engine.STIFFNESS, size),
        "cogging": (engine.COGGING, size, n.get("pitch", 0), n.get("phase", 0)),
        "periodic_disturbance": (engine.PERIODIC, size, n.get("frequency", 0), n.get("phase", 0)),
        "relay_chatter": (engine.OUTSIDE, size),
        "random_walk_force": (engine.OUTSIDE, size),
        "sticky_zone": (engine.STICKY_ZONE, size, n.get("place", 0), n.get("half", 0)),
        "coupled_inertia": (engine.COUPLED, size * side),
        "cubic_stiffness": (engine.CUBIC, size),
        "root_friction": (engine.ROOT, size),
        "acceleration_squared": (engine.ACCELERATION, size * side),
    }
    if name != "presliding_friction":
        law, *numbers = entries[name]
        return with_row(plant, int(law), joint, *numbers)
    coulomb = plant.coulomb.copy()
    coulomb[joint] = 0
    return with_row(replace(plant, coulomb=coulomb), engine.PRESLIDING, joint, level or size, n["reach"])
