"""Machines of another simulator, many with short or slow logs: python -m benchmarks.diagnosis.others

A servo that swings a weight and warms up, a belt with a late encoder at its load, a vertical screw with cogging, a
robot joint whose friction depends on its load, a leg that leans, a pendulum with dry friction, simulated by
`benchmarks.diagnosis.other_machines`, which shares no law with symid. Logs last 5 to 60 s at 50 Hz to 8 kHz; `--short`
ones at most 10 s at 250 Hz (screws and belts 500 Hz). The model lacks one law of the machine, or none, and three small
effects that the machine has besides, of 2 to 6 % of its force. Nominal values are up to 10 % off; half of the cases
have a second log for validation.

A law counts if the re-identified model without it leaves twice the floor and twice the mean square that the complete
one leaves. An answer is right if the law is named first, or as a stated tie; its value is right within 15 % or three of
its deviations. Effects that the machine does not have are counted: first ones of any probability, and all those of at
least a half.
"""

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.diagnosis.machines import CLEAR, false_effects, floors_left, names, names_of
from benchmarks.diagnosis.other_cases import Case, drawn
from benchmarks.options import parser_of
from symid import SymidError
from symid.diagnosis import Diagnosis, FoundEffect, diagnose

_CLOSE, _DEVIATIONS = 0.15, 3.0
_OF_TWO = {"weight": "Gs", "cogging": "As"}


@dataclass(frozen=True)
class Row:
    """A diagnosis beside what is true."""

    counts: bool
    complete: bool
    right: bool
    close: bool
    false: int
    first: tuple[tuple[float, bool], ...]
    line: str


def is_close(case: Case, effects: tuple[FoundEffect, ...]) -> bool:
    """Whether the law is found with the machine's value."""
    for own in (effect for effect in effects if effect.effect == case.effect):
        first = own.parameters.get(_OF_TWO.get(case.effect, "")) or next(iter(own.parameters.values()))
        size = abs(first.value)
        if case.effect == "cogging":
            size = math.hypot(*(own.parameters[name].value for name in ("As", "Ac")))
        if abs(size - case.value) < max(_CLOSE * case.value, _DEVIATIONS * first.std):
            return True
    return False


def judged(case: Case, seed: int, also: Collection[str] = (), aside: Collection[str] = ()) -> Row:
    """A case diagnosed, its answer judged.

    Effects `also` are right as well; those `aside` are the recorder's, and the first one is the first beside them.
    """
    log, other = (*case.logs, None)[:2]
    nominal = {name: case.nominal[name] for name in case.model.physical_parameters}
    found: Diagnosis = diagnose(case.model, log, validation=other, nominal=nominal)
    complete = floors_left(case.complete, case.logs, case.nominal)
    without = floors_left(case.model, case.logs, case.nominal) if case.lacks != "none" else complete
    counts = case.lacks != "none" and without**2 > CLEAR * max(complete**2, CLEAR)
    machines_own = [own for own in found.effects if own.effect not in aside]
    right = any(not names(first).isdisjoint({case.effect, *also}) for first in machines_own[:1])
    close = is_close(case, found.effects)
    false = len(false_effects(found.effects, case.there))
    first = tuple((e.probability, not names(e).isdisjoint(case.there)) for e in found.effects[:1])
    marks = [("below", not counts and case.lacks != "none"), ("WRONG", counts and not right)]
    marks += [("VALUE", counts and right and not close), ("FALSE", bool(false))]
    line = (
        f"{seed:6} {case.kind:11} {log.sampling_frequency:5.0f} Hz {log.n_samples * log.sampling_period:3.0f} s, "
        f"{len(case.logs)}, lacks {case.effect}, {without:.1f} floors, complete {complete:.1f} -> "
        f"{found.verdict:11} {names_of(found.effects)} {' '.join(mark for mark, applies in marks if applies)}"
    )
    return Row(counts, case.lacks == "none", right, close, false, first, line)


def main() -> None:
    print_cases(__doc__, judged)


def print_cases(description: str | None, judge: Callable[[Case, int], Row]) -> None:
    """Judge the drawn cases that the command line asks for, print each, then how many are right."""
    given = parser_of(description, seed=1, cases=40, short=False).parse_args()
    rows = []
    for seed in range(given.seed, given.seed + given.cases):
        try:
            rows.append(judge(drawn(seed, short=given.short), seed))
            print(rows[-1].line, flush=True)
        except SymidError as error:
            print(f"{seed:6} refused: {error}", flush=True)
    _print_sums(rows)


def _print_sums(rows: Sequence[Row]) -> None:
    seen, firsts = [row for row in rows if row.counts], [one for row in rows for one in row.first]
    none = [row for row in rows if row.complete]
    print(f"the law lacking is named first in {sum(row.right for row in seen)} of {len(seen)} that count")
    print(f"its value is right in {sum(row.right and row.close for row in seen)} of these")
    print(f"first effects that are not there: {sum(not is_there for _, is_there in firsts)} of {len(firsts)}")
    alarms = sum(not is_there for row in none for _, is_there in row.first)
    print(f"of these where the model lacks none: {alarms} of {len(none)}")
    print(f"named with a probability of at least a half, but not there: {sum(row.false for row in rows)}")
    if firsts:
        print(f"Brier score of first effects: {np.mean([(p - is_there) ** 2 for p, is_there in firsts]):.3f}")


if __name__ == "__main__":
    main()
