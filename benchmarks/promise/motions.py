"""Reference motions in closed form: position, velocity and acceleration at any time, from trapezoids to multisines."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.draws import log_uniform

Motion = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]
"""From times in s to position in m, velocity and acceleration."""


@dataclass(frozen=True)
class Move:
    """One move: its speed rises as a quintic smooth step over `ramp` s, stays for `cruise` s, and falls likewise."""

    start: float
    begins: float
    speed: float
    ramp: float
    cruise: float

    @property
    def ends(self) -> float:
        """Time at which it stands again, s."""
        return self.begins + 2 * self.ramp + self.cruise

    @property
    def goal(self) -> float:
        return self.start + self.speed * (self.ramp + self.cruise)

    def at(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Position, velocity and acceleration at times within the move."""
        up = np.clip((t - self.begins) / self.ramp, 0, 1)
        down = np.clip((t - self.begins - self.ramp - self.cruise) / self.ramp, 0, 1)
        cruised = np.clip(t - self.begins - self.ramp, 0, self.cruise)
        position = self.ramp * (_risen(up) + down - _risen(down)) + cruised
        velocity = _step(up) - _step(down)
        acceleration = (_slope(up) - _slope(down)) / self.ramp
        return self.start + self.speed * position, self.speed * velocity, self.speed * acceleration


def _step(x: np.ndarray) -> np.ndarray:
    return x**3 * (10 - 15 * x + 6 * x**2)


def _risen(x: np.ndarray) -> np.ndarray:
    return x**4 * (2.5 - 3 * x + x**2)


def _slope(x: np.ndarray) -> np.ndarray:
    return 30 * x**2 * (1 - x) ** 2


def moves(seconds: float, speed: float, acceleration: float, rng: np.random.Generator) -> Motion:
    """Moves to and fro at several speeds and accelerations, with and without dwells."""
    every: list[Move] = []
    time, place = rng.uniform(0.05, 0.3), 0.0
    while time < seconds:
        fast = speed * log_uniform(rng, 0.1, 1)
        steep = acceleration * rng.uniform(0.4, 1)
        sign = -np.sign(place) if place and rng.random() < 0.7 else rng.choice([-1, 1])
        cruise = rng.uniform(0.02, 0.4)
        every.append(Move(place, time, sign * fast, max(1.875 * fast / steep, 0.02), cruise))
        place = every[-1].goal
        time = every[-1].ends + (rng.uniform(0.02, 0.4) if rng.random() < 0.4 else 0.0)

    def motion(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        found = np.zeros((3, t.size))
        for move in every:
            inside = slice(*np.searchsorted(t, (move.begins, move.ends)))
            found[:, inside] = move.at(t[inside])
            found[0, inside.stop :] = move.goal
        return found[0], found[1], found[2]

    return motion


def multisine(low: float, high: float, speed: float, acceleration: float, rng: np.random.Generator) -> Motion:
    """Sines of random phase between two frequencies in Hz, as strong as speed and acceleration allow."""
    n = int(rng.integers(8, 40))
    frequencies = np.geomspace(low, high, n) * rng.uniform(0.97, 1.03, n)
    w, phases = 2 * np.pi * frequencies, rng.uniform(0, 2 * np.pi, n)
    amplitudes = w ** -rng.uniform(1.2, 2.0)
    rms_speed, rms_acceleration = (np.sqrt(np.sum((amplitudes * w**k) ** 2) / 2) for k in (1, 2))
    amplitudes *= min(speed / 2.5 / rms_speed, acceleration / 2.5 / rms_acceleration)

    def motion(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        found = np.zeros((3, t.size))
        for a, rate, phase in zip(amplitudes, w, phases, strict=True):
            sine, cosine = np.sin(rate * t + phase), np.cos(rate * t + phase)
            found[0] += a * sine
            found[1] += a * rate * cosine
            found[2] -= a * rate**2 * sine
        return found[0], found[1], found[2]

    return motion


def together(*parts: Motion) -> Motion:

    def motion(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        found = np.sum([part(t) for part in parts], axis=0)
        return found[0], found[1], found[2]

    return motion


def draw_motion(seconds: float, mode_hz: float | None, rng: np.random.Generator) -> tuple[Motion, str]:
    """Trapezoids, a multisine, or both; a flexible axis is excited beyond its mode mostly."""
    speed, acceleration = (
        log_uniform(rng, 0.1, 1.5),
        log_uniform(rng, 2, 25),
    )
    kind = str(
        rng.choice(["moves", "multisine", "both"], p=[0.4, 0.3, 0.3] if mode_hz is None else [0.2, 0.4, 0.4])
    )
    high = rng.uniform(4, 40) if mode_hz is None else mode_hz * rng.uniform(1.2, 2.5)
    parts = []
    if kind != "multisine":
        parts.append(moves(seconds, speed, acceleration, rng))
    if kind != "moves":
        share = 0.4 if kind == "both" else 1.0
        parts.append(multisine(rng.uniform(0.3, 1.5), high, share * speed, share * acceleration, rng))
    return together(*parts), kind
