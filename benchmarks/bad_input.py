"""Thousands of bad inputs: no command may end in a traceback, hang, warn, or change a file that it reads.

Hypothesis draws commands with strange options, JSON files with strange fields, tables of results and journals with
strange columns, and CSV files with strange headers (benchmarks/bad/cases.py). Each runs in this process in a copy of a
folder of good files. A failure is a traceback, a warning, a hang of two minutes, a message other than one line, an
input that is changed or gone, an unfinished file left behind, or an escape sequence on the terminal. Printed are the
counts by command and outcome, and every failure once for each place in the code. The exit code is 1 if there is one.

Usage: python -m benchmarks.bad_input [--examples 2000] [--seed 0]
"""

import contextlib
import sys
import tempfile
import time
from pathlib import Path

from hypothesis import given

from benchmarks.bad.cases import Case, cases
from benchmarks.bad.outcome import good_folder, outcome_in_a_copy
from benchmarks.commands import Outcome, drawn, table
from benchmarks.options import parser_of


def examined(examples: int, number: int) -> dict[Case, Outcome]:
    """Outcomes of a number of cases, or of those before Ctrl-C; failures are printed at once."""
    found: dict[Case, Outcome] = {}
    places: set[str] = set()
    with tempfile.TemporaryDirectory() as good:
        texts = good_folder(Path(good))

        @drawn(examples, number)
        @given(cases(texts))
        def look(case: Case) -> None:
            if case in found:
                return
            outcome = found[case] = outcome_in_a_copy(case, Path(good))
            if outcome.is_failure and (place := _place(outcome)) not in places:
                places.add(place)
                print(
                    f"{outcome.verdict}: {case!r:.600}\n{outcome.detail[-1500:]}", file=sys.stderr, flush=True
                )

        with contextlib.suppress(KeyboardInterrupt):
            look()
    return found


def _place(outcome: Outcome) -> str:
    """Where a failure comes from: the last line of the code in a trace."""
    lines = [line for line in outcome.detail.splitlines() if line.lstrip().startswith("File ")]
    return outcome.verdict + (lines[-1] if lines else outcome.detail[:80])


def main() -> int:
    options = parser_of(__doc__, examples=2000, seed=0).parse_args()
    begin = time.perf_counter()
    found = examined(options.examples, options.seed)
    failures = sum(outcome.is_failure for outcome in found.values())
    print(table(((case.arguments[0], outcome) for case, outcome in found.items()), "command", 10))
    print(f"{len(found)} cases, {failures} failures, {time.perf_counter() - begin:.0f} s")
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main())
