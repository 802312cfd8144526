"""Random axes: derived equations against an ODE written by hand, and the cost of each derivation.

An axis has two to five inertias on springs with dampers, in a tree or with one loop, with ratios that are not integers;
geared bodies, friction and sensors are drawn too. The ODE is assembled here in numpy and solved for motions exp(s t) at
several s at once. The regressor of the derived model times its minimal parameters must give its output.

Usage: python -m benchmarks.random_axes [--examples N] [--seed N]
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from dataclasses import dataclass

import numpy as np

from symid import (
    Acceleration,
    Axis,
    Between,
    Body,
    CoulombFriction,
    Drive,
    Geared,
    Position,
    Sensor,
    Spring,
    Velocity,
    ViscousFriction,
    derive,
)
from symid.arrays import FloatArray
from symid.axis import Element
from symid.codegen.generate import compiled
from symid.errors import EliminationError
from symid.signal_names import split_derivative

LONGEST = 10.0
"""Processor time that a derivation may take, s: twice the bound, for machines that are busy otherwise."""
TOLERANCE = 1e-6
_ROWS, _MODES = 40, 14
_KINDS = (Position, Position, Velocity, Acceleration)


@dataclass(frozen=True, eq=False)
class Machine:
    """An axis, values of its parameters, and its ODE M x'' + C x' + K x + friction = push * force.

    Coulomb friction of `level` acts on the first body, which the drive turns.
    """

    axis: Axis
    values: dict[str, float]
    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    level: float
    rows: dict[str, FloatArray]
    """Displacement that each sensor reads or differentiates, as a row of the bodies' displacements."""

    def signals(self, names: tuple[str, ...], rng: np.random.Generator) -> dict[str, FloatArray]:
        """Values of signals and their derivatives, such as ``q0_d2``, in random motions."""
        push = np.eye(len(self.mass))[0]
        rates, forces = np.append(rng.uniform(0.4, 1.6, _MODES), 0.0), rng.normal(size=(_MODES + 1, _ROWS))
        places = np.zeros((_MODES + 1, len(push), _ROWS))
        for k, s in enumerate(rates[:-1]):
            dynamic = self.mass * s**2 + self.damping * s + self.stiffness
            places[k] = np.outer(np.linalg.solve(dynamic, push), forces[k])
        # Friction is constant until the body turns back: a constant force and constant displacements balance it.
        friction = np.outer(push, self.level * np.sign(rates @ places[:, 0]))
        still = np.linalg.lstsq(np.column_stack([self.stiffness, -push]), -friction, rcond=None)[0]
        places[-1], forces[-1] = still[:-1], still[-1]
        derivatives = {sensor.signal: sensor.derivative for sensor in self.axis.sensors}
        found = {}
        for flat in names:
            name, order = split_derivative(flat)
            moved = forces if name == "T" else np.tensordot(self.rows[name], places, (0, 1))
            found[flat] = rates ** (order + derivatives.get(name, 0)) @ moved
        return found


def machine(n: int, rng: np.random.Generator) -> Machine:
    """A random axis of n bodies with coordinates."""
    values: dict[str, float] = {}

    def named(name: str) -> str:
        values[name] = float(rng.uniform(0.5, 2.0))
        return name

    def ratio() -> float:
        return float(np.round(rng.uniform(0.05, 3.0), 4))

    bodies = [Body(f"b{i}", inertia=named(f"J{i}")) for i in range(n)]
    elements: list[Element] = list(bodies)
    M, C, K = (np.zeros((n, n)) for _ in range(3))
    unit = np.eye(n)
    M += np.diag([values[f"J{i}"] for i in range(n)])
    ends = [(int(rng.integers(i)), i) for i in range(1, n)]
    if n > 2 and rng.random() < 0.4:
        ends.append(
            (0, n - 1) if (0, n - 1) not in ends else (1, n - 1) if (1, n - 1) not in ends else (0, 1)
        )
    for k, (i, j) in enumerate(ends):
        turned = ratio() if rng.random() < 0.7 else 1.0
        damped = rng.random() < 0.6
        across = np.outer(*[unit[j] - turned * unit[i]] * 2)
        joint = Between(first=bodies[i], second=bodies[j], ratio=turned)
        damping = named(f"D{k}") if damped else None
        elements.append(Spring(f"s{k}", joint, stiffness=named(f"K{k}"), damping=damping))
        K += values[f"K{k}"] * across
        C += values.get(f"D{k}", 0.0) * across
    for i in range(n):
        if rng.random() < 0.4:
            elements.append(ViscousFriction(bodies[i], named(f"F{i}")))
            C += values[f"F{i}"] * np.outer(unit[i], unit[i])
        if rng.random() < 0.25:
            turned = ratio()
            elements.append(Body(f"g{i}", inertia=named(f"G{i}"), geared=Geared(to=bodies[i], ratio=turned)))
            M += values[f"G{i}"] * turned**2 * np.outer(unit[i], unit[i])
    level = 0.0
    if rng.random() < 0.5:
        elements.append(CoulombFriction(bodies[0], named("Fs")))
        level = values["Fs"]
    sensors: list[Sensor] = [Position("q0", bodies[0])]
    rows = {"q0": unit[0]}
    for i in range(1, n):
        if rng.random() < 0.35:
            kind = _KINDS[int(rng.integers(len(_KINDS)))]
            other = bodies[int(rng.integers(i))] if rng.random() < 0.3 else None
            sensors.append(kind(f"q{i}", bodies[i], relative_to=other))
            rows[f"q{i}"] = unit[i] - (0.0 if other is None else unit[bodies.index(other)])
    axis = Axis("drawn", tuple(elements), Drive("T", bodies[0]), tuple(sensors))
    return Machine(axis, values, M, C, K, level, rows)


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
    error = float(np.max(np.abs(W @ X - y).max(axis=1) / size))
    said = f"{seconds:.1f} s, relative error {error:.1g}, {n} bodies, measured {', '.join(measured)}"
    if not error < TOLERANCE:
        return "differs", said
    return "too long" if seconds > LONGEST else "agrees", said


def main() -> None:
    """Count the outcomes of many axes, and name each that does not agree."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--examples", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    found: Counter[str] = Counter()
    for seed in range(options.seed, options.seed + options.examples):
        n = 2 + seed % 4
        verdict, said = outcome(seed, n)
        found[verdict] += 1
        if verdict != "agrees":
            print(f"outcome({seed}, {n}): {verdict}, {said}", flush=True)
    print(", ".join(f"{count} {verdict}" for verdict, count in found.most_common()))


if __name__ == "__main__":
    main()
