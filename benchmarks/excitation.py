"""Designed references: the deviations that `symid excite` expects, and those of repeated identifications.

Usage: python -m benchmarks.excitation [--method iv] [--runs N] [AXIS ...]

For each shipped axis it prints the largest relative deviations of the designed and of the default references within the
same limits and time. For each parameter it prints the rms error of identifications of simulated logs with other noise
along the designed reference, relative to the expected one, with its parts: spread and mean.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from benchmarks.options import parser_of
from symid.axis import load_axis
from symid.codegen import model_of
from symid.excitation import Expectation, IdentificationTrial, design
from symid.simulation import Limits, plant_of, simulate, tuned_cascade

FRESH = 10_000
"""First seed of the repeated identifications; the design uses lower ones."""


_SLIDE = Limits((-0.2, 0.2), speed=1.0, acceleration=8.0)


@dataclass(frozen=True)
class Machine:
    """Values, noise and limits of a shipped axis; all SI."""

    values: Mapping[str, float]
    noise: Mapping[str, float]
    sensors: tuple[str, ...] | None = None  # the first one if not given
    limits: Limits = _SLIDE
    force: float = 20e3
    rate: float = 4000.0
    bandwidth: float = 20.0
    seconds: float = 10.0

    def trial(self, name: str, method: Literal["wls", "iv"]) -> IdentificationTrial:
        """The axis with the noise of its signals under a controller."""
        axis = load_axis(name)
        for signal, deviation in self.noise.items():
            axis = axis.with_signal(signal, noise=deviation)
        controller = tuned_cascade(plant_of(axis, self.values), axis.controlled, self.bandwidth)
        model = model_of(name, self.sensors)
        return IdentificationTrial(
            axis, model, self.values, controller, self.limits, self.force, method=method
        )


_STRUCTURE = {"Ms": 1700.0, "Fvs": 24000.0, "Ks": 1.3e8, "Mm": 460.0, "Fvm": 104.0, "Fsm": 98.0}
_EMPS = Machine(
    {"M": 95.0, "Fv": 203.0, "Fc": 20.0, "OF": -3.2},
    {"q": 1e-7, "F": 1.0},
    limits=Limits((-0.1, 0.1), speed=0.2, acceleration=1.5),
    force=300.0,
    rate=1000.0,
    bandwidth=10.0,
)
MACHINES = {
    "rigid_1m": Machine({"M": 100.0, "Fv": 80.0, "Fs": 40.0}, {"q": 1e-7, "F": 1.0}),
    "direct_2m1s": Machine(_STRUCTURE, {"q2": 1e-7, "Fm": 1.0}),
    "direct_3m2s": Machine(
        {**_STRUCTURE, "Ml": 120.0, "Kl": 2.4e7, "Fl": 900.0},
        {"q2": 1e-7, "ddq1": 1e-3, "ddql": 1e-3, "Fm": 1.0},
        ("q2", "ddq1", "ddql"),
    ),
    "ballscrew_2m1s": Machine(
        {"Mm": 80.0, "Fvm": 120.0, "Fsm": 50.0, "Kt": 6e6, "Ft": 700.0, "Ml": 200.0, "Fvl": 150.0},
        {"qm": 1e-7, "ql": 1e-7, "Fm": 1.0},
        ("qm", "ql"),
    ),
    "emps": _EMPS,
    "emps_asymmetric": replace(
        _EMPS, values={"M": 95.0, "Fvp": 166.0, "Fcp": 20.0, "Fvn": 240.0, "Fcn": 21.0}
    ),
    "motor_bench": Machine(
        {"Jm": 0.0049, "Fvm": 0.02, "Kt": 555.0, "Ft": 0.09, "Pt": 0.0, "Jl": 0.0049, "Fvl": 0.1},
        {"qm": 1e-5, "ql": 1e-5, "iq": 0.01},
        ("qm", "ql"),
        limits=Limits((-10.0, 10.0), speed=50.0, acceleration=1000.0),
        force=20.0,
    ),
}


def lines_of_repeated(trial: IdentificationTrial, expected: Expectation, runs: int) -> list[str]:
    """Lines on identifications of runs with other noise along the same reference."""
    logs = (
        simulate(trial.axis, trial.parameters, expected.references, trial.controller, seed=FRESH + i)
        for i in range(runs)
    )
    found = [one[0] for log in logs if (one := trial.identified(log))]
    lines = [f"  {len(found)} of {runs} identifications are ok; of their errors, over the expected one:"]
    for name, size in expected.relative.items():
        truth = trial.parameters[name]
        errors = np.array([(values[name] - truth) / abs(truth) for values in found]) / size
        rms, spread = np.sqrt(np.mean(errors**2)), errors.std(ddof=1)
        lines.append(
            f"  {name:>4}: rms {rms:.2f} (spread {spread:.2f}, mean {errors.mean():+.2f}) of {size:.3%}"
        )
    return lines


def main(names: list[str], method: Literal["wls", "iv"], runs: int) -> None:
    for name in names:
        machine = MACHINES[name]
        trial = machine.trial(name, method)
        found = design(trial, machine.seconds, machine.rate)
        others = ", ".join(
            f"{kind} {one.worst:.3%}" if one else f"{kind} not determined"
            for kind, one in found.defaults.items()
        )
        print(f"{name}: designed {found.best.worst:.3%}, {others}: {found.best.trajectory.name}")
        print("\n".join(lines_of_repeated(trial, found.best, runs)), flush=True)


if __name__ == "__main__":
    parser = parser_of(__doc__, runs=40)
    parser.add_argument("axes", nargs="*", default=list(MACHINES), metavar="AXIS", help=", ".join(MACHINES))
    parser.add_argument("--method", choices=["wls", "iv"], default="wls")
    options = parser.parse_args()
    main(options.axes, options.method, options.runs)
