"""Distinction of a constant delay from a drifting clock, on trapezoids with a late force and with drifting clocks.

Three axes with values drawn at random follow the default trapezoids of `symid simulate`, fast ones first, or others, at
1 to 8 kHz; every first, second or fourth sample is logged, with white noise. The force is late by 0 to 15 samples, and
with `--drift` its clock gains or loses about that number of samples over the log. It prints how often a drift is
reported, and how often a log whose clock drifts by more than half a sample is ok.

Usage: python -m benchmarks.clocks [--logs 200] [--seed 1] [--drift SAMPLES]
"""

from collections import Counter
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks import tuning_grid
from benchmarks.options import parser_of
from symid import Log, identify, load_axis, load_generated
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

VALUES = tuning_grid.VALUES | {"rigid_1m": {"M": 109.0, "Fv": 230.0, "Fs": 23.0}}
AXES = (("rigid_1m", "q", "F"), ("direct_2m1s", "q2", "Fm"), ("ballscrew_2m1s", "qm", "Fm"))
NOTICED = 0.5
"""Samples of drift that should be named."""


@dataclass(frozen=True, eq=False)
class Case:
    """A log, its axis and sensor, and the samples by which its force is late at the middle and drifts."""

    axis: str
    measured: str
    log: Log
    late: float
    drift: float


def drawn(rng: np.random.Generator, drift: float) -> Case:
    """A random case; `drift` is the mean size of the drift in samples of the controller."""
    axis, measured, force = AXES[rng.integers(len(AXES))]
    values = {name: x * np.exp(0.3 * rng.standard_normal()) for name, x in VALUES[axis].items()}
    speed, rate, distance, acceleration, jerk = 0.5, 8000.0, 0.2, 5.0, 500.0  # the defaults of the command
    if rng.random() < 0.4:
        speed, rate, distance = (
            rng.uniform(0.2, 0.8),
            rng.choice([1000.0, 2000.0, 4000.0]),
            rng.uniform(0.1, 0.5),
        )
        acceleration, jerk = rng.uniform(2, 10), rng.uniform(200, 2000)
    path = trapezoids(
        [distance], [speed, speed / 2, speed / 5], acceleration=acceleration, jerk=jerk, dwell=0.2,
        sampling_period=1 / rate,
    )  # fmt: skip
    loaded = load_axis(axis)
    log = simulate(loaded, values, path, tuned_cascade(plant_of(loaded, values), measured)).log
    late = rng.choice([0.0, 0.5, 1.0, 2.0, 5.0, 10.0]) * rng.uniform(0.5, 1.5)
    grown = drift * np.exp(rng.uniform(-0.7, 0.7)) * rng.choice([-1, 1])
    t = np.arange(log.n_samples)
    F = np.interp(t - late - grown * (t / t.size - 0.5), t, log[force])
    F += 10 ** rng.uniform(-4, -2) * np.std(F) * rng.standard_normal(t.size)
    q = log[measured] + 10 ** rng.uniform(-8.5, -6.5) * rng.standard_normal(t.size)
    each = int(rng.choice([1, 2, 4]))
    kept = Log.from_arrays({measured: q[::each], force: F[::each]}, sampling_period=each / rate)
    return Case(axis, measured, kept, late / each, grown / each)


def main() -> None:
    chosen = parser_of(__doc__, logs=200, seed=1, drift=0.0).parse_args()
    statuses: Counter[str] = Counter()
    named = noticed = unnamed_ok = 0
    with threadpool_limits(1):
        for i in range(chosen.logs):
            case = drawn(np.random.default_rng([chosen.seed, i]), chosen.drift)
            found = identify(load_generated(case.axis, (case.measured,)), case.log)
            says = "drifts by" in found.message or "another rate" in found.message
            large = abs(case.drift) > NOTICED
            statuses[found.status] += 1
            named, noticed = named + says, noticed + (says and large)
            unnamed_ok += large and found.status == "ok"
            if says != large:
                print(f"{i:4d} {case.axis:15} late {case.late:5.2f}, drift {case.drift:5.2f}: {found.status}")
    print(
        f"{chosen.logs} logs, drift {chosen.drift:g}: a drift named in {named}, in {noticed} of those that drift by "
        f"more than {NOTICED:g} samples, of which {unnamed_ok} are ok; "
        + ", ".join(f"{status} {n}" for status, n in statuses.most_common())
    )


if __name__ == "__main__":
    main()
