"""Models without a law of the machine: python -m benchmarks.diagnosis.lacking [--seed N] [--cases N] [--worldly]

The machines of `benchmarks.diagnosis.machines`, diagnosed with a model without the Coulomb friction, the viscous
friction or the weight of the driven body, as first models of real machines often are. Nominal values are up to 15 %
off; a smaller run is the validation log. `--worldly` adds two small effects and drifting noise of the force.

A law counts if the error of the re-identified model without it is at least twice that of the complete model, and twice
the noise. An answer is right if the law is reported first, or as a stated tie; its value is right within 5 % or three
of its deviations. Effects that are reported with a probability of at least a half but do not exist are counted.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count, islice

import numpy as np

from benchmarks.diagnosis.drawn_effects import EFFECTS
from benchmarks.diagnosis.drawn_machines import Machine, drawn_logs, drawn_machine, drawn_small
from benchmarks.diagnosis.machines import CLEAR, false_effects, floors_left, names, names_of
from benchmarks.options import parser_of
from symid import Axis, CoulombFriction, Log, PendulumWeight, ViscousFriction
from symid.axis.axis import Element
from symid.diagnosis import Diagnosis, FoundEffect, diagnose

_LAWS: dict[type[Element], tuple[str, str]] = {
    CoulombFriction: ("coulomb_friction", "Fs"),
    ViscousFriction: ("viscous_friction", "Fv"),
    PendulumWeight: ("weight", "mgl"),
}
"""Laws that a model may lack: their effect, and the machine's value."""
_SHARE = 0.2
"""Of the force, to which small effects are relative."""
_CLOSE, _DEVIATIONS = 0.05, 3.0


@dataclass(frozen=True)
class Case:
    """A machine, its logs, and a model without one of its laws."""

    machine: Machine
    lacks: str
    value: float
    small: tuple[str, ...]
    logs: tuple[Log, ...]
    model: Axis
    nominal: dict[str, float]


def drawn(seed: int, *, worldly: bool) -> Case | None:
    """A case; None where the controller drawn suits no machine."""
    rng = np.random.default_rng(seed)
    machine = drawn_machine(rng)
    laws = [law for law in machine.axis.elements if type(law) in _LAWS and _place(law) == machine.scale.body]
    law = laws[rng.integers(len(laws))]
    effect, name = _LAWS[type(law)]
    small = tuple(map(str, rng.permutation(EFFECTS)[:2])) if worldly else ()
    logs = drawn_logs(machine, drawn_small(machine, small, _SHARE, rng), seed, rng, wanders=worldly)
    if logs is None:
        return None
    model = machine.axis.without(law)
    known = {name: x for name, x in machine.values.items() if name in model.physical_parameters}
    nominal = {name: x * float(rng.uniform(0.85, 1.15)) for name, x in known.items()}
    return Case(machine, effect, machine.values[name], small, logs, model, nominal)


def _place(law: Element) -> object:
    return law.body if isinstance(law, PendulumWeight) else getattr(law, "at", None)


def is_close(case: Case, effects: tuple[FoundEffect, ...]) -> bool:
    """Whether the law is found with the machine's value, a weight with its size."""
    found = [list(own.parameters.values()) for own in effects if own.effect == case.lacks]
    found = [values if case.lacks == "weight" else values[:1] for values in found]
    return any(
        abs(math.hypot(*(p.value for p in own)) - case.value)
        < max(_CLOSE * case.value, _DEVIATIONS * max(p.std for p in own))
        for own in found
    )


@dataclass(frozen=True)
class Row:
    """A diagnosis: whether the law counts, is named first and has its value; effects not there; and all in a line."""

    clear: bool
    right: bool
    close: bool
    false: int
    line: str


def rows(first: int, number: int, *, worldly: bool) -> Iterator[Row]:
    """Some cases from a seed on, diagnosed."""
    cases = ((seed, case) for seed in count(first) if (case := drawn(seed, worldly=worldly)) is not None)
    for seed, case in islice(cases, number):
        found: Diagnosis = diagnose(case.model, case.logs[0], validation=case.logs[1], nominal=case.nominal)
        complete, without = (
            floors_left(axis, case.logs, case.machine.values) for axis in (case.machine.axis, case.model)
        )
        clear = without > CLEAR * max(complete, 1.0)
        right = any(case.lacks in names(effect) for effect in found.effects[:1])
        close = is_close(case, found.effects)
        false = len(false_effects(found.effects, {case.lacks, *case.small}))
        line = f"{seed:6} {case.machine.kind:12} lacks {case.lacks}, {without:.1f} floors, complete {complete:.1f}"
        remarks = [
            ("below the floor", not clear),
            ("WRONG", clear and not right),
            ("VALUE", right and not close),
        ]
        remarked = " ".join(remark for remark, applies in (*remarks, ("FALSE", bool(false))) if applies)
        line = f"{line} -> {found.verdict:11} {names_of(found.effects)} {remarked}"
        yield Row(clear, right, right and close, false, line)


def main() -> None:
    given = parser_of(__doc__, seed=1, cases=40, worldly=False).parse_args()
    found = []
    for row in rows(given.seed, given.cases, worldly=given.worldly):
        print(row.line, flush=True)
        found.append(row)
    seen = [row for row in found if row.clear]
    print(
        f"the law lacking is named first in {sum(row.right for row in seen)} of {len(seen)} cases in which it counts"
    )
    print(f"its value is right in {sum(row.close for row in seen)} of these")
    print(f"named with a probability of at least a half, but not there: {sum(row.false for row in found)}")


if __name__ == "__main__":
    main()
