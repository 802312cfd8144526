"""Cases of `benchmarks.diagnosis.others`: machines drawn at random, their logs, and models that lack a law."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.diagnosis.other_machines import Loop, Recorder, run
from benchmarks.draws import log_uniform
from symid import Axis, Between, Body, CoulombFriction, Drive, Log, Position, Spring, ViscousFriction
from symid.arrays import FloatArray
from symid.axis import (
    ActuatorDelay,
    Cogging,
    LoadDependentFriction,
    OffsetForce,
    PositionStiffness,
    Unbalance,
)

KINDS = {
    "servo": (("Gs", "Fs", "Fv"), ("warm", "dF", "dFs", "ripple"), (50, 100, 200, 500)),
    "belt": (("Fs", "Fv", "late"), ("dFs", "ripple", "dF"), (500, 1000, 2000)),
    "screw": (("F0", "Fs", "Fv", "As"), ("dF", "dFv", "warm"), (500, 1000, 4000, 8000)),
    "robot joint": (("Gs", "Fs", "Fv", "mu"), ("dFs", "pose", "ripple"), (100, 250, 1000)),
    "leg": (("F0", "k", "Fs", "Fv"), ("dF", "c", "dFs", "ripple"), (250, 1000, 2000)),
    "pendulum": (("Gs", "Fs", "Fv"), ("dFs", "c", "dF"), (50, 100, 200, 500)),
}
"""Of each kind: laws that it has and a model may lack, small effects of which it has three, rates of its logs in Hz."""
EFFECTS = {
    "Fs": "coulomb_friction",
    "Fv": "viscous_friction",
    "F0": "offset_force",
    "Gs": "weight",
    "k": "position_stiffness",
    "As": "cogging",
    "mu": "load_dependent_friction",
    "late": "sensor_delay",
    "delay": "delay",
    "warm": "friction_drift",
    "dF": "stribeck_friction",
    "dFs": "asymmetric_friction",
    "dFv": "asymmetric_friction",
    "ripple": "cogging",
    "c": "quadratic_drag",
    "pose": "payload_change",
}
"""Effects that stand for what a machine has; an inertia that depends on the pose is a mass that changes."""
_TURNS = ("servo", "robot joint", "pendulum")
_MOST_SAMPLES = 100_000
_SHORT = 10.0
_SLOW = 250.0
_SLOWEST_LOOP = 1000.0


@dataclass(frozen=True)
class Case:
    """Logs of a machine, the complete axis, and a model without one of its laws."""

    # kind, lacks: the machine, and what its model lacks; "none" if nothing
    kind: str
    lacks: str
    there: tuple[str, ...]  # effects that the machine has beside those of the model
    value: float  # of what the model lacks
    logs: tuple[Log, ...]  # one for identification, and perhaps one for validation
    # complete, model: with all laws but the small effects, and without one
    complete: Axis
    model: Axis
    nominal: Mapping[str, float]  # values of the complete axis that are given

    @property
    def effect(self) -> str:
        """The effect that stands for what the model lacks."""
        return EFFECTS.get(self.lacks, "none")


@dataclass(frozen=True)
class _Size:
    """Stroke, speed and force of a machine's moves."""

    stroke: float
    speed: float
    force: float


def drawn(seed: int, *, short: bool = False) -> Case:
    """A case; `short` ones have at most 10 s at 250 Hz."""
    rng = np.random.default_rng(seed)
    kind = str(rng.choice(list(KINDS)))
    has, small, rates = KINDS[kind]
    rates = tuple(r for r in rates if not short or r <= _SLOW) or rates[:1]
    rate, duration = float(rng.choice(rates)), log_uniform(rng, 5, _SHORT if short else 60)
    duration = min(duration, _MOST_SAMPLES / rate)
    values, size = _machine(kind, rng)
    added = tuple(map(str, rng.permutation(small)[:3]))
    values |= _small(added, values, size, duration, turns=kind in _TURNS, rng=rng)
    controlled = rate * max(1, int(np.ceil(_SLOWEST_LOOP / rate)))
    late = float(rng.uniform(1e-3, 4e-3)) if "late" in has else 0.0
    delay = float(rng.uniform(0.5, 3) / controlled) if rng.random() < 0.5 else 0.0
    lacks = str(rng.choice([*has, *(["delay"] if delay and rate >= _SLOW else []), "none", "none"]))
    loop = _loop(controlled, values, size, delay, turns=kind in _TURNS, rng=rng)
    paths = (_reference(rng, size, duration, controlled) for _ in range(1 + int(rng.random() < 0.5)))
    recorder = Recorder(round(controlled / rate), late)
    channels = ("q", "ql", "F") if kind == "belt" else ("q", "F")
    logs = []
    for i, path in enumerate(paths):
        signals = run(values, loop, path, recorder, seed + i).signals
        logs.append(Log.from_arrays({n: signals[n] for n in channels}, sampling_period=1 / rate))
    complete = _declared(kind, values, late, delay)
    known = {name: values[name] for name in complete.physical_parameters}
    nominal = {name: x * float(rng.uniform(0.9, 1.1)) for name, x in known.items()}
    # while an axis moves, dry friction that differs by direction is a constant force
    constant = ["F0"] if "dFs" in added else []
    there = {
        EFFECTS[name] for name in (*added, *constant, lacks, *(["delay"] if delay else [])) if name != "none"
    }
    value = {"late": late, "delay": delay, "none": 0.0}.get(lacks, values.get(lacks, 0.0))
    return Case(kind, lacks, tuple(there), value, tuple(logs), complete, _without(complete, lacks), nominal)


def _machine(kind: str, rng: np.random.Generator) -> tuple[dict[str, float], _Size]:
    has, turns = KINDS[kind][0], kind in _TURNS
    inertia = log_uniform(rng, 1e-3, 1.0) if turns else log_uniform(rng, 1, 100)
    stroke = float(rng.uniform(0.5, 1.5)) if turns else log_uniform(rng, 0.05, 0.5)
    acceleration = log_uniform(rng, 10, 60) if turns else log_uniform(rng, 1, 10)
    speed = float(np.sqrt(acceleration * stroke) * rng.uniform(0.3, 0.8))
    load = inertia * float(rng.uniform(0.3, 2)) if kind == "belt" else 0.0
    force = (inertia + load) * acceleration
    values = {
        "J": inertia,
        "Fs": force * log_uniform(rng, 0.1, 0.6),
        "Fv": force * log_uniform(rng, 0.1, 0.5) / speed,
    }
    drawn_values = {
        "Gs": force * log_uniform(rng, 0.2, 1.5),
        "Gc": force * float(rng.uniform(-0.3, 0.3)),
        "F0": force * float(rng.uniform(0.2, 1.0)),
        "k": force * float(rng.uniform(0.2, 0.8)) / stroke,
        "mu": float(rng.uniform(0.05, 0.3)),
        "As": force * float(rng.uniform(0.1, 0.3)),
    }
    values |= {name: drawn_values[name] for name in has if name in drawn_values}
    if "Gs" in has:
        values["Gc"] = drawn_values["Gc"]
    if "As" in has:
        values |= {"Ac": 0.0, "pitch": stroke / float(rng.uniform(2, 9))}
    if load:
        mode = 2 * np.pi * float(rng.uniform(15, 45))
        stiffness = mode**2 * inertia * load / (inertia + load)
        values |= {"Jl": load, "K": stiffness, "C": 0.03 * stiffness / mode, "Fvl": 0.1 * force / speed}
    return values, _Size(stroke, speed, force)


def _small(
    added: tuple[str, ...],
    values: Mapping[str, float],
    size: _Size,
    duration: float,
    *,
    turns: bool,
    rng: np.random.Generator,
) -> dict[str, float]:
    """Effects of 2 to 6 % of the force."""
    share = {name: size.force * float(rng.uniform(0.02, 0.06)) for name in added}
    pitch = 2 * np.pi / float(rng.choice([7, 12, 24])) if turns else 0.02
    forms = {
        "warm": lambda f: {"warm": 5 * f / size.force, "tau": duration / 2},
        "dF": lambda f: {"dF": f, "vs": 0.05 * size.speed},
        "dFs": lambda f: {"dFs": min(f, 0.3 * values["Fs"])},
        "dFv": lambda f: {"dFv": min(f / size.speed, 0.3 * values["Fv"])},
        "c": lambda f: {"c": f / size.speed**2},
        "pose": lambda f: {"pose": f / size.force},
        "ripple": lambda f: {"As": f, "pitch": pitch},
    }
    found: dict[str, float] = {}
    for name, force in share.items():
        found |= forms[name](force)
    return found


def _loop(
    rate: float,
    values: Mapping[str, float],
    size: _Size,
    delay: float,
    *,
    turns: bool,
    rng: np.random.Generator,
) -> Loop:
    inertia, bandwidth = values["J"] + values.get("Jl", 0.0), 2 * np.pi * float(rng.uniform(3, 8))
    noise = size.force * log_uniform(rng, 0.003, 0.02)
    return Loop(
        rate,
        inertia * bandwidth**2,
        1.6 * inertia * bandwidth,
        2 * np.pi / 2 ** int(rng.choice([12, 14, 17, 20]))
        if turns
        else float(rng.choice([1e-7, 1e-6, 5e-6])),
        force_step=float(rng.choice([0.0, 0.01])) * size.force,
        noise=noise,
        wander=noise * float(rng.uniform(0, 1)),
        delay=delay,
        limit=20 * size.force,
    )


def _reference(rng: np.random.Generator, size: _Size, duration: float, rate: float) -> FloatArray:
    """Moves between random places, or a sum of sines, of about the highest speed."""
    time = np.arange(int(duration * rate)) / rate
    if rng.random() < 0.5:
        waves = np.zeros(time.size)
        for f in np.exp(rng.uniform(np.log(1 / duration), np.log(3.0), 5)):
            waves += np.sin(2 * np.pi * f * time + rng.uniform(0, 2 * np.pi)) / f
        waves *= np.minimum(time, 1.0)
        fastest = np.abs(np.gradient(waves, 1 / rate)).max()
        return waves * min(size.stroke / np.abs(waves).max(), size.speed / fastest)
    course, at, begin = np.zeros(time.size), 0.0, 0.0
    while begin < duration:
        to = float(rng.uniform(-size.stroke, size.stroke))
        length = max(1.9 * abs(to - at) / (size.speed * rng.uniform(0.2, 1)), 0.15)
        x = np.clip((time - begin) / length, 0, 1)
        course += (to - at) * x**3 * (10 - 15 * x + 6 * x**2)
        at, begin = to, begin + length + float(rng.choice([0.0, 0.1, 0.3]))
    return course


def _declared(kind: str, values: Mapping[str, float], late: float, delay: float) -> Axis:
    """The axis with all that its kind has."""
    has = KINDS[kind][0]
    body = Body("driven", inertia="J") if kind in _TURNS else Body("driven", mass="J")
    laws = {
        "Gs": lambda: Unbalance(body, "Gs", "Gc"),
        "F0": lambda: OffsetForce(body, "F0"),
        "k": lambda: PositionStiffness(body, "k"),
        "As": lambda: Cogging(body, "As", "Ac", pitch=values["pitch"]),
        "mu": lambda: LoadDependentFriction(body, values["mu"]),
    }
    elements = [body, ViscousFriction(body, "Fv"), CoulombFriction(body, "Fs")]
    elements += [laws[name]() for name in has if name in laws]
    elements += [ActuatorDelay(delay)] * bool(delay)
    sensors = [Position("q", body)]
    if kind == "belt":
        load = Body("load", mass="Jl")
        belt = Spring("belt", Between(first=body, second=load), stiffness="K", damping="C")
        elements += [load, belt, ViscousFriction(load, "Fvl")]
        sensors.append(Position("ql", load, delay=late))
    return Axis("other", tuple(elements), Drive("F", body), tuple(sensors))


def _without(axis: Axis, lacks: str) -> Axis:
    """The axis without a law of its driven body, a delay, or the lateness of a sensor."""
    if lacks == "late":
        return replace(axis, sensors=tuple(replace(s, delay=0.0) for s in axis.sensors))
    kinds = {
        "Fs": CoulombFriction,
        "Fv": ViscousFriction,
        "F0": OffsetForce,
        "Gs": Unbalance,
        "k": PositionStiffness,
        "As": Cogging,
        "mu": LoadDependentFriction,
        "delay": ActuatorDelay,
    }
    body, every = axis.bodies[0], (*axis.laws, *axis.imperfections)
    wanted = (e for e in every if lacks in kinds and isinstance(e, kinds[lacks]))
    return axis.without(*(e for e in wanted if getattr(e, "at", body) == body))
