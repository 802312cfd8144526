"""When symid says ok, is it right? Random logs of known truth, undamaged and damaged.

Logs come from a simulator that shares no code with symid (benchmarks/promise). A result is wrong if a physical
parameter is off by more than 5 % and by more than three of its own printed deviations. Printed are the share of logs
with status "ok", how many of these are wrong and by how many deviations at most; by axis, sensors and fault.

Usage: python -m benchmarks.ok_promise [--logs 1000] [--first 0] [--seed 1] [--method wls]
                                       [--kind undamaged|damaged|both] [--fault NAME] [--show]
"""

import time
from collections import Counter, defaultdict
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.options import parser_of
from benchmarks.promise.faults import BY_NAME, damaged
from benchmarks.promise.machines import Case, draw_case
from symid import Log, load_axis, load_generated
from symid.errors import SymidError
from symid.identification import identify_by_least_squares
from symid.identification.results.identification_result import Identification
from symid.output_error import OutputErrorIdentification, identify_output_error

_WRONG, _DEVIATIONS = 0.05, 3.0


@dataclass(frozen=True)
class Outcome:
    """Result of symid for a case."""

    case: Case
    number: int
    status: str
    values: dict[str, float]
    deviations: dict[str, float]
    notes: tuple[str, ...] = ()
    message: str = ""
    seconds: float = 0.0

    @property
    def worst(self) -> tuple[float, float, str]:
        """Deviations, relative error and name of the parameter that is off most, of those off by more than 5 %."""
        found = [(0.0, 0.0, "")]
        for name, true in self.case.truth.items():
            error = abs(self.values.get(name, np.nan) - true)
            if error > _WRONG * abs(true):
                found.append((error / max(self.deviations[name], 1e-300), error / abs(true), name))
        return max(found)

    @property
    def is_wrong(self) -> bool:
        """Whether it is ok and should not be."""
        return self.status == "ok" and self.worst[0] > _DEVIATIONS


def outcome_of(case: Case, number: int, method: str) -> Outcome:
    """Identify a case as a user would, with nothing chosen."""
    axis = load_axis(case.axis)
    try:
        log = Log.from_arrays(case.signals, sampling_period=1 / case.rate)
        model = load_generated(case.axis, case.measured)
        found: Identification | OutputErrorIdentification
        found = (
            identify_output_error(axis, model, log)
            if method == "oe"
            else identify_by_least_squares(model, log)
        )
    except SymidError as error:
        return Outcome(case, number, "refused", {}, {}, message=str(error))
    return Outcome(
        case,
        number,
        found.status,
        found.physical_parameters,
        deviations_of(found),
        found.notes,
        found.message,
    )


def deviations_of(found: Identification | OutputErrorIdentification) -> dict[str, float]:
    if not found.physical_parameters:
        return {}
    return dict(zip(found.physical_parameters, map(float, found.physical_deviations), strict=True))


def outcomes_of(n: int, first: int, seed: int, kind: str, method: str, fault: str = "") -> list[Outcome]:
    """Outcomes of random cases, each with its processor time."""
    found = []
    for i, case in cases(n, first, seed, kind, fault):
        begin = time.process_time()
        outcome = outcome_of(case, i, method)
        found.append(replace(outcome, seconds=time.process_time() - begin))
    return found


def cases(n: int, first: int, seed: int, kind: str, fault: str = ""):
    """Random cases, damaged with a fault or with any; each has its own generator, so that any can be repeated."""
    for i in range(first, first + n):
        rng = np.random.default_rng([seed, i, kind == "damaged"])
        case = draw_case(rng)
        yield i, damaged(case, rng, fault) if kind == "damaged" else case


def table(outcomes: list[Outcome], title: str, key) -> list[str]:
    """Lines of counts of outcomes, grouped by a key."""
    groups: dict[str, list[Outcome]] = defaultdict(list)
    for outcome in outcomes:
        groups[key(outcome.case)].append(outcome)
    width = max(map(len, groups))
    lines = [f"{title.ljust(width)}  logs    ok  wrong  worst  other statuses"]
    for name, group in sorted(groups.items()):
        ok = [o for o in group if o.status == "ok"]
        wrong = [o for o in ok if o.is_wrong]
        worst = max((o.worst[0] for o in wrong), default=0.0)
        rest = ", ".join(
            f"{s} {c}" for s, c in Counter(o.status for o in group if o.status != "ok").most_common()
        )
        lines.append(f"{name.ljust(width)} {len(group):5d} {len(ok):5d} {len(wrong):6d} {worst:6.1f}  {rest}")
    return lines


def summary(outcomes: list[Outcome]) -> str:
    ok = [o for o in outcomes if o.status == "ok"]
    wrong = [o for o in ok if o.is_wrong]
    far = [o for o in wrong if o.worst[0] > 6]
    return (
        f"{len(outcomes)} logs: ok {100 * len(ok) / len(outcomes):.1f} %; ok and wrong {len(wrong)} "
        f"({100 * len(wrong) / max(len(ok), 1):.1f} % of the ok, {100 * len(wrong) / len(outcomes):.1f} % of all), "
        f"{len(far)} of them beyond 6 deviations; worst {max((o.worst[0] for o in wrong), default=0):.1f}; "
        f"processor time of a log {np.median([o.seconds for o in outcomes]):.2g} s in the median, "
        f"{max(o.seconds for o in outcomes):.2g} s at most"
    )


def main() -> None:
    parser = parser_of(__doc__, logs=1000, first=0, seed=1, show=False)
    parser.add_argument("--method", default="wls", choices=["wls", "oe"])
    parser.add_argument("--kind", default="both", choices=["undamaged", "damaged", "both"])
    parser.add_argument("--fault", default="", choices=sorted(BY_NAME), help="of all damaged logs")
    chosen = parser.parse_args()
    with threadpool_limits(1):
        kinds = ("undamaged", "damaged") if chosen.kind == "both" else (chosen.kind,)
        for kind in ("damaged",) if chosen.fault else kinds:
            outcomes = outcomes_of(chosen.logs, chosen.first, chosen.seed, kind, chosen.method, chosen.fault)
            print(f"\n{kind}, method {chosen.method}, seed {chosen.seed}: {summary(outcomes)}")
            print(
                "\n".join(table(outcomes, "axis and sensors", lambda c: f"{c.axis} {','.join(c.measured)}"))
            )
            if kind == "damaged":
                print("\n".join(table(outcomes, "fault", lambda c: c.fault)))
            else:
                print("\n".join(table(outcomes, "rate", lambda c: f"{c.rate:6.0f} Hz")))
            if chosen.show:
                show(outcomes)


def show(outcomes: list[Outcome]) -> None:
    """One line for each result that is not both ok and right."""
    for o in outcomes:
        if o.is_wrong or o.status != "ok":
            c, (times, relative, name) = o.case, o.worst
            mark = "WRONG" if o.is_wrong else "right" if relative == 0 else "     "
            off = f"{name} {100 * relative:.0f} % at {times:.1f}" if name else ""
            print(
                f"{o.number:4d} {mark} {o.status:12} {c.axis[:6]} {','.join(c.measured):14} {c.rate:5.0f} {c.motion:9} "
                f"{c.mode_hz:4.0f} Hz {c.fault:22} {off:22} {o.message[:110]}"
            )


if __name__ == "__main__":
    main()
