"""Reference motions: S-curves at several speeds, reversals, dwells, creeping moves; a multisine on the force."""

import numpy as np

from benchmarks.draws import log_uniform

from .engine import CONTROL_HZ


def velocity_profile(distance: float, speed: float, acceleration: float, rounding: float) -> np.ndarray:
    """Velocity of one move over `distance` at 16 kHz: a trapezoid, its corners rounded over a time; ends at rest."""
    speed = min(speed, np.sqrt(abs(distance) * acceleration))
    ramp, total = speed / acceleration, abs(distance) / speed
    t = np.arange(1, int((total + ramp) * CONTROL_HZ) + 1) / CONTROL_HZ
    v = np.clip(np.minimum(t, total + ramp - t) * acceleration, 0, speed)
    n = max(int(rounding * CONTROL_HZ), 1)
    v = np.convolve(v, np.full(n, 1 / n))
    return v * distance * CONTROL_HZ / v.sum()


def draw_reference(seconds: float, style: dict[str, float], rng: np.random.Generator) -> np.ndarray:
    """Position and velocity at 16 kHz, shape (2, ticks): starts at rest at zero, may end while it moves."""
    ticks, parts, place = int(seconds * CONTROL_HZ), [np.zeros(CONTROL_HZ * 3 // 16)], 0.0
    while sum(part.size for part in parts) < ticks:
        pace = 2 if len(parts) == 5 else rng.choice(3, p=[0.35, 0.25, 0.4])  # the third is always a fast one
        slow, fast = [(0.008, 0.05), (0.1, 0.25), (0.25, style["speed"])][pace]
        speed = log_uniform(rng, slow, fast)
        goal = (
            rng.choice([-1, 1]) * style["stroke"]
            if rng.random() < 0.3
            else rng.uniform(-1, 1) * style["stroke"]
        )
        distance = np.clip(goal - place, -speed * 1.7, speed * 1.7)
        if abs(distance) < 0.003:
            continue
        parts.append(
            velocity_profile(distance, speed, style["acceleration"] * rng.uniform(0.4, 1), style["rounding"])
        )
        parts.append(
            np.zeros(
                int(rng.choice([0.01, 0.05, 0.3], p=[0.3, 0.5, 0.2]) * rng.uniform(0.8, 1.5) * CONTROL_HZ)
            )
        )
        place += distance
    v = np.concatenate(parts)[:ticks]
    return np.stack([np.cumsum(v) / CONTROL_HZ, v])


def draw_style(axis: str, rng: np.random.Generator) -> dict[str, float]:
    """Stroke, top speed, acceleration and rounding of the corners, of one axis."""
    top = 0.6 if axis == "rigid_1m" else 0.8
    return {
        "stroke": rng.uniform(0.12, 0.24),
        "speed": rng.uniform(0.6, 1) * top,
        "acceleration": rng.uniform(5, 11),
        "rounding": rng.uniform(0.012, 0.035),
    }


def draw_multisine(axis: str, mass: float, seconds: float, rng: np.random.Generator) -> np.ndarray:
    """Force of 0.2 to 0.45 m/s^2 (rms) times the mass, from 6 to 90 Hz (rigid) or 120 Hz, for some 3.5 s."""
    t = np.arange(int(seconds * CONTROL_HZ)) / CONTROL_HZ
    frequencies = np.geomspace(6, 90 if axis == "rigid_1m" else 120, 38)
    phases = rng.uniform(0, 2 * np.pi, frequencies.size)
    wave = sum(np.sin(2 * np.pi * f * t + phase) for f, phase in zip(frequencies, phases, strict=True))
    start, length = rng.uniform(4.5, 6), rng.uniform(3, 3.7)
    window = np.clip(np.minimum(t - start, start + length - t) / 0.1, 0, 1)
    return mass * rng.uniform(0.2, 0.45) * np.sqrt(2 / frequencies.size) * wave * window
