"""Machine axes as matrices written by hand, and exact motions of them: the route that knows nothing of symid.

A plant is M x'' + C x' + K x = B F + constant - sum d f(d.x, d.x'), x being absolute displacements (or, on a gear,
the displacement of the body that sets the motion) and f the nonlinear forces along rows d.

Motions are made as jets: position, velocity and the derivatives of the force are drawn at random at each sample, and
every higher derivative follows from the equation of motion differentiated. A jet is a point of a trajectory, so an
equation that holds along all trajectories must hold on it to rounding, without any error of integration.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import comb

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Jet = list[Array]
"""Derivatives of one signal from order 0 on, each sampled."""
Force = Callable[[Jet], Jet]
"""Jet of a force from the jet of the displacement; the force may use one derivative more than it returns."""


@dataclass(frozen=True)
class Sensor:
    """A signal row.x^(order)."""

    row: tuple[float, ...]
    order: int = 0


@dataclass(frozen=True)
class Plant:
    """Matrices of an axis at given parameter values."""

    M: Array
    C: Array
    K: Array
    B: Array
    constant: Array
    nonlinear: tuple[tuple[Array, Force], ...] = ()
    force_size: float = 1.0

    @property
    def bodies(self) -> int:
        """Number of displacements."""
        return len(self.B)

    @property
    def angular_frequency(self) -> float:
        """Highest natural frequency, 1 rad/s for a rigid axis: the scale of time."""
        stiffness = float(np.max(np.abs(np.linalg.eigvals(np.linalg.solve(self.M, self.K)))))
        return max(1.0, np.sqrt(stiffness))


def plant(
    M: Sequence[Sequence[float]],
    C: Sequence[Sequence[float]],
    K: Sequence[Sequence[float]],
    B: Sequence[float],
    *,
    constant: Sequence[float] | None = None,
    nonlinear: Sequence[tuple[Sequence[float], Force]] = (),
    force_size: float = 1.0,
) -> Plant:
    """Plant of nested lists."""
    rows = tuple((np.array(row, dtype=float), force) for row, force in nonlinear)
    still = np.zeros(len(B)) if constant is None else np.array(constant, dtype=float)
    return Plant(
        np.array(M, float),
        np.array(C, float),
        np.array(K, float),
        np.array(B, float),
        still,
        rows,
        force_size,
    )


def product(first: Jet, second: Jet) -> Jet:
    """Jet of a product, by Leibniz' rule."""
    orders = range(min(len(first), len(second)))
    return [
        sum((comb(k, j) * first[j] * second[k - j] for j in range(k + 1)), np.zeros_like(first[0]))
        for k in orders
    ]


def sine(angle: Jet) -> Jet:
    """Jet of the sine of an angle, from s' = c u' and c' = -s u'."""
    sines, cosines = [np.sin(angle[0])], [np.cos(angle[0])]
    for k in range(len(angle) - 1):
        sines.append(
            sum((comb(k, j) * cosines[k - j] * angle[j + 1] for j in range(k + 1)), np.zeros_like(angle[0]))
        )
        cosines.append(
            -sum((comb(k, j) * sines[k - j] * angle[j + 1] for j in range(k + 1)), np.zeros_like(angle[0]))
        )
    return sines


def friction(forward: tuple[float, float], backward: tuple[float, float] | None = None) -> Force:
    """Viscous coefficient and Coulomb level of each direction; the jump itself is not differentiated."""
    viscous_back, level_back = backward or forward

    def force(displacement: Jet) -> Jet:
        velocity = displacement[1:]
        ahead = velocity[0] > 0
        coefficient = np.where(ahead, forward[0], viscous_back)
        level = np.where(ahead, forward[1], -level_back)
        return [coefficient * v + (level if k == 0 else 0) for k, v in enumerate(velocity)]

    return force


def coulomb(level: float) -> Force:
    """Fs sign(v)."""
    return friction((0.0, level))


def pendulum(moment: float, gravity: float) -> Force:
    """m l g sin(q)."""
    return lambda angle: [moment * gravity * s for s in sine(angle)]


def cubic(stiffness: float) -> Force:
    """k q^3."""
    return lambda q: [stiffness * c for c in product(q, product(q, q))]


def drag(coefficient: float) -> Force:
    """c v |v|."""

    def force(displacement: Jet) -> Jet:
        velocity = displacement[1:]
        return [coefficient * np.sign(velocity[0]) * square for square in product(velocity, velocity)]

    return force


def ripple(sine_force: float, cosine_force: float, pitch: float) -> Force:
    """Sine and cosine along the stroke."""

    def force(displacement: Jet) -> Jet:
        angle = [2 * np.pi / pitch * q for q in displacement]
        ahead = [angle[0] + np.pi / 2, *angle[1:]]
        return [sine_force * s + cosine_force * c for s, c in zip(sine(angle), sine(ahead), strict=True)]

    return force


@dataclass(frozen=True)
class Motion:
    """Derivatives of displacements and force: x[k] of shape (bodies, samples), force[k] of shape (samples,)."""

    x: list[Array]
    force: list[Array]

    def signals(self, drive: str, sensors: Mapping[str, Sensor], names: Sequence[str]) -> dict[str, Array]:
        """Signals by flat name, such as ``q2_d3``."""
        read = {}
        for name in names:
            base, _, order = name.rpartition("_d")
            signal, k = (base, int(order)) if base and order.isdigit() else (name, 0)
            read[name] = (
                self.force[k]
                if signal == drive
                else sensors[signal].row @ np.array(self.x[k + sensors[signal].order])
            )
        return read


def random_motion(machine: Plant, orders: int, samples: int, seed: int) -> Motion:
    """A random jet at each sample, of sizes natural to the plant, so that no term of its equations drowns."""
    draw = np.random.default_rng(seed)
    omega = machine.angular_frequency
    lengths = machine.force_size / (np.diag(machine.M) * omega**2)
    x = [lengths[:, None] * omega**k * draw.normal(size=(machine.bodies, samples)) for k in range(2)]
    drive_size = machine.force_size / np.max(np.abs(machine.B))
    force = [drive_size * omega**k * draw.normal(size=samples) for k in range(orders + 1)]
    return Motion(continued(machine, x, force, orders), force)


def continued(machine: Plant, x: list[Array], force: list[Array], orders: int) -> list[Array]:
    """Derivatives of the displacements up to an order, from position, velocity and the derivatives of the force."""
    x = list(x)
    for k in range(orders - 1):
        balance = machine.B[:, None] * force[k] - machine.C @ x[k + 1] - machine.K @ x[k]
        if k == 0:
            balance = balance + machine.constant[:, None]
        for row, law in machine.nonlinear:
            balance = balance - row[:, None] * law([row @ derivative for derivative in x])[k]
        x.append(np.linalg.solve(machine.M, balance))
    return x


def harmonic_motion(
    machine: Plant,
    frequencies: Sequence[float],
    orders: int,
    samples: int,
    *,
    force_offset: float = 0.0,
    seed: int = 0,
) -> Motion:
    """Steady answer of a linear plant to a sum of sines, all derivatives from its complex frequency response.

    A constant force may drive it at constant speed along its free motion: then Coulomb friction, whose sign does not
    change, must be part of that constant force.
    """
    draw = np.random.default_rng(seed)
    t = np.linspace(0.0, 3.0 / min(frequencies), samples)
    x = [np.zeros((machine.bodies, samples)) for _ in range(orders + 1)]
    force = [np.zeros(samples) for _ in range(orders + 1)]
    for frequency in frequencies:
        s = 2j * np.pi * frequency
        response = np.linalg.solve(machine.M * s**2 + machine.C * s + machine.K, machine.B.astype(complex))
        wave = machine.force_size * np.exp(s * t + 2j * np.pi * draw.random())
        for k in range(orders + 1):
            x[k] += np.real(response[:, None] * (s**k * wave))
            force[k] += np.real(s**k * wave)
    if force_offset:
        force[0] = force[0] + force_offset
    return Motion(x, force)


@dataclass(frozen=True)
class Values:
    """Physical parameters by name, in the order of the declaration."""

    numbers: dict[str, float] = field(default_factory=dict)

    def __getattr__(self, name: str) -> float:
        try:
            return self.numbers[name]
        except KeyError:
            raise AttributeError(name) from None
