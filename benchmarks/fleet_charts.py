"""False alarms, detections and coverage of spreads and control charts, on drawn runs of known truth.

For several numbers of runs, with and without a variance between runs, it prints how often an axis of seven constant
parameters is reported to differ; how often a chart without change shows one; how often a step (to within one run) or a
drift is found; and the coverage of the 95 % intervals of place and size. Sizes are in standard deviations of one run;
the stated deviations of the runs differ up to threefold.

Usage: python -m benchmarks.fleet_charts [--draws 300]
"""

from dataclasses import dataclass

import numpy as np

from benchmarks.options import parser_of
from symid.fleet import TrendChange
from symid.fleet.control_chart import control_chart
from symid.fleet.spread import judge_spread, spread_between

FloatArray = np.ndarray


def drawn(runs: int, between: float, seed: int) -> tuple[FloatArray, FloatArray]:
    """Values about 100 and promised deviations about 1."""
    draw = np.random.default_rng([runs, seed])
    s = draw.uniform(0.5, 1.5, runs)
    return 100 + draw.normal(0, np.hypot(s, between)), s


def false_differences(runs: int, draws: int) -> float:
    """Share of axes of seven parameters, all the same from run to run, that are said to differ."""
    count = 0
    for k in range(draws):
        series = [drawn(runs, 0.0, 7 * k + i) for i in range(7)]
        count += judge_spread({str(i): spread_between(*one) for i, one in enumerate(series)}).differs
    return count / draws


def false_changes(runs: int, between: float, draws: int) -> float:
    """Share of charts without change that show one."""
    return sum(bool(control_chart(*drawn(runs, between, k)).changes) for k in range(draws)) / draws


@dataclass(frozen=True)
class Detection:
    """Shares: change found alone; of these, run of the step right to one, intervals of place and size that hold."""

    found: float
    near: float
    placed: float
    sized: float


def detection(kind: str, runs: int, size: float, draws: int, between: float = 2.0) -> Detection:
    """How a step two thirds into the series, or a drift over all of it, is found."""
    sigma, at = np.hypot(1.0, between), 2 * runs // 3
    shape = np.linspace(0, 1, runs) if kind == "drift" else np.arange(runs) >= at
    hits: list[TrendChange] = []
    for k in range(draws):
        x, s = drawn(runs, between, k)
        changes = control_chart(x + size * sigma * shape, s).changes
        hits += changes if [change.kind for change in changes] == [kind] else ()
    total = max(len(hits), 1)
    whole = kind == "drift"
    return Detection(
        found=len(hits) / draws,
        near=sum(whole or abs(change.log - at) <= 1 for change in hits) / total,
        placed=sum(whole or change.earliest < at <= change.latest for change in hits) / total,
        sized=sum(change.interval[0] < size * sigma < change.interval[1] for change in hits) / total,
    )


def main() -> None:
    draws = parser_of(__doc__, draws=300).parse_args().draws
    print("nothing differs, nothing changes: false alarms in percent\n")
    print("runs   axis differs   chart changes   chart changes, between runs three times the promise")
    for runs in (8, 20, 60, 200):
        shares = (
            false_differences(runs, draws),
            false_changes(runs, 0.0, draws),
            false_changes(runs, 3.0, draws),
        )
        print(f"{runs:4d}   {100 * shares[0]:12.1f}   {100 * shares[1]:13.1f}   {100 * shares[2]:13.1f}")
    print("\nchanges, between runs twice the promise: percent\n")
    print("change   runs   size   found alone   run to one   place held   size held")
    for kind, runs, size in (
        ("step", 20, 4.0),
        ("step", 20, 3.0),
        ("step", 60, 3.0),
        ("step", 60, 2.0),
        ("step", 200, 1.5),
        ("drift", 20, 6.0),
        ("drift", 60, 5.0),
        ("drift", 200, 4.0),
    ):
        got = detection(kind, runs, size, draws)
        print(
            f"{kind:6}   {runs:4d}   {size:4.1f}   {100 * got.found:11.0f}   {100 * got.near:10.0f}   "
            f"{100 * got.placed:10.0f}   {100 * got.sized:9.0f}"
        )


if __name__ == "__main__":
    main()
