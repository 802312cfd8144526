"""Designed references: the deviations that `symid excite` expects, and those of repeated identifications.

Usage: python -m benchmarks.excitation [--method iv] [--runs N] [AXIS ...]

For each axis it prints the largest relative deviations of the designed and of the default references, within 0.4 m,
1 m/s, 8 m/s^2 and 20 kN in 10 s at 4 kHz with noise of 0.1 um and 1 N. For each parameter it prints the standard
deviation and the rms error of identifications of simulated logs with other noise along the designed reference, relative
to the expected deviation.
"""

from __future__ import annotations

import argparse
from typing import Literal

import numpy as np

from symid.axis import load_axis
from symid.codegen import model_of
from symid.excitation import Expectation, IdentificationTrial, design
from symid.simulation import Limits, plant_of, simulate, tuned_cascade

VALUES = {
    "rigid_1m": {"M": 100.0, "Fv": 80.0, "Fs": 40.0},
    "direct_2m1s": {"Ms": 1700.0, "Fvs": 24000.0, "Ks": 1.3e8, "Mm": 460.0, "Fvm": 104.0, "Fsm": 98.0},
}
LIMITS, FORCE = Limits((-0.2, 0.2), speed=1.0, acceleration=8.0), 20e3
SECONDS, RATE = 10.0, 4000.0


def experiment_of(name: str, method: Literal["wls", "iv"]) -> IdentificationTrial:
    """An axis with noise of its force and of the position that is controlled."""
    axis, values = load_axis(name), VALUES[name]
    axis = axis.with_signal(axis.controlled, noise=1e-7).with_signal(axis.drive.signal, noise=1.0)
    controller = tuned_cascade(plant_of(axis, values), axis.controlled, 20.0)
    return IdentificationTrial(axis, model_of(name), values, controller, LIMITS, FORCE, method=method)


def spread(
    experiment: IdentificationTrial,
    best: Expectation,
    found: dict[int, tuple[dict[str, float], dict[str, float]]],
) -> None:
    """Print spread, bias and rms error of estimates over what is expected; the last with systematic errors."""
    for name, truth in experiment.parameters.items():
        values = np.array([one[0][name] for one in found.values()])
        error = np.sqrt(np.mean((values - truth) ** 2))
        expected = np.sqrt(np.mean([one[1][name] ** 2 for one in found.values()]))
        ratio, bias = values.std(ddof=1) / expected, (values.mean() - truth) / expected
        told = f"spread {ratio:.2f} of the expected deviation, mean {bias:+.2f} of it off the truth"
        print(
            f"  {name:>4}: {told}; rms error {error / (best.relative[name] * abs(truth)):.2f} of the expected one"
        )


def main(names: list[str], method: Literal["wls", "iv"], runs: int) -> None:
    """Print both for each axis."""
    for name in names:
        experiment = experiment_of(name, method)
        best = design(experiment, SECONDS, RATE)
        others = ", ".join(f"{kind} {one.worst:.3%}" for kind, one in best.defaults.items() if one)
        print(f"{name}: designed {best.best.worst:.3%}, {others}: {best.best.trajectory.name}", flush=True)
        found = {}
        for seed in range(100, 100 + runs):
            paths = best.best.references
            run = simulate(experiment.axis, experiment.parameters, paths, experiment.controller, seed=seed)
            if one := experiment.identified(run):
                found[seed] = one
        spread(experiment, best.best, found)
        own = [
            found[seed][1][key] / best.best.deviations[key] for seed in found for key in experiment.parameters
        ]
        print(f"  deviations of {len(found)} runs over that of the design: {min(own):.2f} to {max(own):.2f}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("axes", nargs="*", default=list(VALUES))
    parser.add_argument("--method", choices=["wls", "iv"], default="wls")
    parser.add_argument("--runs", type=int, default=40)
    options = parser.parse_args()
    main(options.axes, options.method, options.runs)
