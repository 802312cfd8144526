"""How often an experiment distinguishes two causes, and the expected probability: python -m benchmarks.next_experiment

A rigid axis under a controller, its force late by a delay; the diagnosis finds the delay, a first-order lag is the
strongest rival. Experiments of growing size are simulated with either cause and other noise each time; both causes are
fitted to the readings, and the one with the smaller error is chosen.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.options import parser_of
from symid import Axis, load_axis
from symid.diagnosis import Diagnosis, diagnose
from symid.diagnosis.experiment.design import rivals_of
from symid.diagnosis.experiment.discrimination import Rivals
from symid.diagnosis.experiment.simulated import simulated_experiment
from symid.diagnosis.fitting.applied import applied
from symid.diagnosis.fitting.gauss_newton import fitted
from symid.diagnosis.prediction.record import Record
from symid.simulation import Trajectory, multisine, plant_of, simulate, trapezoids, tuned_cascade

SIZES = (0.005, 0.01, 0.015, 0.02)
"""Accelerations of the multisine, m/s^2."""
_ITERATIONS = 10


@dataclass(frozen=True)
class Row:
    """An experiment, the probability expected, and how often the right cause was chosen."""

    name: str
    expected: float
    right: int
    runs: int

    @property
    def share(self) -> float:
        """Of the runs in which the right cause was chosen."""
        return self.right / self.runs


def rivals(declared: Axis | None = None) -> tuple[Diagnosis, Rivals]:
    """A diagnosis that finds a delay, and the delay with its strongest rival; by the rigid axis, or another one."""
    axis, values = load_axis("rigid_1m"), {"M": 100.0, "Fv": 120.0, "Fs": 30.0}
    late = axis.with_signal("q", noise=2e-9, delay=1e-3).with_signal("F", noise=2.0)
    path = trapezoids([0.1, 0.06], [0.15, 0.2], acceleration=2.0, jerk=20.0, sampling_period=1e-3)
    log = simulate(late, values, path, tuned_cascade(plant_of(axis, values), "q")).log
    found = diagnose(declared or axis, log)
    pair = rivals_of(found)
    assert pair is not None
    return found, pair


def experiment(size: float) -> Trajectory:
    """A multisine of 3 to 60 Hz on a slow move, so that friction is the same throughout."""
    lines = np.arange(3.0, 60.0)
    shaking = multisine(
        lines, size, sampling_period=1e-3, quantity="acceleration", seconds=2.0, fade=0.3, centre=0.0
    )
    moves = trapezoids([0.12], [0.05], acceleration=0.5, jerk=10.0, sampling_period=1e-3)
    n = min(shaking.n_samples, moves.n_samples)
    parts = (
        getattr(moves, kind)[:n] + getattr(shaking, kind)[:n]
        for kind in ("position", "velocity", "acceleration")
    )
    return Trajectory(*parts, 1e-3, f"multisine of {size:g} m/s^2")


def chosen(pair: Rivals, record: Record, right: int) -> int:
    """The cause that errs less on a record, fitted from its own values and from those of the cause simulated."""
    truth, weighting = applied(pair.models[right], record)
    errors = []
    for model in pair.models:
        starts = (applied(model, record)[0], applied(truth, record, placed=model.placed)[0])
        fits = (fitted(start.weighted(weighting), weighting, _ITERATIONS) for start in starts)
        errors.append(min(fit.cost for fit in fits))
    return int(np.argmin(errors))


def rows(pair: Rivals, sizes: tuple[float, ...], runs: int) -> Iterator[Row]:
    """Experiments of several sizes, each performed with either cause in a number of runs."""
    for size in sizes:
        path, right, expected = experiment(size), 0, []
        for seed in range(runs):
            run = simulated_experiment(pair, path, seed)
            expected.append(np.mean([found.probability for found in run.separations]))
            right += sum(chosen(pair, record, i) == i for i, record in enumerate(run.records))
        yield Row(path.name, float(np.mean(expected)), right, 2 * runs)


def main() -> None:
    runs = parser_of(__doc__, runs=50).parse_args().runs
    _, pair = rivals()
    print(f"{' against '.join(effect for effect, _ in pair.keys)}, {2 * runs} runs each")
    for row in rows(pair, SIZES, runs):
        expected, share = 100 * row.expected, 100 * row.share
        print(f"{row.name:24} {expected:5.1f} % expected, {share:5.1f} % right", flush=True)


if __name__ == "__main__":
    main()
