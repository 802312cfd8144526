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

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import count, islice

import numpy as np

from benchmarks.diagnosis.drawn_effects import EFFECTS, drawn_effect
from benchmarks.diagnosis.drawn_machines import (
    RATES,
    Machine,
    drawn_machine,
    drawn_run,
    drawn_small,
    drawn_wandering,
    simulated,
    wandering,
    winds_up,
)
from benchmarks.options import parser_of
from symid import Axis, Log, SymidError
from symid.diagnosis import Diagnosis, FoundEffect, diagnose

CLEAR = 2.0
"""Error of the re-identified axis without the effect, in multiples of the floor, from which on it counts."""
_SMALL = 2
"""Small effects of a worldly case."""


@dataclass(frozen=True)
class Case:
    """Two logs of a machine with effects, the one drawn as the largest first; without any; and with each alone."""

    machine: Machine
    effects: tuple[str, ...]
    logs: tuple[Log, ...]
    none: tuple[Log, ...]
    alone: tuple[tuple[Log, ...], ...]
    nominal: dict[str, float]


def drawn(seed: int, *, worldly: bool = False) -> Case | None:
    """A case; None where the controller drawn suits no machine."""
    rng = np.random.default_rng(seed)
    machine = drawn_machine(rng)
    effect = str(rng.choice([*EFFECTS, "none", "none"]))
    period = 1 / float(rng.choice(RATES))
    effects = () if effect == "none" else (effect,)
    added = []
    if effects:
        share = float(rng.uniform(0.12, 0.35))
        added.append(drawn_effect(effect, machine.scale, share, rng))
    if effects and worldly:
        others = rng.permutation([name for name in EFFECTS if name != effect])[:_SMALL]
        effects = (effect, *map(str, others))
        added += drawn_small(machine, effects[1:], share, rng)
    run = drawn_run(machine, period, rng)
    try:
        logs = simulated(machine, added, *run, seed)
        none = simulated(machine, (), *run, seed) if added else logs
        alone = [logs]
        if len(added) != 1:
            alone = [simulated(machine, (one,), *run, seed) for one in added]
    except SymidError:
        return None
    if winds_up(machine, logs):
        return None
    if worldly:
        noise = drawn_wandering(rng)
        logs, none = (tuple(wandering(log, *noise, rng) for log in pair) for pair in (logs, none))
    nominal = {name: x * float(rng.uniform(0.85, 1.15)) for name, x in machine.values.items()}
    return Case(machine, effects, logs, none, tuple(alone), nominal)


def sizes(case: Case) -> tuple[float, ...]:
    """Error of the re-identified axis without effects and with each alone, in multiples of the floor."""
    return tuple(
        floors_left(case.machine.axis, logs, case.machine.values) for logs in (case.none, *case.alone)
    )


def floors_left(axis: Axis, logs: Sequence[Log], values: Mapping[str, float]) -> float:
    """Error of an axis, re-identified, in multiples of the floor, on a second log if there is one."""
    log, other = (*logs, None)[:2]
    nominal = {name: values[name] for name in axis.physical_parameters}
    gap = diagnose(axis, log, validation=other, nominal=nominal, library=()).gap
    return gap.reidentified.rms / gap.noise_floor.rms


def sought(case: Case, least: float, alone: Sequence[float]) -> tuple[str, ...]:
    """Effects that may be reported first: the one that clearly costs most, or several; none below the floor."""
    largest = max(alone, default=0.0)
    if largest <= CLEAR * least:
        return ()
    return tuple(e for e, size in zip(case.effects, alone, strict=True) if size > largest / CLEAR)


def names(effect: FoundEffect) -> set[str]:
    """An effect that was found, and its stated ties."""
    return {effect.effect, *(name for name, _ in effect.indistinguishable_from)}


def false_effects(effects: Iterable[FoundEffect], there: Collection[str]) -> list[FoundEffect]:
    """Effects named with a probability of at least a half that are not there."""
    return [one for one in effects if one.probability >= 0.5 and names(one).isdisjoint(there)]


def names_of(effects: Iterable[FoundEffect]) -> str:
    return ", ".join(f"{one.effect} ({one.probability:.2f})" for one in effects)


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
        right = is_right(wanted, found) or (group == "below the floor" and is_right(case.effects, found))
        right = right or (not wanted and least > CLEAR and found.verdict == "unexplained")
        false = len(false_effects(found.effects, case.effects))
        there = ", ".join(f"{e} {size:.1f}" for e, size in zip(case.effects, alone, strict=True))
        line = f"{seed:6} {case.machine.kind:12} {least:.1f} floors, {there} -> {found.verdict:11} "
        line += names_of(found.effects)
        yield group, right, false, f"{line} {'' if right else 'WRONG'} {'FALSE' if false else ''}"


def main() -> None:
    given = parser_of(__doc__, seed=1, cases=60, worldly=False).parse_args()
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
