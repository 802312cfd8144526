"""Diagnoses of real logs with incomplete models, compared with publications and with a plain script.

EMPS by models without friction, with viscous friction only and with the published symmetric model, and its log with
pulses; a bench of two motors by a rigid model and by the flexible one; a pendulum; axis 1 of a robot as one body and
with its joint; a servo; a motor that turns slowly; the shoulder of a double pendulum; the lift of a service robot;
further joints of both robots, which move with all others. Gaps are measured on another log, or another part of it. For
each case it prints the verdict, the gap by step, the effects found and considered, the published ones, and the
results of a short script on the same logs; then a table.
`--repeated` asks for each case again from half of the logs, from the held-out log, from every second sample, with
nominal values that are 15 % off: whether an answer hangs on the part of a log that it was drawn from.

Usage: python -m benchmarks.diagnosis.real [CASE ...] [--repeated] [--isolated] [--json FILE]
"""

import json
import sys
from argparse import SUPPRESS
from pathlib import Path

from benchmarks.options import parser_of

from .case import Case
from .machines import cases
from .repeated import repeated
from .row import Row, diagnosed, isolated
from .table import print_case, print_script, print_table


def main() -> None:
    parser = parser_of(__doc__, isolated=False, repeated=False)
    parser.add_argument("cases", nargs="*", help="names, or their beginnings [all]")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the table")
    parser.add_argument("--row", type=Path, help=SUPPRESS)  # of one case, for --isolated
    given = parser.parse_args()
    if given.isolated and given.repeated:
        parser.error("--isolated names a case by its name: give it without --repeated")
    asked = [again for case in cases(given.cases) for again in (repeated(case) if given.repeated else [case])]
    rows = [isolated(case) if given.isolated else reported(case) for case in asked]
    if given.row:
        given.row.write_text(json.dumps(rows[0]))
        return
    print_table(rows)
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1))


def reported(case: Case) -> Row:
    found, row = diagnosed(case)
    if found is None:
        print(f"\n=== {case.name}: {case.model}\nrefused: {row['message']}\n  published: {case.published}")
    else:
        print_case(case, found)
    print_script(row)
    sys.stdout.flush()
    return row


if __name__ == "__main__":
    main()
