"""Commands run in this process on drawn input, and a table of their outcomes; for `bad_input` and `damaged_logs`."""

import contextlib
import io
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from hypothesis import HealthCheck, Phase, seed, settings

from benchmarks.patience import Hangs, limited
from symid.cli import main

PATIENCE = 120
"""Seconds after which a command hangs; the longest, `symid demo`, takes 9 s of an idle processor."""
FAILURES = ("traceback", "hang", "warning", "several lines", "wrong", "lost", "left behind", "escape")


@dataclass(frozen=True)
class Outcome:
    verdict: str  # "done", "refused" (one line, exit code 2), a status, or one of `FAILURES`
    detail: str  # messages of the command, or what it left

    @property
    def is_failure(self) -> bool:
        """Whether symid must not do this."""
        return self.verdict in FAILURES


@dataclass(frozen=True)
class Ended:
    """Exit code and both streams of a command that came to its end."""

    code: object
    out: str
    err: str


def run_command(arguments: Sequence[str]) -> Ended | Outcome:
    """Run a command; a traceback, a warning and a command without end are outcomes."""
    out, err = io.StringIO(), io.StringIO()
    code: object = None
    with warnings.catch_warnings(record=True) as warned, limited(PATIENCE):
        warnings.simplefilter("always")
        try:
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                main(list(arguments))
        except SystemExit as stop:
            code = stop.code
        except Hangs:
            return Outcome("hang", f"more than {PATIENCE} s")
        except KeyboardInterrupt:
            raise
        except BaseException:  # noqa: BLE001  # any exception is a finding
            return Outcome("traceback", traceback.format_exc())
    if warned:
        return Outcome("warning", f"{warned[0].message} in {warned[0].filename}:{warned[0].lineno}")
    return Ended(code, out.getvalue(), err.getvalue())


def drawn(examples: int, number: int) -> Callable[[Any], Any]:
    """Decorator of a function that takes a number of drawn cases, from a seed, without shrinking."""
    draws = settings(
        max_examples=examples,
        deadline=None,
        database=None,
        derandomize=False,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    return lambda look: seed(number)(draws(look))


def table(found: Iterable[tuple[str, Outcome]], heading: str, width: int) -> str:
    """Counts by kind of case and verdict."""
    pairs = [(kind, outcome.verdict) for kind, outcome in found]
    verdicts = sorted({verdict for _, verdict in pairs})
    lines = [" ".join([heading.ljust(width), *(verdict.rjust(max(len(verdict), 5)) for verdict in verdicts)])]
    for kind in [*sorted({kind for kind, _ in pairs}), None]:
        counts = Counter(verdict for of, verdict in pairs if kind in (of, None))
        cells = (str(counts[v] or "-").rjust(max(len(v), 5)) for v in verdicts)
        lines.append(" ".join([(kind or "all").ljust(width), *cells]))
    return "\n".join(lines)
