"""Machines drawn at random, and logs of them under their controllers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfilt

from benchmarks.diagnosis.drawn_effects import Scale, drawn_effect
from benchmarks.draws import log_uniform
from symid import Axis, Body, CoulombFriction, Drive, Log, Position, Spring, SymidError, ViscousFriction
from symid.axis import Between, Geared, PendulumWeight
from symid.axis.axis import Element
from symid.axis.imperfections import Imperfection
from symid.simulation import Trajectory, plant_of, simulate, trapezoids, tuned_cascade
from symid.simulation.trajectories.excitation import chirp

RATES = (500.0, 1000.0, 2000.0, 4000.0)
_SCALES = (1e-8, 1e-7, 1e-6)
"""Resolutions of a linear scale, m."""
_WOUND_UP = 15.0
"""Force, in multiples of that of the acceleration, of a controller that suits no machine."""
_VALIDATION = 0.7
"""Size of the validation run."""
_RELATIVE = (0.12, 0.25)
"""Size of small effects, relative to a share of the force."""
Added = tuple[Element | Imperfection, dict[str, float]]
"""An effect and the values of its parameters."""


@dataclass(frozen=True)
class Machine:
    """An axis with its values, and the sizes of its motion and force."""

    kind: str
    axis: Axis
    values: dict[str, float]
    scale: Scale


def _friction(
    body: Body, force: float, speed: float, rng: np.random.Generator
) -> tuple[tuple, dict[str, float]]:
    elements = ViscousFriction(body, "Fv"), CoulombFriction(body, "Fs")
    return elements, {
        "Fv": force * log_uniform(rng, 0.05, 0.4) / speed,
        "Fs": force * log_uniform(rng, 0.1, 0.6),
    }


def _machine(
    kind: str, rng: np.random.Generator, inertia: float, acceleration: float, resolution: float
) -> Machine:
    """A machine with a driven body of an inertia, and what its kind has besides."""
    speed = acceleration * log_uniform(rng, 0.06, 0.25)
    travel = speed**2 / acceleration * log_uniform(rng, 3, 8)
    if kind in ("pendulum", "robot joint") and travel > 3.0:
        travel, speed = 3.0, min(speed, float(np.sqrt(1.5 * acceleration)))
    body = Body("driven", mass="J") if kind == "slide" else Body("driven", inertia="J")
    whole, elements, values = inertia, [body], {"J": inertia}
    sensors = [Position("q", body, resolution=resolution, noise=0.3 * resolution)]
    if kind == "ball screw":
        ratio = float(rng.choice([5e-3, 1e-2, 2e-2])) / (2 * np.pi)
        values["M"] = inertia / ratio**2 * log_uniform(rng, 0.2, 1.5)
        elements.append(Body("table", mass="M", geared=Geared(to=body, ratio=ratio)))
        whole += values["M"] * ratio**2
    if kind == "elastic load":
        load, w = Body("load", inertia="Jl"), 2 * np.pi * log_uniform(rng, 20, 90)
        values["Jl"] = inertia * log_uniform(rng, 0.3, 3)
        whole += values["Jl"]
        values["K"] = w**2 * inertia * values["Jl"] / whole
        values |= {
            "C": 0.04 * values["K"] / w,
            "Fvl": whole * acceleration * log_uniform(rng, 0.03, 0.2) / speed,
        }
        coupling = Spring("coupling", Between(first=body, second=load), stiffness="K", damping="C")
        elements += [coupling, load, ViscousFriction(load, "Fvl")]
        if rng.random() < 0.6:
            sensors.append(Position("ql", load, resolution=resolution, noise=0.3 * resolution))
    force = whole * acceleration
    if kind in ("pendulum", "robot joint"):
        elements.append(PendulumWeight(body, "mgl", 1.0))
        values["mgl"] = force * log_uniform(rng, 0.3, 2)
    laws, levels = _friction(body, force, speed, rng)
    noise = force * log_uniform(rng, 0.003, 0.03)
    drive = Drive("F", body, held=True, noise=noise, resolution=0.3 * noise)
    axis = Axis("machine", elements=(*elements, *laws), drive=drive, sensors=tuple(sensors))
    scale = Scale(
        body,
        force,
        acceleration,
        speed,
        travel,
        inertia,
        resolution,
        turns=kind != "slide",
        friction=levels["Fs"],
        viscous=levels["Fv"],
    )
    return Machine(kind, axis, values | levels, scale)


KINDS = {
    "servo": ((1e-4, 5e-2), (100, 600), (12, 14, 17, 20)),
    "pendulum": ((1e-4, 5e-2), (8, 40), (12, 14, 17, 20)),
    "robot joint": ((0.5, 5), (8, 40), (20, 22, 24)),
    "elastic load": ((1e-4, 1e-2), (100, 500), (14, 17, 20)),
    "slide": ((5, 200), (2, 15), ()),
    "ball screw": ((1e-3, 2e-2), (200, 1000), (14, 17, 20)),
}
"""Ranges of inertia (kg m^2, kg) and acceleration (rad/s^2, m/s^2), and bits of the encoder; a slide has a scale."""


def drawn_machine(rng: np.random.Generator) -> Machine:
    kind = str(rng.choice(list(KINDS)))
    inertias, accelerations, bits = KINDS[kind]
    inertia, acceleration = log_uniform(rng, *inertias), log_uniform(rng, *accelerations)
    resolution = 2 * np.pi / 2 ** rng.choice(bits) if bits else rng.choice(_SCALES)
    return _machine(kind, rng, inertia, acceleration, float(resolution))


def drawn_small(
    machine: Machine, effects: Sequence[str], share: float, rng: np.random.Generator
) -> list[Added]:
    """Effects of a small part of a share of the force."""
    sizes = rng.uniform(*_RELATIVE, len(effects))
    return [
        drawn_effect(name, machine.scale, share * float(size), rng, f"E{i + 1}")
        for i, (name, size) in enumerate(zip(effects, sizes, strict=True))
    ]


def drawn_logs(
    machine: Machine, added: Sequence[Added], seed: int, rng: np.random.Generator, *, wanders: bool
) -> tuple[Log, ...] | None:
    """Two logs of a machine with effects; None where the controller drawn suits no machine."""
    run = drawn_run(machine, 1 / float(rng.choice(RATES)), rng)
    try:
        logs = simulated(machine, added, *run, seed)
    except SymidError:
        return None
    if winds_up(machine, logs):
        return None
    noise = drawn_wandering(rng)
    return tuple(wandering(log, *noise, rng) for log in logs) if wanders else logs


def drawn_run(machine: Machine, period: float, rng: np.random.Generator) -> tuple[list[Trajectory], float]:
    """References of both logs, and the bandwidth of the controller, Hz."""
    bandwidth, moves = float(rng.uniform(10, 25)), rng.random() < 0.7
    return [_reference(machine.scale, moves, size, period) for size in (1.0, _VALIDATION)], bandwidth


def drawn_wandering(rng: np.random.Generator) -> tuple[float, float]:
    """Size of a force noise that wanders, in multiples of the white noise, and the frequency up to which it does."""
    return log_uniform(rng, 0.05, 0.5), float(rng.uniform(2, 5))


def winds_up(machine: Machine, logs: Sequence[Log]) -> bool:
    """Whether the controller asks for a force that suits no machine."""
    largest = max(float(np.abs(log["F"]).max()) for log in logs)
    return largest > _WOUND_UP * (machine.scale.force + machine.values.get("mgl", 0.0))


def simulated(
    machine: Machine, added: Sequence[Added], references: Sequence[Trajectory], bandwidth: float, seed: int
) -> tuple[Log, ...]:
    """Logs of a machine with effects, under a controller that suits it."""
    axis, values = machine.axis, dict(machine.values)
    for element, numbers in added:
        axis, values = axis.with_effect(element), values | numbers
    loop = tuned_cascade(plant_of(axis, values), "q", bandwidth_hz=bandwidth)
    return tuple(simulate(axis, values, r, loop, seed=2 * seed + i).log for i, r in enumerate(references))


def wandering(log: Log, relative: float, highest: float, rng: np.random.Generator) -> Log:
    """A log whose force wanders by a multiple of its noise, up to a frequency in Hz."""
    force = log["F"]
    noise = float(np.std(np.diff(force, 2))) / np.sqrt(6)
    slow = butter(1, highest, fs=log.sampling_frequency, output="sos")
    course = sosfilt(slow, rng.standard_normal(force.size))
    signals = dict(log.signals) | {"F": force + relative * noise * course / course.std()}
    return Log.from_arrays(signals, sampling_period=log.sampling_period)


def _reference(scale: Scale, moves: bool, size: float, period: float) -> Trajectory:
    if not moves:
        highest = min(15.0, 1 / (30 * period))
        return chirp(
            0.5, highest, 8.0, size * min(0.4 * scale.travel, 0.3 * scale.speed), sampling_period=period
        )
    return trapezoids(
        [size * scale.travel, 0.3 * scale.travel],
        [0.2 * size * scale.speed, 0.5 * scale.speed, size * scale.speed],
        acceleration=size * scale.acceleration,
        jerk=30 * scale.acceleration,
        dwell=0.1,
        sampling_period=period,
    )
