"""Random axes: derived equations against an ODE written by hand, and the cost of each derivation.

An axis has bodies that turn or slide, on springs with dampers, in a tree or with one loop, with ratios that are not
integers, some of them to the ground. Geared bodies, weights, friction, one to three drives, and sensors of all kinds
are drawn too. The ODE is assembled here in numpy and solved for motions exp(s t) at several s at once. The regressor of
the derived model times its minimal parameters must give its output. Each axis is derived in a process of its own.

Usage: python -m benchmarks.random_axes [--examples N] [--seed N] [--bodies N]
"""

import os
import pickle
import resource
import time
from collections import Counter
from dataclasses import dataclass

import numpy as np

from benchmarks.options import parser_of
from symid import (
    Acceleration,
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    Force,
    Geared,
    Position,
    Sensor,
    Spring,
    Velocity,
    ViscousFriction,
    Weight,
    derive,
)
from symid.arrays import FloatArray
from symid.axis import STANDARD_GRAVITY, Element
from symid.codegen.generated_models import compiled
from symid.errors import EliminationError
from symid.signal_names import split_derivative

LONGEST = 10.0
"""Processor time that a derivation may take, s: twice the bound, for machines that are busy otherwise."""
ENDED = 60
"""Processor time after which a derivation is ended, s."""
LARGEST = 1000.0
"""Memory that its process may take, MB."""
TOLERANCE = 1e-6
_ROWS, _MODES = 40, 14
_MOTION = (Position, Velocity, Acceleration)
_RATIOS = (0.00159, 0.35, 2.0, 7 / 3)
"""Ratios of machines: a screw of 10 mm, a belt, gears; 7/3 is no number of the decimal system."""


@dataclass(frozen=True, eq=False)
class Reading:
    """What a sensor reads: (position x + velocity x' + acceleration x'' + drives F - offset) / gain."""

    motion: FloatArray  # shape (3, n): rows of the bodies' displacements, velocities and accelerations
    drives: FloatArray  # shape (n_drives,)
    gain: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class Machine:
    """An axis, values of its parameters, and its ODE M x'' + C x' + K x + friction + weight = push F."""

    axis: Axis
    values: dict[str, float]
    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    push: FloatArray  # shape (n, n_drives)
    weight: FloatArray
    level: float  # of Coulomb friction on the first body
    readings: dict[str, Reading]

    def signals(self, names: tuple[str, ...], rng: np.random.Generator) -> dict[str, FloatArray]:
        """Values of signals and their derivatives, such as ``q0_d2``, in random motions."""
        n, drives = self.push.shape
        rates = np.append(rng.uniform(0.4, 1.6, _MODES), 0.0)
        forces = rng.normal(size=(_MODES + 1, drives, _ROWS))
        places = np.zeros((_MODES + 1, n, _ROWS))
        for k, s in enumerate(rates[:-1]):
            dynamic = self.mass * s**2 + self.damping * s + self.stiffness
            places[k] = np.linalg.solve(dynamic, self.push @ forces[k])
        # Friction is constant until the body turns back: constant forces and displacements balance it and the weight.
        constant = np.outer(np.eye(n)[0], self.level * np.sign(rates @ places[:, 0])) + self.weight[:, None]
        still = np.linalg.lstsq(np.column_stack([self.stiffness, -self.push]), -constant, rcond=None)[0]
        places[-1], forces[-1] = still[:n], still[n:]
        by_drive = {drive.signal: i for i, drive in enumerate(self.axis.drives)}
        found = {}
        for flat in names:
            name, order = split_derivative(flat)
            if name in by_drive:
                modes = forces[:, by_drive[name]]
            else:
                one = self.readings[name]
                rows = np.einsum("mp,pn->mn", rates[:, None] ** np.arange(3), one.motion)
                modes = np.einsum("mn,mnt->mt", rows, places) + np.einsum("d,mdt->mt", one.drives, forces)
                modes[-1] -= one.offset
                modes = modes / one.gain
            found[flat] = rates**order @ modes
        return found


class _Draw:
    """Bodies, springs and sensors of a random axis, beside the matrices of its ODE."""

    def __init__(self, n: int, rng: np.random.Generator) -> None:
        self.rng, self.n, self.unit = rng, n, np.eye(n)
        self.values: dict[str, float] = {}
        slides = rng.random(n) < 0.3
        own = [self.named(f"J{i}") for i in range(n)]
        self.bodies = [
            Body(f"b{i}", mass=own[i]) if slides[i] else Body(f"b{i}", inertia=own[i]) for i in range(n)
        ]
        self.elements: list[Element] = list(self.bodies)
        self.mass = np.diag([self.values[f"J{i}"] for i in range(n)])
        self.damping, self.stiffness = np.zeros((2, n, n))
        self.weight = np.zeros(n)
        self.springs: list[tuple[Spring, FloatArray]] = []

    def named(self, name: str) -> str:
        """Name of a new parameter, whose value is drawn."""
        self.values[name] = float(self.rng.uniform(0.5, 2.0))
        return name

    def ratio(self) -> float:
        listed = self.rng.random() < 0.5
        return float(self.rng.choice(_RATIOS) if listed else np.round(self.rng.uniform(0.05, 3.0), 4))

    def spring(self, name: str, at: Body | Between, across: FloatArray) -> None:
        damping = self.named(f"D{name}") if self.rng.random() < 0.6 else None
        spring = Spring(name, at, stiffness=self.named(f"K{name}"), damping=damping)
        self.elements.append(spring)
        self.springs.append((spring, across))
        self.stiffness += self.values[f"K{name}"] * np.outer(across, across)
        self.damping += self.values.get(f"D{name}", 0.0) * np.outer(across, across)

    def joints(self) -> None:
        """Springs in a tree or with one loop, some to the ground."""
        n, ends = self.n, [(int(self.rng.integers(i)), i) for i in range(1, self.n)]
        if n > 2 and self.rng.random() < 0.4:
            ends.append(next(e for e in ((0, n - 1), (1, n - 1), (0, 1)) if e not in ends))
        for k, (i, j) in enumerate(ends):
            same = self.bodies[i].turns == self.bodies[j].turns
            turned = 1.0 if same and self.rng.random() < 0.3 else self.ratio()
            joint = Between(first=self.bodies[i], second=self.bodies[j], ratio=turned)
            self.spring(f"s{k}", joint, self.unit[j] - turned * self.unit[i])
        for i in range(n):
            if self.rng.random() < 0.1:
                self.spring(f"h{i}", self.bodies[i], self.unit[i])

    def rest(self) -> float:
        """Friction, geared bodies and weights; the level of Coulomb friction on the first body."""
        for i, body in enumerate(self.bodies):
            if self.rng.random() < 0.4:
                self.elements.append(ViscousFriction(body, self.named(f"F{i}")))
                self.damping[i, i] += self.values[f"F{i}"]
            if self.rng.random() < 0.2:
                turned = self.ratio()
                geared = Body(f"g{i}", inertia=self.named(f"G{i}"), geared=Geared(to=body, ratio=turned))
                self.elements.append(geared)
                self.mass[i, i] += self.values[f"G{i}"] * turned**2
            if not body.turns and self.rng.random() < 0.3:
                self.elements.append(Weight(body))
                self.weight[i] = self.values[f"J{i}"] * STANDARD_GRAVITY
        if self.rng.random() < 0.5:
            self.elements.append(CoulombFriction(self.bodies[0], self.named("Fs")))
        return self.values.get("Fs", 0.0)

    def drives(self) -> tuple[tuple[Drive, ...], FloatArray]:
        """One to three drives, and the forces that they exert by unit of their signals."""
        count = min(self.n, int(self.rng.choice((1, 1, 1, 2, 3))))
        driven = [0, *(int(i) for i in self.rng.permutation(np.arange(1, self.n))[: count - 1])]
        drives, push = [], self.unit[driven].T.copy()
        for k, i in enumerate(driven):
            gain = self.named(f"c{k}") if count > 1 and k and self.rng.random() < 0.5 else None
            kind = "N*m" if self.bodies[i].turns else "N"
            drives.append(Drive(f"T{k}", self.bodies[i], gain=gain, unit="A" if gain else kind))
            push[:, k] *= self.values[gain] if gain else 1.0
        return tuple(drives), push

    def sensors(self, drives: tuple[Drive, ...], push: FloatArray) -> tuple[list[Sensor], dict[str, Reading]]:
        """Positions of the driven bodies, and sensors of all kinds."""
        none, still = np.zeros(len(drives)), np.zeros((3, self.n))
        sensors: list[Sensor] = []
        readings: dict[str, Reading] = {}

        def add(sensor: Sensor, motion: FloatArray, forces: FloatArray = none) -> None:
            sensors.append(sensor)
            of = [
                self.values[x] if isinstance(x, str) else d for x, d in ((sensor.gain, 1), (sensor.offset, 0))
            ]
            readings[sensor.signal] = Reading(motion, forces, *of)

        driven = [self.bodies.index(drive.at) for drive in drives if isinstance(drive.at, Body)]
        for i in driven:
            add(Position(f"q{i}", self.bodies[i]), np.array([self.unit[i], *still[1:]]))
        for i in (i for i in range(1, self.n) if self.rng.random() < 0.3):
            kind = _MOTION[int(self.rng.integers(3))]
            name, motion, other = f"{'pva'[kind.derivative]}{i}", still.copy(), None
            motion[kind.derivative] = self.unit[i]
            near = [j for j in range(i) if self.bodies[j].turns == self.bodies[i].turns]
            if near and self.rng.random() < 0.3:
                other = self.bodies[j := int(self.rng.choice(near))]
                motion[kind.derivative] -= self.unit[j]
            offset = self.named(f"o{i}") if self.rng.random() < 0.15 else None
            add(kind(name, self.bodies[i], relative_to=other, offset=offset), motion)
        for k, (spring, across) in enumerate(self.springs):
            if self.rng.random() < 0.12:
                own = self.values[f"K{spring.name}"], self.values.get(f"D{spring.name}", 0.0)
                add(Force(f"f{k}", spring), np.array([own[0] * across, own[1] * across, still[2]]))
        return sensors, readings


def machine(n: int, rng: np.random.Generator) -> Machine:
    """A random axis of n bodies with coordinates."""
    draw = _Draw(n, rng)
    draw.joints()
    level = draw.rest()
    drives, push = draw.drives()
    sensors, readings = draw.sensors(drives, push)
    axis = Axis("drawn", tuple(draw.elements), drives, tuple(sensors))
    matrices = (draw.mass, draw.damping, draw.stiffness)
    return Machine(axis, draw.values, *matrices, push, draw.weight, level, readings)


def outcome(seed: int, n: int) -> tuple[str, str]:
    """How the derivation of a random axis of n bodies ended, and what to know of it: "agrees", or else."""
    rng = np.random.default_rng((seed, n))
    drawn = machine(n, rng)
    measured = tuple(sensor.signal for sensor in drawn.axis.sensors)
    begun = time.process_time()
    try:
        model = compiled(derive(drawn.axis, measured))
    except EliminationError as error:
        seconds = time.process_time() - begun
        return "too long" if seconds > LONGEST else "refused", f"{seconds:.1f} s, {error}"
    seconds = time.process_time() - begun
    W, y = model.sample(drawn.signals(model.signals, rng))
    X = model.minimal_parameters(*(drawn.values[name] for name in model.physical_units))
    size = (np.abs(W) @ np.abs(X) + np.abs(y)).max(axis=1)
    relative = float(np.max(np.abs(W @ X - y).max(axis=1) / size))
    cost = f"{seconds:.1f} s, {peak():.0f} MB"
    said = f"{cost}, relative error {relative:.1g}, {n} bodies, measured {', '.join(measured)}"
    if not relative < TOLERANCE:
        return "differs", said
    return "too long" if seconds > LONGEST else "agrees", said


def peak() -> float:
    """Largest memory of the process so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000


def in_a_process(seed: int, n: int) -> tuple[str, str]:
    """The outcome in a process of its own, whose memory counts alone."""
    reading, writing = os.pipe()
    if not (child := os.fork()):
        resource.setrlimit(resource.RLIMIT_CPU, (ENDED, ENDED))
        with os.fdopen(writing, "wb") as answer:
            verdict, said = outcome(seed, n)
            answer.write(pickle.dumps(("too large" if peak() > LARGEST else verdict, said)))
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as answer:
        said = answer.read()
    os.waitpid(child, 0)
    return pickle.loads(said) if said else ("ended", f"after {ENDED} s")


def main() -> None:
    options = parser_of(__doc__, examples=300, seed=0, bodies=5, all=False).parse_args()
    found: Counter[str] = Counter()
    for seed in range(options.seed, options.seed + options.examples):
        n = 2 + seed % (options.bodies - 1)
        verdict, said = in_a_process(seed, n)
        found[verdict] += 1
        if options.all or verdict != "agrees":
            print(f"outcome({seed}, {n}): {verdict}, {said}", flush=True)
    print(", ".join(f"{count} {verdict}" for verdict, count in found.most_common()))


if __name__ == "__main__":
    main()
