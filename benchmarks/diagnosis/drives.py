"""Machines of `benchmarks.diagnosis.others` as drives record them: python -m benchmarks.diagnosis.drives

A third of the logs hold the speed that a drive computes from the counts of its encoder in place of the position, or a
position that is updated, or interpolated, every second to fifth sample. Half of the currents pass a first-order filter,
half are rounded to a hundredth of their range. Nominal values are 15 to 50 % off. The model lacks one law of the
machine, both its Coulomb and its viscous friction, or nothing. Cases are judged as those of `others` are: the law
lacking is to be named first, or tied, or after the lateness that the recorder made.
"""

from dataclasses import replace

import numpy as np

from benchmarks.diagnosis.other_cases import Case
from benchmarks.diagnosis.others import Row, judged, print_cases
from benchmarks.diagnosis.recorders import low_passed, updated_slowly
from symid import Axis, CoulombFriction, Log, Position, Velocity, ViscousFriction

_FEWEST = 400
"""Fewest samples of a slow position."""
_SPEED_FILTER = 10
"""Cutoff frequency of the filter of a speed, as a part of the sampling frequency."""


def recorded(case: Case, seed: int) -> tuple[Case, set[str], set[str]]:
    """A case as a drive records it, further laws that its model lacks, and effects that stand for lateness."""
    rng = np.random.default_rng([seed, 7])
    speed, slow = bool(rng.random() < 1 / 3), bool(rng.random() < 1 / 3)
    spacing, held = int(rng.choice([2, 4, 5])), bool(rng.random() < 0.5)
    cutoff, rounded = float(rng.choice([0.05, 0.1])) * (rng.random() < 0.5), bool(rng.random() < 0.5)
    speed = speed and case.kind != "belt"
    slow = slow and not speed and all(log.n_samples > spacing * _FEWEST for log in case.logs)
    found = []
    for log in case.logs:
        signals = dict(log.signals)
        for name in signals.keys() - {"F"} if slow else ():
            signals[name] = updated_slowly(signals[name], spacing, held=held)
        if speed:
            signals["q"] = low_passed(np.diff(signals["q"], prepend=signals["q"][0]), 1 / _SPEED_FILTER)
            signals["q"] /= log.sampling_period
        if cutoff:
            signals["F"] = low_passed(signals["F"], cutoff)
        if rounded:
            step = 0.01 * float(np.ptp(signals["F"]))
            signals["F"] = np.round(signals["F"] / step) * step
        found.append(Log.from_arrays(signals, sampling_period=log.sampling_period))
    late = {"delay", "actuator_lag"} if speed or cutoff else set()
    complete, model = (_reading_speed(axis) if speed else axis for axis in (case.complete, case.model))
    lacking = set()
    if case.lacks in ("Fs", "Fv") and rng.random() < 0.5:
        frictions = [own for own in model.laws if isinstance(own, CoulombFriction | ViscousFriction)]
        model = model.without(*(own for own in frictions if own.at == model.bodies[0]))
        lacking = {"coulomb_friction", "viscous_friction"}
    there = tuple({*case.there, *late, *lacking})
    nominal = {
        name: x * float(np.exp(rng.choice([-1, 1]) * rng.uniform(0.14, 0.4)))
        for name, x in case.nominal.items()
    }
    return (
        replace(case, there=there, logs=tuple(found), complete=complete, model=model, nominal=nominal),
        lacking,
        late,
    )


def _reading_speed(axis: Axis) -> Axis:
    sensors = (Velocity(s.signal, s.body) if isinstance(s, Position) else s for s in axis.sensors)
    return replace(axis, sensors=tuple(sensors))


def main() -> None:
    print_cases(__doc__, _judged_as_recorded)


def _judged_as_recorded(case: Case, seed: int) -> Row:
    own, lacking, late = recorded(case, seed)
    return judged(own, seed, lacking, late)


if __name__ == "__main__":
    main()
