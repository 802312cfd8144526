"""Logs of the three axes by inverse dynamics written by hand: the motion is prescribed, the force is what it takes.

Body 2 follows a motion in closed form; the flexible body answers it as an oscillator, integrated by the classical
Runge-Kutta method at 20 kHz or more with the exact acceleration of body 2 at every stage. The force then follows from
the balance of body 2. While it stands, friction keeps an arbitrary part of its level.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from benchmarks.draws import log_uniform
from benchmarks.promise.motions import draw_motion

SENSORS = {
    "rigid_1m": (("q",),),
    "direct_2m1s": (("q2",), ("q2", "ddq1"), ("q2", "ddq2"), ("q2", "ddq1", "ddq2")),
    "ballscrew_2m1s": (("qm",), ("qm", "ql")),
}
FORCE = {"rigid_1m": "F", "direct_2m1s": "Fm", "ballscrew_2m1s": "Fm"}
SHARES = {"rigid_1m": 0.5, "direct_2m1s": 0.27, "ballscrew_2m1s": 0.23}
RATES = (250, 500, 1000, 2000, 4000, 5000, 8000, 10_000)
FINE = 20_000


@dataclass(frozen=True)
class Case:
    """A log of known truth, and how it came about."""

    axis: str
    truth: dict[str, float]
    signals: dict[str, np.ndarray]
    rate: float
    motion: str
    mode_hz: float = 0.0
    fault: str = ""

    @property
    def measured(self) -> tuple[str, ...]:
        return tuple(name for name in self.signals if name != self.force)

    @property
    def force(self) -> str:
        return FORCE[self.axis]

    def changed(self, fault: str, **signals: np.ndarray) -> Case:
        """The log with some signals damaged."""
        return replace(self, signals={**self.signals, **signals}, fault=fault)


@njit(cache=True)
def _oscillator(a, v, x_in, v_in, h, inertia, direct, damping, stiffness, ground):
    """State of m x'' = -direct a - damping (x' - v) - stiffness (x - x_in) - ground x'; inputs at half steps."""
    n = a.size // 2
    x, w = np.zeros(n), np.zeros(n)
    y, u = 0.0, 0.0
    for k in range(n):
        x[k], w[k] = y, u
        ky, ku = np.zeros(4), np.zeros(4)
        for s in range(4):
            i = 2 * k + (0 if s == 0 else (1 if s < 3 else 2))
            i = min(i, a.size - 1)
            dt = 0.0 if s == 0 else (h / 2 if s < 3 else h)
            ys, us = y + dt * ky[s - 1], u + dt * ku[s - 1]
            ky[s] = us
            ku[s] = (
                -direct * a[i] - damping * (us - v_in[i]) - stiffness * (ys - x_in[i]) - ground * us
            ) / inertia
        y += h / 6 * (ky[0] + 2 * ky[1] + 2 * ky[2] + ky[3])
        u += h / 6 * (ku[0] + 2 * ku[1] + 2 * ku[2] + ku[3])
    return x, w


def draw_case(rng: np.random.Generator, axis: str | None = None) -> Case:
    """A random undamaged log."""
    axis = axis or str(rng.choice(list(SHARES), p=list(SHARES.values())))
    case = draw_machine(axis, SENSORS[axis][rng.integers(len(SENSORS[axis]))], rng)
    signals = {}
    for name, x in case.signals.items():
        signals[name] = with_noise(x, draw_noise(case, name, rng), rng)
    return replace(case, signals=signals)


def draw_machine(axis: str, measured: tuple[str, ...], rng: np.random.Generator) -> Case:
    """The log of a random machine and motion, without noise."""
    rate = int(rng.choice(RATES))
    seconds = rng.uniform(4, 20)
    mode = None if axis == "rigid_1m" else log_uniform(rng, 12, min(110, rate / 8))
    motion, kind = draw_motion(seconds, mode, rng)
    truth = draw_truth(axis, mode, motion, rng)
    clean = clean_signals(axis, rate, seconds, motion, truth, rng)
    signals = {name: clean[name] for name in (*measured, FORCE[axis])}
    return Case(axis, truth, signals, rate, kind, mode or 0.0)


def draw_truth(axis: str, mode_hz: float | None, motion, rng: np.random.Generator) -> dict[str, float]:
    """Masses, springs and frictions; frictions are 2 to 50 % of what the masses take."""
    mass = log_uniform(rng, 3, 3000)
    _, v, a = motion(np.linspace(0, 4, 4001))
    inertial = mass * np.sqrt(np.mean(a**2))
    viscous = log_uniform(rng, 0.02, 0.5) * inertial / np.sqrt(np.mean(v**2))
    coulomb = log_uniform(rng, 0.02, 0.5) * inertial
    if axis == "rigid_1m":
        return {"M": mass, "Fv": viscous, "Fs": coulomb}
    w, ratio, damping = 2 * np.pi * mode_hz, rng.uniform(0.4, 10), log_uniform(rng, 0.004, 0.05)
    other = mass * ratio
    if axis == "direct_2m1s":
        stiff = (mass + other) * w**2
        flexible = {"Ms": other, "Fvs": 2 * damping * stiff / w, "Ks": stiff}
        return {**flexible, "Mm": mass, "Fvm": viscous, "Fsm": coulomb}
    ratio = rng.uniform(0.3, 4)
    load, stiff = mass * ratio, mass * ratio * w**2
    motor = {"Mm": mass, "Fvm": viscous, "Fsm": coulomb}
    return {
        **motor,
        "Kt": stiff,
        "Ft": 2 * damping * stiff / w,
        "Ml": load,
        "Fvl": viscous * rng.uniform(0.3, 1),
    }


def clean_signals(axis, rate, seconds, motion, truth, rng) -> dict[str, np.ndarray]:
    n, more = int(seconds * rate), -(-FINE // rate)
    half = np.arange(2 * more * n) / (2 * more * rate)
    q, v, a = motion(half)
    taken = slice(None, None, 2 * more)
    friction = _friction(v[taken], rng)
    if axis == "rigid_1m":
        F = truth["M"] * a[taken] + truth["Fv"] * v[taken] + truth["Fs"] * friction
        return {"q": q[taken], "F": F}
    h = 1 / (more * rate)
    if axis == "direct_2m1s":
        Ms, Mm = truth["Ms"], truth["Mm"]
        still = np.zeros_like(a)
        x, w = _oscillator(a, v, still, still, h, Ms + Mm, Mm, truth["Fvs"], truth["Ks"], 0.0)
        x, w = x[::more], w[::more]
        ddq1 = (-Mm * a[taken] - truth["Fvs"] * w - truth["Ks"] * x) / (Ms + Mm)
        F = Mm * (ddq1 + a[taken]) + truth["Fvm"] * v[taken] + truth["Fsm"] * friction
        return {"q2": q[taken], "ddq1": ddq1, "ddq2": a[taken], "Fm": F}
    x, w = _oscillator(a, v, q, v, h, truth["Ml"], 0.0, truth["Ft"], truth["Kt"], truth["Fvl"])
    x, w = x[::more], w[::more]
    spring = truth["Kt"] * (q[taken] - x) + truth["Ft"] * (v[taken] - w)
    F = truth["Mm"] * a[taken] + truth["Fvm"] * v[taken] + truth["Fsm"] * friction + spring
    return {"qm": q[taken], "ql": x, "Fm": F}


def _friction(v: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Sign of the velocity; a part of the last sign while the machine stands."""
    sign = np.sign(v)
    last = np.maximum.accumulate(np.where(sign != 0, np.arange(v.size), 0))
    return np.where(sign != 0, sign, rng.uniform(0, 1) * sign[last])


def draw_noise(case: Case, name: str, rng: np.random.Generator) -> tuple[str, float]:
    """Kind and size of the noise of a signal.

    Encoders: 2 nm to 2 um, or steps of 5 nm to 1 um; force and accelerometers: 0.02 to 2 % of the rms signal.
    """
    if name == case.force or name.startswith("dd"):
        return "white", log_uniform(rng, 2e-4, 2e-2) * np.sqrt(np.mean(case.signals[name] ** 2))
    if rng.random() < 0.3:
        return "steps", log_uniform(rng, 5e-9, 1e-6)
    return "white", log_uniform(rng, 2e-9, 2e-6)


def with_noise(x: np.ndarray, noise: tuple[str, float], rng: np.random.Generator) -> np.ndarray:
    """A signal with noise of a kind and size; steps are of an encoder whose own noise is 0.3 of one."""
    kind, size = noise
    if kind == "steps":
        return np.round((x + 0.3 * size * rng.standard_normal(x.size)) / size) * size
    return x + size * rng.standard_normal(x.size)
