"""Time of the generated `regressor` relative to copying an array of the same size and layout, aim 1.5.

Usage: python -m benchmarks.regressor [--samples 10000000] [--repetitions 9]
"""

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import symid
from benchmarks.options import parser_of

CASES = (("direct_2m1s", ("q2",)), ("direct_2m1s", ("q2", "ddq1")), ("emps", ("q",)))
AIM = 1.5
FloatArray = NDArray[np.float64]


def seconds(work: Callable[[], FloatArray]) -> float:
    """Time of one call; what it returns is freed outside the clock."""
    start = time.perf_counter()
    result = work()
    elapsed = time.perf_counter() - start
    del result
    return elapsed


def ratios(axis: str, measured: tuple[str, ...], samples: int, repetitions: int) -> FloatArray:
    """Seconds of the regressor and of the copy, alternating, shape (repetitions, 2)."""
    model, rng = symid.load_generated(axis, measured), np.random.default_rng(20261121)
    signals = [rng.standard_normal(samples) for _ in model.signals]
    stored = model.regressor(*signals).transpose(0, 2, 1)  # as it lies in memory: each column contiguous
    return np.array(
        [(seconds(lambda: model.regressor(*signals)), seconds(stored.copy)) for _ in range(repetitions)]
    )


def main() -> None:
    options = parser_of(__doc__, samples=10_000_000, repetitions=9).parse_args()
    print(f"{options.samples} samples, median of {options.repetitions} alternating repetitions")
    print(f"{'axis':14}{'measured':14}{'regressor ms':>13}{'copy ms':>9}{'ratio':>7}   aim {AIM:g}")
    for axis, measured in CASES:
        times = ratios(axis, measured, options.samples, options.repetitions)
        ours, copy = 1000.0 * np.median(times, axis=0)
        ratio = float(np.median(times[:, 0] / times[:, 1]))
        verdict = "met" if ratio <= AIM else "MISSED"
        print(f"{axis:14}{', '.join(measured):14}{ours:13.1f}{copy:9.1f}{ratio:7.2f}   {verdict}")


if __name__ == "__main__":
    main()
