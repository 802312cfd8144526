"""Machines simulated without symid: two bodies, a controller, a recorder, in steps of constant force.

A drive moves a body against friction, weight, cogging and a spring to a load. Dry friction is an impulse that stops the
body or opposes its motion (time stepping of Moreau), so that rests are exact; everything else is Euler's method with a
step of 1/`FINE` of a sample of the controller. A recorder keeps every n-th sample. Of symid only the compiler's switch
is used.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from symid.arrays import FloatArray
from symid.jit import jitted

NAMES = (
    *("J", "Fv", "Fs", "dFs", "dFv", "dF", "vs", "mu", "F0", "Gs", "Gc", "k", "As", "Ac", "pitch", "c"),
    *("warm", "tau", "Jl", "K", "C", "Fvl", "Fsl", "Gl", "pose"),
)
"""Quantities of a machine, SI.

Inertia; viscous and Coulomb friction, their differences by direction; Stribeck friction and its velocity; friction by
the force of the drive; a constant force; weights by the sine and the cosine of the angle; stiffness; cogging and its
pitch; drag; the share of friction that goes away while it warms up, and its time constant; inertia, spring, damping,
friction and constant force of a load; an inertia that depends on the angle, J (1 + pose cos q).
"""
FINE = 20
_WANDERS_HZ = 3.0


@dataclass(frozen=True)
class Loop:
    """A controller and its converters."""

    rate: float  # samples of the controller per second
    # stiffness, damping: gains of position and speed
    stiffness: float
    damping: float
    # resolution, force_step: steps of encoder and force
    resolution: float
    force_step: float = 0.0
    # noise, wander: deviation of the white and of the slow error of the force that is recorded
    noise: float = 0.0
    wander: float = 0.0
    delay: float = 0.0  # time by which the force acts late, s
    limit: float = np.inf  # largest force


@dataclass(frozen=True)
class Run:
    """What a recorder has kept: signals by name, and their rate."""

    signals: Mapping[str, FloatArray]
    rate: float


@dataclass(frozen=True)
class Recorder:
    """The n-th sample of every channel, the reading of the load late by a time in s."""

    every: int = 1
    load_late: float = 0.0


def run(values: Mapping[str, float], loop: Loop, reference: FloatArray, recorder: Recorder, seed: int) -> Run:
    """A machine that follows a reference, sampled at the rate of the controller, and what a recorder keeps of it."""
    unknown = values.keys() - set(NAMES)
    if unknown:
        raise ValueError(f"no quantity {', '.join(sorted(unknown))}: choose from {', '.join(NAMES)}")
    rng = np.random.default_rng(seed)
    given = np.array([values.get(name, 1.0 if name in ("vs", "tau", "pitch") else 0.0) for name in NAMES])
    late = round(loop.delay * loop.rate * FINE)
    q, load, force = _march(
        given,
        np.array([loop.rate, loop.stiffness, loop.damping, loop.resolution, loop.force_step, loop.limit]),
        reference,
        late,
    )
    time = np.arange(q.size) / loop.rate
    read = np.interp(time - recorder.load_late, time, load)
    slow = lfilter(
        [1.0], [1.0, -np.exp(-2 * np.pi * _WANDERS_HZ / loop.rate)], rng.standard_normal(force.size)
    )
    error = loop.noise * rng.standard_normal(force.size) + loop.wander * slow / slow.std()
    step = loop.resolution
    every = slice(None, None, recorder.every)
    signals = {"q": np.round(q / step) * step, "F": force + error, "ql": np.round(read / step) * step}
    if loop.force_step:
        signals["F"] = np.round(signals["F"] / loop.force_step) * loop.force_step
    return Run({name: x[every] for name, x in signals.items()}, loop.rate / recorder.every)


@jitted
def _march(given, loop, reference, late):  # type: ignore[no-untyped-def]  # compiled
    j, fv, fs, dfs, dfv, df, vs, mu, f0, gs, gc, k, cs, cc, pitch, drag = given[:16]
    warm, tau, jl, stiff, damp, fvl, fsl, gl, pose = given[16:]
    rate, kp, kd, resolution, force_step, limit = loop
    n, dt = reference.size, 1 / (rate * 20)
    positions, loads, forces = np.empty(n), np.empty(n), np.empty(n)
    q = v = ql = vl = 0.0
    q = reference[0]
    ql = q
    before, goal_before = q, reference[0]
    queue = np.zeros(late + 1)
    at, command, speed = 0, 0.0, 0.0
    filtered = 1 - np.exp(-2 * np.pi * 40 / rate)  # of first order, 40 Hz
    for i in range(n):
        positions[i], loads[i] = q, ql
        read = np.round(q / resolution) * resolution
        speed += filtered * ((read - before) * rate - speed)
        goal_speed = (reference[i] - goal_before) * rate
        before, goal_before = read, reference[i]
        command = kp * (reference[i] - read) + kd * (goal_speed - speed)
        command = min(max(command, -limit), limit)
        if force_step > 0:
            command = np.round(command / force_step) * force_step
        forces[i] = command
        for step in range(20):
            queue[at] = command
            at = (at + 1) % (late + 1)
            force = queue[at] if late else command
            t = (i + step / 20) / rate
            share = 1 + warm * np.exp(-t / tau)
            spring = stiff * (q - ql) + damp * (v - vl)
            inertia = j * (1 + pose * np.cos(q))
            free = force - spring - f0 - gs * np.sin(q) - gc * np.cos(q) - k * q
            free += 0.5 * j * pose * np.sin(q) * v * v
            free -= cs * np.sin(2 * np.pi * q / pitch) + cc * np.cos(2 * np.pi * q / pitch)
            free -= fv * share * v + dfv * abs(v) + drag * v * abs(v)
            way = 1.0 if v > 0 else (-1.0 if v < 0 else (1.0 if free > 0 else -1.0))
            dry = share * fs + way * dfs + df * np.exp(-((v / vs) ** 2)) + mu * abs(force)
            v += dt * free / inertia
            stop = dt * max(dry, 0.0) / inertia
            v = 0.0 if abs(v) < stop else v - stop * np.sign(v)
            if jl > 0:
                vl += dt * (spring - fvl * vl - gl) / jl
                stop = dt * fsl / jl
                vl = 0.0 if abs(vl) < stop else vl - stop * np.sign(vl)
                ql += dt * vl
            q += dt * v
    return positions, loads, forces
