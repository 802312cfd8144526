"""Thousands of damaged logs: `symid identify` must refuse them in one line, give them a status, or be right.

Hypothesis draws the kind of damage (benchmarks/damage), the kind of file, the extent of the damage, and
whether the log is read in blocks. Every log is identified in this process by the function of the command. A failure is
a traceback, a warning, a message of several lines, a hang of 120 s, or a status "ok" with a parameter that is off by
more than 5 % and by more than 6 corrected standard deviations. It prints the counts by kind and verdict, and every
failure with the argument that repeats it. The exit code is 1 if there is a failure.

Usage: python -m benchmarks.damaged_logs [--examples 5000] [--seed 0]
       python -m benchmarks.damaged_logs --repeat KIND:FORM:whole|blocks:EXTENT:SEED
"""

import contextlib
import sys
import time

from hypothesis import given

from benchmarks.commands import Outcome, drawn, table
from benchmarks.damage.outcome import Damage, damages, outcome_of
from benchmarks.options import parser_of


def examined(examples: int, number: int) -> dict[Damage, Outcome]:
    """Outcomes of a number of damaged logs, or of those before Ctrl-C; failures are printed at once."""
    found: dict[Damage, Outcome] = {}

    @drawn(examples, number)
    @given(damages)
    def look(damage: Damage) -> None:
        if damage not in found:
            found[damage] = outcome_of(damage)
            if found[damage].is_failure:
                print(f"{found[damage].verdict}: --repeat {damage}", file=sys.stderr, flush=True)

    with contextlib.suppress(KeyboardInterrupt):
        look()
    return found


def main() -> int:
    parser = parser_of(__doc__, examples=5000, seed=0)
    parser.add_argument("--repeat", metavar="DAMAGE", help="one log, with all that was said")
    given_ = parser.parse_args()
    if given_.repeat:
        outcome = outcome_of(Damage.parse(given_.repeat))
        print(outcome.verdict, outcome.detail, sep="\n")
        return int(outcome.is_failure)
    begin = time.perf_counter()
    found = examined(given_.examples, given_.seed)
    print(table(((damage.kind, outcome) for damage, outcome in found.items()), "kind", 18))
    failures = {damage: outcome for damage, outcome in found.items() if outcome.is_failure}
    for damage, outcome in sorted(failures.items()):
        last = (
            outcome.detail.strip().splitlines()[-1]
            if outcome.verdict == "traceback"
            else outcome.detail.strip()
        )
        print(f"{outcome.verdict}: --repeat {damage}\n    {last}")
    print(f"{len(found)} logs, {len(failures)} failures, {time.perf_counter() - begin:.0f} s")
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main())
