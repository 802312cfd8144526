"""Coverage of printed 95 % intervals with the default preparation, on machines drawn at random.

Eleven machines with 61 parameters, motions and noise are drawn as in `benchmarks.ok_promise`, whose simulator shares
no code with symid. Each log is identified many times with new noise of the same size and default settings. An interval
is 1.96 printed deviations to either side. For each parameter it prints the coverage, the mean error and the spread
between draws, in per cent of the truth, and the ratio of the printed deviation to the rms error, which is 1 for exact
deviations.

Usage: python -m benchmarks.intervals [--draws 60] [--seed 1] [--settings 0 1 ...]
"""

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import binom
from threadpoolctl import threadpool_limits

from benchmarks.options import parser_of
from benchmarks.promise.machines import Case, draw_machine, draw_noise, with_noise
from symid import Log, identify, load_generated
from symid.errors import SymidError

SETTINGS = (
    *(("rigid_1m", ("q",)),) * 3,
    ("direct_2m1s", ("q2",)),
    ("direct_2m1s", ("q2", "ddq1")),
    ("direct_2m1s", ("q2", "ddq2")),
    ("direct_2m1s", ("q2", "ddq1", "ddq2")),
    *(("ballscrew_2m1s", ("qm",)),) * 2,
    *(("ballscrew_2m1s", ("qm", "ql")),) * 2,
)
HALF = 1.96


@dataclass(frozen=True, eq=False)
class Setting:
    """Results of all draws of a setting: of each draw and parameter the error and the printed deviation."""

    case: Case
    errors: np.ndarray
    deviations: np.ndarray
    statuses: Counter[str]

    @property
    def coverage(self) -> np.ndarray:
        """Share of draws whose interval holds the truth, for each parameter."""
        return np.mean(np.abs(self.errors) <= HALF * self.deviations, axis=0)


def measured(number: int, seed: int, draws: int) -> Setting:
    """Draw a machine and its noise, then noise of that size again and again."""
    rng = np.random.default_rng([seed, number])
    axis, sensors = SETTINGS[number]
    case = draw_machine(axis, sensors, rng)
    noise = {name: draw_noise(case, name, rng) for name in case.signals}
    model, truth = load_generated(axis, sensors), np.array(list(case.truth.values()))
    errors, deviations, statuses = [], [], Counter()
    for _ in range(draws):
        signals = {name: with_noise(x, noise[name], rng) for name, x in case.signals.items()}
        try:
            found = identify(model, Log.from_arrays(signals, sampling_period=1 / case.rate))
        except SymidError:
            statuses["refused"] += 1
            continue
        statuses[found.status] += 1
        if found.physical_parameters:
            errors.append(np.array([found.physical_parameters[name] for name in case.truth]) - truth)
            places = [list(found.physical_parameters).index(name) for name in case.truth]
            deviations.append(found.physical_deviations[places])
    return Setting(replace(case, signals=signals), np.array(errors), np.array(deviations), statuses)


def print_setting(number: int, found: Setting) -> None:
    """A line of the setting, and one for each parameter."""
    case = found.case
    statuses = ", ".join(f"{status} {n}" for status, n in found.statuses.most_common())
    mode = f", mode {case.mode_hz:.0f} Hz" if case.mode_hz else ""
    print(
        f"\n{number}: {case.axis} {','.join(case.measured)}, {case.motion}, {case.rate} Hz{mode}: {statuses}"
    )
    percent = 100 / np.abs(list(case.truth.values()))
    mean, spread = percent * found.errors.mean(axis=0), percent * found.errors.std(axis=0)
    printed = percent * np.median(found.deviations, axis=0)
    for i, name in enumerate(case.truth):
        print(
            f"    {name:4} covered {100 * found.coverage[i]:5.1f} %   off by {mean[i]:+9.3g} %, "
            f"spread {spread[i]:8.3g} %, printed {printed[i]:8.3g} %, "
            f"printed / rms error {printed[i] / np.hypot(mean[i], spread[i]):6.2f}",
            flush=True,
        )


def summary(covered: np.ndarray, draws: int) -> str:
    """How many parameters are covered how often; of exact intervals, some are covered by all of few draws."""
    edges = (("below 85 %", 0.0, 0.85), ("in 85 to 90 %", 0.85, 0.9), ("in 90 to 99 %", 0.9, 0.99))
    counts = [f"{np.sum((covered >= low) & (covered < high))} {name}" for name, low, high in edges]
    by_chance = covered.size * binom.sf(np.ceil(0.99 * draws) - 1, draws, 0.95)
    return (
        f"covered {', '.join(counts)}, {np.sum(covered >= 0.99)} above ({by_chance:.0f} of exact intervals); "
        f"mean {100 * covered.mean():.1f} %"
    )


def main() -> None:
    parser = parser_of(__doc__, draws=60, seed=1)
    parser.add_argument("--settings", type=int, nargs="+", default=range(len(SETTINGS)))
    chosen = parser.parse_args()
    coverages = []
    with threadpool_limits(1):
        for number in chosen.settings:
            found = measured(number, chosen.seed, chosen.draws)
            print_setting(number, found)
            coverages.append(found.coverage)
    covered = np.concatenate(coverages)
    print(
        f"\n{covered.size} parameters, {chosen.draws} draws each, seed {chosen.seed}: {summary(covered, chosen.draws)}"
    )


if __name__ == "__main__":
    main()
