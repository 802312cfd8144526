"""Two failures of simulator fitting, solved: a missing elasticity and a shift by one sample are found.

The set-ups are those on which MuJoCo's own identification (mujoco.sysid 4.0.0) was run. *Structure*: two masses of 20
and 40 kg on a spring of 4e5 N/m, Stribeck friction, position noise of 1 um; the model is one rigid mass with viscous
and Coulomb friction. *Timing*: rigid axes, the force shifted by one sample (1 ms) either way against the position, and
the same logs unshifted, with new noise each time. All truths come from the simulator of benchmarks/blind, which shares
nothing with symid and integrates at 160 kHz. What the source does not give is chosen here: damping (2 %), friction
values, controller, motion, and 4 kHz for the first.

Usage: python -m benchmarks.peer_failures [--draws N]   (100 draws take some minutes)
"""

import math
import time
from dataclasses import dataclass

import numpy as np

import symid
from benchmarks.blind.axes import Machine, draw_parameters, machine, with_row
from benchmarks.blind.engine import CONTROL_HZ, LOG_TICKS, STRIBECK, loop
from benchmarks.blind.motion import draw_multisine, velocity_profile
from benchmarks.draws import log_uniform
from benchmarks.options import parser_of
from symid.diagnosis import Diagnosis, diagnose

CALM = 1.5
"""Rest at the end of each log, in which the load comes to rest too, s."""
NOISE = 1e-6
"""Of the position, m."""
HELD = {"F": -0.5 / CONTROL_HZ}
"""The simulated controller holds its force for its own period."""
DRIVEN, LOAD, STIFFNESS, DAMPING_RATIO = 20.0, 40.0, 4e5, 0.02
FRICTION = {"viscous": 100.0, "coulomb": 12.0, "dF": 6.0, "vs": 0.02}
AIM = 0.1
"""Error of the estimated shift that counts, samples."""


def two_masses() -> Machine:
    """A driven mass with Stribeck friction, a load on a spring."""
    values = {
        "Mm": DRIVEN,
        "Fvm": FRICTION["viscous"],
        "Fsm": FRICTION["coulomb"],
        "Kt": STIFFNESS,
        "Ml": LOAD,
        "Fvl": 0.0,
    }
    damping = 2 * DAMPING_RATIO * math.sqrt(STIFFNESS * LOAD)
    plant = machine("ballscrew_2m1s", {**values, "Ft": damping})
    return with_row(plant, STRIBECK, 0, FRICTION["dF"], FRICTION["vs"])


def moves(seconds: float, rng: np.random.Generator) -> np.ndarray:
    """Position and velocity of moves at slow and fast speeds that begin and end at rest, shape (2, ticks)."""
    still = np.zeros(round(0.2 * CONTROL_HZ))
    parts, place = [still], 0.0
    while sum(part.size for part in parts) < (seconds - 1.0 - CALM) * CONTROL_HZ:
        speed, goal = log_uniform(rng, 0.01, 0.5), rng.uniform(-0.15, 0.15)
        distance = np.clip(goal - place, -1.2 * speed, 1.2 * speed)
        if abs(distance) > 0.003:
            parts += [
                velocity_profile(distance, speed, rng.uniform(3, 8), 0.02),
                still[: rng.integers(200, 2000)],
            ]
            place += distance
    velocity = np.concatenate(parts)
    velocity = np.pad(velocity, (0, max(round(seconds * CONTROL_HZ) - velocity.size, 0)))
    return np.stack([np.cumsum(velocity) / CONTROL_HZ, velocity])


def logged(
    plant: Machine, mass: float, bandwidth_hz: float, seed: int, seconds: float, rate: float
) -> symid.Log:
    """Moves and a multisine under a cascade, as a log of force and position."""
    rng = np.random.default_rng(seed)
    path = moves(seconds, rng)
    motion = np.vstack([path, draw_multisine("rigid_1m", mass, path.shape[1] / CONTROL_HZ, rng)])
    w = 2 * math.pi * bandwidth_hz
    gains = np.array([w / 6, w * mass, w * mass * w / 6, 1.0])
    positions, _, force = loop(plant.arguments(), gains, motion, np.zeros((2, motion.shape[1])))
    every = round(CONTROL_HZ / rate)
    q, u = positions[:: every // LOG_TICKS, plant.drive[0]], force[::every]
    return symid.Log("simulated", 0.0, 1 / rate, {"F": u, "q": q + NOISE * rng.standard_normal(q.size)})


def shifted(log: symid.Log, samples: int) -> symid.Log:
    """The same with the force recorded some samples earlier than it acts."""
    n, late = log.n_samples, max(-samples, 0)
    early = max(samples, 0)
    signals = {"F": log["F"][early : n - late], "q": log["q"][late : n - early]}
    return symid.Log(log.source, 0.0, log.sampling_period, signals)


def structure(seed: int = 7) -> tuple[symid.Log, symid.Log]:
    """Logs of the two masses, for identification and for validation."""
    first, second = (logged(two_masses(), DRIVEN + LOAD, 4.0, seed + i, 10.0, 4000.0) for i in range(2))
    return first, second


def stiffness(found: Diagnosis) -> tuple[float, float]:
    """Stiffness k = m (2 pi f)^2 of a flexible mode that was found and its standard deviation; nan without one."""
    for effect in found.effects:
        if effect.effect == "flexible_mode":
            m, f = effect.parameters["m"], effect.parameters["f"]
            k = m.value * (2 * math.pi * f.value) ** 2
            return k, k * math.hypot(m.std / m.value, 2 * f.std / f.value)
    return math.nan, math.nan


def print_structure() -> None:
    """Print the diagnosis of the two masses beside what the simulator's identification made of such a pair."""
    log, other = structure()
    begin = time.perf_counter()
    found = diagnose(symid.load_axis("rigid_1m"), log, validation=other, late=HELD)
    seconds, floor = time.perf_counter() - begin, found.gap.noise_floor.rms
    print(f"Two masses {DRIVEN:g} + {LOAD:g} kg, k = {STIFFNESS:g} N/m, taken for one rigid mass")
    print("  mujoco.sysid 4.0.0: mass 60.64 ± 0.20 kg, damping 104.6 ± 1.4, frictionloss 13.8 ± 0.5;")
    print("    residual 1244 times the noise of the position, 26 times that of the velocity;")
    print("    'No Issues Detected: All parameters are within their bounds'; 0.2 to 1.6 s")
    print(f"  symid diagnose: {found.sentence} ({seconds:.1f} s)")
    for name, level in (("re-identified", found.gap.reidentified), ("explained", found.gap.explained)):
        print(f"    {name:14} {level.rms:9.4g} N  {level.rms / floor:8.2f} times the noise")
    for effect in found.effects:
        values = ", ".join(f"{n} {p.value:.5g} ± {p.std:.2g} {p.unit}" for n, p in effect.parameters.items())
        print(f"    {effect.effect} at {effect.at} ({effect.probability:.3f}): {values}")
    k, deviation = stiffness(found)
    inside = "within" if abs(k - STIFFNESS) < 1.96 * deviation else "outside"
    print(
        f"    k {k:.6g} ± {deviation:.2g} N/m, the true one {inside} its 95 % interval "
        f"({100 * (k / STIFFNESS - 1):+.2f} %)"
    )
    for change in found.parameters:
        print(
            f"    {change.name} {change.reidentified:.5g} -> {change.explained:.5g} ± {change.explained_std:.2g} "
            f"{change.unit}"
        )


@dataclass(frozen=True)
class Shift:
    """One rigid log diagnosed."""

    true: int  # samples by which the force acts after its record
    found: float  # the same as found; 0 if no delay was
    effects: tuple[str, ...]  # effects that were accepted
    # before, after: error of the mass relative to the true one, re-identified and with what was found
    before: float
    after: float
    covered: bool  # whether the 95 % interval of the mass holds the true one in the end


def draw(seed: int, samples: int) -> Shift:
    """Draw a rigid axis and its log, shift the force, diagnose."""
    values = draw_parameters("rigid_1m", np.random.default_rng(seed))
    log = shifted(logged(machine("rigid_1m", values), values["M"], 25.0, seed, 8.0, 1000.0), samples)
    found = diagnose(symid.load_axis("rigid_1m"), log, late=HELD)
    delays = [e.parameters["T"].value for e in found.effects if e.effect == "delay"]
    mass = next(change for change in found.parameters if change.name == "M")
    return Shift(
        samples,
        sum(delays) / log.sampling_period,
        tuple(effect.effect for effect in found.effects),
        mass.reidentified / values["M"] - 1,
        mass.explained / values["M"] - 1,
        abs(mass.explained - values["M"]) < 1.96 * mass.explained_std,
    )


def print_timing(draws: int) -> None:
    """Print how often a shift by one sample is seen, how well it is estimated, and how often none is taken for one."""
    begin = time.perf_counter()
    moved = [draw(seed, 1 if seed % 2 else -1) for seed in range(draws)]
    still = [draw(seed, 0) for seed in range(draws)]
    seen = [run for run in moved if run.found]
    close = [run for run in moved if abs(run.found - run.true) < AIM]
    worst = max((abs(run.found - run.true) for run in seen), default=math.nan)
    alarms = [run for run in still if {"delay", "actuator_lag"} & set(run.effects)]
    others = [run for run in still if run.effects and run not in alarms]
    print(f"\nA shift by one sample (1 ms), {draws} rigid axes ({time.perf_counter() - begin:.0f} s)")
    print("  mujoco.sysid 4.0.0: 95 % intervals cover 84 to 100 % without, 0 % with the shift; no warning")
    print(
        f"  found: {len(seen)} of {draws}; within {AIM} sample: {len(close)}; largest error {worst:.3f} samples"
    )
    print(
        f"  false alarms on the unshifted logs: {len(alarms)} of {draws}; other effects accepted there: {len(others)}"
    )
    for label, runs in (("shifted", moved), ("unshifted", still)):
        before, after = (
            100 * np.median(np.abs([getattr(run, name) for run in runs])) for name in ("before", "after")
        )
        covered = 100 * np.mean([run.covered for run in runs])
        print(
            f"  {label}: error of M {before:.3f} % re-identified, {after:.3f} % in the end (medians); "
            f"its interval covers {covered:.0f} %"
        )
    for run in moved + others:
        if run in others or run not in close:
            print(f"    shift {run.true}: found {run.found:.3f}, effects {', '.join(run.effects) or 'none'}")


def main() -> None:
    draws = parser_of(__doc__, draws=100).parse_args().draws
    print_structure()
    print_timing(draws)


if __name__ == "__main__":
    main()
