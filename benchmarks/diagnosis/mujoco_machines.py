"""Machines that MuJoCo simulates, diagnosed by models that lack one law: python -m benchmarks.diagnosis.mujoco_machines

One body (a slide or a pendulum with its motor), or a motor and a load on a spring, under a position controller of 1 kHz
whose force is held; point-to-point moves; encoders with resolution or noise, and a noisy force. Nothing of symid takes
part in the simulation. Nominal values are up to 10 % off. MuJoCo's dry friction is a soft constraint: it creeps up to
a speed that its time constant sets, here as stiff as the step allows.

An answer is right if the law is named first, or as a stated tie, at its place; of a load that the motor alone reads,
friction and drag may be at either body. A further effect that the machine does not have, named with at least a half, is
false. Delays below a sample do not count: MuJoCo's integrator acts half a step early. Its implicit integrators are not
used: they lose momentum where a tendon damps two bodies.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from benchmarks.options import parser_of
from symid import (
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    Log,
    Position,
    Spring,
    SymidError,
    ViscousFriction,
)
from symid.diagnosis import Diagnosis, diagnose

STEP, TICKS, SECONDS = 1e-4, 10, 8.0
"""Step of the simulation in s, steps of a sample of the controller, and length of a log in s."""
_ANYWHERE = ("coulomb_friction", "viscous_friction", "quadratic_drag", "offset_force", "asymmetric_friction")
"""Laws of the load that the motor's encoder alone does not tell from those of the motor."""
_LIKELY = 0.5
_STIFF = 'solreffriction="0.0004 1" solimpfriction="0.999 0.9999 0.001"'


@dataclass(frozen=True)
class Machine:
    """A motor that slides or turns, with or without a load on a spring; SI."""

    mass: float
    viscous: float
    coulomb: float
    turns: bool = False
    weight: float = 0.0  # mass times length of a pendulum, kg m
    load: float = 0.0
    load_viscous: float = 0.0
    load_coulomb: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0
    play: float = 0.0
    late: int = 0  # steps by which the force acts late
    law: Callable[[float, float], float] | None = None  # further force on the motor, of position and velocity
    load_law: Callable[[float, float], float] | None = None

    @property
    def xml(self) -> str:
        kind = "hinge" if self.turns else "slide"
        arm = self.weight / 0.5 if self.weight else 0.0  # half a kilogram at this distance
        own = self.mass - 0.5 * arm**2 if self.turns else self.mass
        ball = '<geom type="sphere" size="0.001" mass="{}" pos="0 0 {}" contype="0" conaffinity="0"/>'
        inertia = f'armature="{own}"' if self.turns else ""
        joint = '<joint name="{}" type="{}" axis="1 0 0" damping="{}" frictionloss="{}" {} {}/>'
        bodies = "<body>" + joint.format("motor", kind, self.viscous, self.coulomb, inertia, _STIFF)
        bodies += ball.format(0.5 if self.weight else 1e-6 if self.turns else own, -arm) + "</body>"
        spring = ""
        if self.load:
            bodies += "<body>" + joint.format("load", kind, self.load_viscous, self.load_coulomb, "", _STIFF)
            bodies += ball.format(self.load, 0.0) + "</body>"
            spring = (
                f'<tendon><fixed stiffness="{self.stiffness}" damping="{self.damping}" '
                f'springlength="{-self.play / 2} {self.play / 2}"><joint joint="load" coef="1"/>'
                '<joint joint="motor" coef="-1"/></fixed></tendon>'
            )
        return (
            f'<mujoco><option timestep="{STEP}" integrator="Euler" gravity="0 0 -9.81"/>'
            f'<worldbody>{bodies}</worldbody>{spring}<actuator><motor joint="motor"/></actuator></mujoco>'
        )

    def run(self, path: np.ndarray, bandwidth: float, shaking: np.ndarray) -> dict[str, np.ndarray]:
        """Force, position of the motor and of the load at the controller's samples, along a path."""
        model = mujoco.MjModel.from_xml_string(self.xml)
        data = mujoco.MjData(model)
        whole, w = self.mass + self.load, 2 * np.pi * bandwidth
        stiff, damped, slow = whole * w**2, 1.4 * whole * w, whole * w**3 / 8
        speed = np.gradient(path) / (STEP * TICKS)
        waiting, summed = [0.0] * self.late, 0.0
        found = np.zeros((3, path.size))
        for k in range(path.size):
            error = path[k] - data.qpos[0]
            summed += slow * error * STEP * TICKS
            force = stiff * error + damped * (speed[k] - data.qvel[0]) + summed + shaking[k]
            found[:, k] = force, data.qpos[0], data.qpos[-1]
            for _ in range(TICKS):
                waiting.append(force)
                acting = waiting.pop(0)
                data.ctrl[0] = acting + (self.law(data.qpos[0], data.qvel[0]) if self.law else 0.0)
                if self.load_law:
                    data.qfrc_applied[1] = self.load_law(data.qpos[1], data.qvel[1])
                mujoco.mj_step(model, data)
        return dict(zip(("F", "q", "ql"), found, strict=True))


@dataclass(frozen=True)
class Case:
    """A log, the model that lacks something, its nominal values, and what is missing."""

    axis: Axis
    log: Log
    nominal: dict[str, float]
    missing: tuple[tuple[str, str], ...]  # effect and places at which it may be named; empty if nothing is


def moves(rng: np.random.Generator, travel: float) -> np.ndarray:
    """Moves between random places, each a polynomial of least jerk, with rests."""
    rate = 1 / (STEP * TICKS)
    path, place = [np.zeros(int(0.2 * rate))], 0.0
    while sum(map(len, path)) < SECONDS * rate:
        goal, s = travel * rng.uniform(-1, 1), np.linspace(0, 1, int(rng.uniform(0.2, 0.7) * rate))
        path.append(place + (goal - place) * (10 * s**3 - 15 * s**4 + 6 * s**5))
        path.append(np.full(int(rng.uniform(0, 0.2) * rate), goal))
        place = goal
    return np.concatenate(path)[: int(SECONDS * rate)]


def with_law(machine: Machine, kind: str, force: float) -> tuple[Machine, tuple[tuple[str, str], ...]]:
    """A machine with what a model lacks, of a force, and the names under which it is right."""
    motor, load = "motor", "load" if machine.load else "motor"
    speed = 5.0 if machine.turns else 1.0
    pitch = 0.6 if machine.turns else 0.03
    match kind:
        case "cogging":
            waves = 2 * np.pi / pitch
            return replace(machine, law=lambda q, v: force * np.sin(waves * q)), ((kind, motor),)
        case "quadratic_drag":
            return replace(machine, law=lambda q, v: -force * v * abs(v) / speed**2), ((kind, motor),)
        case "offset_force":
            return replace(machine, law=lambda q, v: -force), ((kind, motor),)
        case "asymmetric_friction":
            return replace(machine, law=lambda q, v: -force * np.tanh(max(v, 0.0) / 1e-3)), ((kind, motor),)
        case "delay":
            return replace(machine, late=int(25 * force / machine.coulomb) + 15), ((kind, "actuator"),)
        case "load_drag":
            return replace(machine, load_law=lambda q, v: -force * v * abs(v)), (("quadratic_drag", load),)
        case "load_friction":
            return replace(machine, load_coulomb=force), (("coulomb_friction", load),)
        case "backlash":
            return replace(machine, play=6 * force / machine.stiffness), (("backlash", "screw"),)
        case "coulomb_friction" | "viscous_friction":
            return machine, ((kind, motor),)
        case "weight":
            return replace(machine, weight=0.4), ((kind, motor),)
        case "flexible_mode" | "spring_damping":
            return machine, ((kind, "screw" if kind == "spring_damping" else motor),)
    return machine, ()


RIGID = (
    "none", "cogging", "quadratic_drag", "offset_force", "asymmetric_friction", "delay", "coulomb_friction",
    "viscous_friction", "weight", "flexible_mode",
)  # fmt: skip
ELASTIC = (
    "none", "cogging", "load_drag", "load_friction", "backlash", "offset_force", "spring_damping", "delay",
)  # fmt: skip


def drawn(rng: np.random.Generator, kind: str, *, elastic: bool) -> Case:
    """A random machine that has what its model lacks."""
    turns = not elastic and (kind == "weight" or (kind != "flexible_mode" and rng.random() < 0.5))
    mass = rng.uniform(0.04, 0.1) if turns else rng.uniform(3, 30)
    load = mass * rng.uniform(0.4, 1.5) if elastic or kind == "flexible_mode" else 0.0
    force = (mass + load) * (100.0 if turns else 20.0)
    stiffness = load * (2 * np.pi * rng.uniform(14, 40)) ** 2
    machine = Machine(
        mass=mass,
        viscous=rng.uniform(0.5, 2) * mass * (4 if kind == "viscous_friction" else 1),
        coulomb=rng.uniform(0.03, 0.1) * force,
        turns=turns,
        load=load,
        load_viscous=rng.uniform(0.5, 2) * load if elastic else 0.0,
        stiffness=stiffness,
        damping=2 * 0.015 * np.sqrt(stiffness * load),
    )
    hidden, missing = with_law(machine, kind, 0.05 * force)
    travel = 1.5 if turns else 0.3
    path = moves(rng, travel)
    shaking = 0.01 * force * rng.standard_normal(path.size) * (rng.random() < 0.5)
    signals = hidden.run(path, rng.uniform(7, 12) if load else rng.uniform(9, 18), shaking)
    if not np.abs(signals["q"]).max() < 2 * travel:  # the controller does not hold this machine
        return drawn(rng, kind, elastic=elastic)
    two = elastic and (kind in ("backlash", "spring_damping") or rng.random() < 0.5)
    fine = 2 * np.pi / 2**16 if turns else 1e-6
    log = {"F": signals["F"] + 0.002 * force * rng.standard_normal(path.size)}
    for name in ("q", "ql")[: 1 + two]:
        read = signals[name] + fine / 2 * rng.standard_normal(path.size)
        log[name] = np.round(read / fine) * fine if rng.random() < 0.5 else read
    if missing and missing[0][1] == "load" and not two and missing[0][0] in _ANYWHERE:
        missing = (*missing, (missing[0][0], "motor"))
    elif missing and elastic and not two and missing[0][0] in _ANYWHERE:
        missing = (*missing, (missing[0][0], "load"))
    axis = model_of(machine, kind, elastic=elastic, two=two)
    true = {
        "M": mass, "Fv": machine.viscous, "Fs": machine.coulomb, "Ml": load, "Fvl": machine.load_viscous,
        "K": stiffness, "C": machine.damping,
    }  # fmt: skip
    nominal = {name: true[name] * rng.uniform(0.9, 1.1) for name in axis.physical_parameters}
    recorded = Log.from_arrays(log, sampling_period=STEP * TICKS, source=f"{kind} by MuJoCo")
    return Case(axis, recorded, nominal, missing)


def model_of(machine: Machine, kind: str, *, elastic: bool, two: bool) -> Axis:
    """The model of a machine, without what is hidden."""
    motor = Body("motor", inertia="M") if machine.turns else Body("motor", mass="M")
    elements: list[Any] = [motor]
    elements += [ViscousFriction(motor, "Fv")] * (kind != "viscous_friction")
    elements += [CoulombFriction(motor, "Fs")] * (kind != "coulomb_friction")
    sensors = [Position("q", motor)]
    if elastic:
        load = Body("load", mass="Ml")
        damping = None if kind == "spring_damping" else "C"
        spring = Spring("screw", Between(first=motor, second=load), stiffness="K", damping=damping)
        elements += [load, spring, ViscousFriction(load, "Fvl")]
        sensors += [Position("ql", load)] * two
    return Axis("machine", tuple(elements), Drive("F", motor), tuple(sensors))


def is_right(case: Case, found: Diagnosis) -> bool:
    """Whether what is missing is named first or as a tie, or nothing is where nothing is missing."""
    if not case.missing:
        return not false_effects(case, found)
    if not found.effects:
        return False
    first = found.effects[0]
    return any(key in case.missing for key in ((first.effect, first.at), *first.indistinguishable_from))


def false_effects(case: Case, found: Diagnosis) -> list[str]:
    """Effects that the machine does not have, named with at least a half; not delays below a sample."""
    names = {effect for effect, _ in case.missing}
    return [
        f"{own.effect} at {own.at}"
        for own in found.effects
        if own.effect not in names and own.probability >= _LIKELY and not _is_of_integrator(own)
    ]


def _is_of_integrator(own: Any) -> bool:
    late = own.parameters.get("T")
    return own.effect in ("delay", "actuator_lag") and late is not None and abs(late.value) < STEP * TICKS


def main() -> None:
    options = parser_of(__doc__, seed=4000, cases=20).parse_args()
    right, false, spent = [], 0, []
    for number in range(options.cases):
        rng = np.random.default_rng([options.seed, number])
        elastic = bool(number % 2)
        kind = str(rng.choice(ELASTIC if elastic else RIGID))
        case = drawn(rng, kind, elastic=elastic)
        begun = time.process_time()
        try:
            found = diagnose(case.axis, case.log, nominal=case.nominal)
        except SymidError as error:
            print(f"{number:3d} {kind}: {error}", flush=True)
            right.append(False)
            continue
        spent.append(time.process_time() - begun)
        wrong = false_effects(case, found)
        right.append(is_right(case, found))
        false += len(wrong)
        named = ", ".join(f"{e.effect} at {e.at} {e.probability:.2f}" for e in found.effects) or found.verdict
        sensors = "+".join(case.log.signals)
        mark = "" if right[-1] else "  <- not right"
        print(f"{number:3d} {kind:20s} {sensors:8s} {spent[-1]:5.1f} s  {named}{mark}", flush=True)
    print(f"right {sum(right)} of {len(right)}, false effects {false}, median {np.median(spent):.1f} s")


if __name__ == "__main__":
    main()
