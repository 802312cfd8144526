"""Machines of six kinds under their controllers, with an effect or none: python -m benchmarks.diagnosis.machines

Servos, pendulums, robot joints, motors with an elastic load, slides and ball screws, drawn at random: inertias over two
decades, encoders of 12 to 24 bits, 0.5 to 4 kHz, moves or a chirp. The noise of the encoder passes through the
controller into the force, as on a machine. Nominal values are up to 15 % off; a smaller run is the validation log.
symid simulates the machines itself, so that laws agree: what is tried is all that lies around them.

An effect counts from twice the noise floor on: so much the re-identified axis without it errs. Right is the effect
named first, or a stated tie; without an effect or with a smaller one, "no_gap" and "parameters" are right.

`--worldly` adds two small effects, of 12 to 25 % of the drawn share of force, and a force noise that wanders. What
counts is then the effect that alone costs most, from twice the error without any on; another that costs more than half
of it is right, too. Effects named with a probability of at least a half that are not there are counted.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count, islice

import numpy as np
from scipy.signal import butter, sosfilt

from benchmarks.diagnosis.drawn_effects import EFFECTS, Scale, drawn_effect
from symid import Axis, Body, CoulombFriction, Drive, Log, Position, Spring, SymidError, ViscousFriction
from symid.axis import Between, Geared, PendulumWeight
from symid.axis.axis import Element
from symid.axis.imperfections import Imperfection
from symid.diagnosis import Diagnosis, FoundEffect, diagnose
from symid.simulation import Trajectory, plant_of, simulate, trapezoids, tuned_cascade
from symid.simulation.excitation import chirp

RATES = (500.0, 1000.0, 2000.0, 4000.0)
CLEAR = 2.0
"""Error of the re-identified axis without the effect, in multiples of the floor, from which on it counts."""
_SCALES = (1e-8, 1e-7, 1e-6)
"""Resolutions of a linear scale, m."""
_WOUND_UP = 15.0
"""Force, in multiples of that of the acceleration, of a controller that suits no machine."""
_VALIDATION = 0.7
"""Size of the validation run."""
_SMALL, _RELATIVE = 2, (0.12, 0.25)
"""Small effects of a worldly case, and their shares of the large one's share of force."""
Added = tuple[Element | Imperfection, dict[str, float]]
"""An effect and the values of its parameters."""


@dataclass(frozen=True)
class Machine:
    """An axis with its values, and the sizes of its motion and force."""

    kind: str
    axis: Axis
    values: dict[str, float]
    scale: Scale


@dataclass(frozen=True)
class Case:
    """Two logs of a machine with effects, the one drawn as the largest first; without any; and with each alone."""

    machine: Machine
    effects: tuple[str, ...]
    logs: tuple[Log, ...]
    none: tuple[Log, ...]
    alone: tuple[tuple[Log, ...], ...]
    nominal: dict[str, float]


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """Uniform in the logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _friction(
    body: Body, force: float, speed: float, rng: np.random.Generator
) -> tuple[tuple, dict[str, float]]:
    elements = ViscousFriction(body, "Fv"), CoulombFriction(body, "Fs")
    return elements, {"Fv": force * _between(rng, 0.05, 0.4) / speed, "Fs": force * _between(rng, 0.1, 0.6)}


def _machine(
    kind: str, rng: np.random.Generator, inertia: float, acceleration: float, resolution: float
) -> Machine:
    """A machine with a driven body of an inertia, and what its kind has besides."""
    speed = acceleration * _between(rng, 0.06, 0.25)
    travel = speed**2 / acceleration * _between(rng, 3, 8)
    if kind in ("pendulum", "robot joint") and travel > 3.0:
        travel, speed = 3.0, min(speed, float(np.sqrt(1.5 * acceleration)))
    body = Body("driven", mass="J") if kind == "slide" else Body("driven", inertia="J")
    whole, elements, values = inertia, [body], {"J": inertia}
    sensors = [Position("q", body, resolution=resolution, noise=0.3 * resolution)]
    if kind == "ball screw":
        ratio = float(rng.choice([5e-3, 1e-2, 2e-2])) / (2 * np.pi)
        values["M"] = inertia / ratio**2 * _between(rng, 0.2, 1.5)
        elements.append(Body("table", mass="M", geared=Geared(to=body, ratio=ratio)))
        whole += values["M"] * ratio**2
    if kind == "elastic load":
        load, w = Body("load", inertia="Jl"), 2 * np.pi * _between(rng, 20, 90)
        values["Jl"] = inertia * _between(rng, 0.3, 3)
        whole += values["Jl"]
        values["K"] = w**2 * inertia * values["Jl"] / whole
        values |= {
            "C": 0.04 * values["K"] / w,
            "Fvl": whole * acceleration * _between(rng, 0.03, 0.2) / speed,
        }
        coupling = Spring("coupling", Between(first=body, second=load), stiffness="K", damping="C")
        elements += [coupling, load, ViscousFriction(load, "Fvl")]
        if rng.random() < 0.6:
            sensors.append(Position("ql", load, resolution=resolution, noise=0.3 * resolution))
    force = whole * acceleration
    if kind in ("pendulum", "robot joint"):
        elements.append(PendulumWeight(body, "mgl", 1.0))
        values["mgl"] = force * _between(rng, 0.3, 2)
    laws, levels = _friction(body, force, speed, rng)
    noise = force * _between(rng, 0.003, 0.03)
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


def _turning(bits: tuple[int, ...], rng: np.random.Generator) -> float:
    return float(2 * np.pi / 2 ** rng.choice(bits))


KINDS = {
    "servo": ((1e-4, 5e-2), (100, 600), (12, 14, 17, 20)),
    "pendulum": ((1e-4, 5e-2), (8, 40), (12, 14, 17, 20)),
    "robot joint": ((0.5, 5), (8, 40), (20, 22, 24)),
    "elastic load": ((1e-4, 1e-2), (100, 500), (14, 17, 20)),
    "slide": ((5, 200), (2, 15), ()),
    "ball screw": ((1e-3, 2e-2), (200, 1000), (14, 17, 20)),
}
"""Ranges of inertia (kg m^2, kg) and acceleration (rad/s^2, m/s^2), and bits of the encoder; a slide has a scale."""


def _drawn_machine(rng: np.random.Generator) -> Machine:
    kind = str(rng.choice(list(KINDS)))
    inertias, accelerations, bits = KINDS[kind]
    inertia, acceleration = _between(rng, *inertias), _between(rng, *accelerations)
    return _machine(
        kind, rng, inertia, acceleration, _turning(bits, rng) if bits else float(rng.choice(_SCALES))
    )


def drawn(seed: int, *, worldly: bool = False) -> Case | None:
    """A case; None where the controller drawn suits no machine."""
    rng = np.random.default_rng(seed)
    machine = _drawn_machine(rng)
    effect = str(rng.choice([*EFFECTS, "none", "none"]))
    period = 1 / float(rng.choice(RATES))
    effects = () if effect == "none" else (effect,)
    added = []
    if effects:
        share = float(rng.uniform(0.12, 0.35))
        added.append(drawn_effect(effect, machine.scale, share, rng))
    if effects and worldly:
        others = [
            str(name) for name in rng.permutation([name for name in EFFECTS if name != effect])[:_SMALL]
        ]
        effects = (effect, *others)
        for name, relative in zip(others, rng.uniform(*_RELATIVE, _SMALL), strict=True):
            added.append(drawn_effect(name, machine.scale, share * float(relative), rng, f"E{len(added)}"))
    bandwidth, moves = float(rng.uniform(10, 25)), rng.random() < 0.7
    references = [_reference(machine.scale, moves, size, period) for size in (1.0, _VALIDATION)]
    try:
        logs = _simulated(machine, added, references, bandwidth, seed)
        none = _simulated(machine, (), references, bandwidth, seed) if added else logs
        alone = [logs]
        if len(added) != 1:
            alone = [_simulated(machine, (one,), references, bandwidth, seed) for one in added]
    except SymidError:
        return None
    largest = max(float(np.abs(log["F"]).max()) for log in logs)
    if largest > _WOUND_UP * (machine.scale.force + machine.values.get("mgl", 0.0)):
        return None
    if worldly:
        relative, highest = _between(rng, 0.05, 0.5), float(rng.uniform(2, 5))
        logs, none = (tuple(_wandering(log, relative, highest, rng) for log in pair) for pair in (logs, none))
    nominal = {name: x * float(rng.uniform(0.85, 1.15)) for name, x in machine.values.items()}
    return Case(machine, effects, logs, none, tuple(alone), nominal)


def _simulated(
    machine: Machine, added: Sequence[Added], references: Sequence[Trajectory], bandwidth: float, seed: int
) -> tuple[Log, ...]:
    """Logs of a machine with effects, under a controller that suits it."""
    axis, values = machine.axis, dict(machine.values)
    for element, numbers in added:
        axis, values = axis.with_effect(element), values | numbers
    loop = tuned_cascade(plant_of(axis, values), "q", bandwidth_hz=bandwidth)
    return tuple(simulate(axis, values, r, loop, seed=2 * seed + i).log for i, r in enumerate(references))


def _wandering(log: Log, relative: float, highest: float, rng: np.random.Generator) -> Log:
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


def sizes(case: Case) -> tuple[float, ...]:
    """Error of the re-identified axis without effects and with each alone, in multiples of the floor."""
    found = []
    for log, other in (case.none, *case.alone):
        gap = diagnose(case.machine.axis, log, validation=other, nominal=case.machine.values, library=()).gap
        found.append(gap.reidentified.rms / gap.noise_floor.rms)
    return tuple(found)


def sought(case: Case, least: float, alone: Sequence[float]) -> tuple[str, ...]:
    """What may be named first: the effect that clearly costs most, or each of those that do; none below the floor."""
    largest = max(alone, default=0.0)
    if largest <= CLEAR * least:
        return ()
    return tuple(e for e, size in zip(case.effects, alone, strict=True) if size > largest / CLEAR)


def names(effect: FoundEffect) -> set[str]:
    """An effect that was found, and its stated ties."""
    return {effect.effect, *(name for name, _ in effect.indistinguishable_from)}


def is_right(wanted: Sequence[str], found: Diagnosis) -> bool:
    """Whether one of the effects wanted is named first, or is a stated tie; if none is, whether nothing is named."""
    if not wanted:
        return found.verdict in ("no_gap", "parameters")
    return any(names(first).intersection(wanted) for first in found.effects[:1])


def rows(first: int, number: int, *, worldly: bool) -> Iterator[tuple[str, bool, int, str]]:
    """Group, whether right, effects named that are not there, and a line for each of some cases, from a seed on."""
    cases = ((seed, case) for seed in count(first) if (case := drawn(seed, worldly=worldly)) is not None)
    for seed, case in islice(cases, number):
        least, *alone = sizes(case)
        wanted = sought(case, least, alone)
        group = "none" if not case.effects else ("clear" if wanted else "below the floor")
        found = diagnose(case.machine.axis, case.logs[0], validation=case.logs[1], nominal=case.nominal)
        named = ", ".join(f"{one.effect} ({one.probability:.2f})" for one in found.effects)
        right = is_right(wanted, found) or (group == "below the floor" and is_right(case.effects, found))
        right = right or (not wanted and least > CLEAR and found.verdict == "unexplained")
        false = sum(
            one.probability >= 0.5 and not names(one).intersection(case.effects) for one in found.effects
        )
        there = ", ".join(f"{e} {size:.1f}" for e, size in zip(case.effects, alone, strict=True))
        line = f"{seed:6} {case.machine.kind:12} {least:.1f} floors, {there} -> {found.verdict:11} {named}"
        yield group, right, false, f"{line} {'' if right else 'WRONG'} {'FALSE' if false else ''}"


def main() -> None:
    """Print each case, then how many of each group are right."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", type=int, default=60)
    parser.add_argument("--worldly", action="store_true")
    given = parser.parse_args()
    groups: dict[str, list[bool]] = {}
    named = 0
    for group, right, false, line in rows(given.seed, given.cases, worldly=given.worldly):
        print(line, flush=True)
        groups.setdefault(group, []).append(right)
        named += false
    for group, rights in groups.items():
        print(f"{group}: {sum(rights)} of {len(rights)} right")
    print(f"named with a probability of at least a half, but not there: {named}")


if __name__ == "__main__":
    main()
