"""Diagnoses from logs that a recorder has changed: python -m benchmarks.diagnosis.recorders

Machines of `benchmarks.diagnosis.machines` with one clear effect, or none, whose logs a recorder then changes: samples
lost, channels that are slower than the log, late or filtered, few digits. Right is the effect named first or in a
stated tie, or after the lateness that the recorder made; without an effect nothing but that lateness. Names of a
probability of at least a half that are neither the effect nor the recorder's lateness are counted as false.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import count, islice

import numpy as np
import scipy.signal

from benchmarks.diagnosis.machines import Case, drawn, false_effects, names, names_of, sizes, sought
from benchmarks.options import parser_of
from symid import Log
from symid.arrays import FloatArray
from symid.diagnosis import diagnose

_SLOW, _LATE, _STEPS = 4, 3, 1500
_LAG, _FORCE_LAG = 1 / 10, 1 / 20
"""Cutoff frequencies of first-order filters, as parts of the sampling frequency."""
_LATENESS = {"delay", "actuator_lag"}


@dataclass(frozen=True)
class Recorder:
    """Changes of a recorder to the channels of a log."""

    # a channel from a channel and the samples that are lost
    change: Callable[[FloatArray, FloatArray], FloatArray]
    # of_force, of_positions: what it is done to
    of_force: bool = True
    of_positions: bool = True
    late: bool = False  # whether force and positions no longer belong together

    def log(self, log: Log) -> Log:
        """The log recorded."""
        lost = np.random.default_rng(5).random(log.n_samples)
        signals = dict(log.signals)
        for name, x in log.signals.items():
            if name != "reference" and (self.of_force if name == "F" else self.of_positions):
                signals[name] = self.change(x, lost)
        return Log.from_arrays(signals, sampling_period=log.sampling_period)


def updated_slowly(x: FloatArray, spacing: int, *, held: bool) -> FloatArray:
    """A signal that is read at one of some samples, and held or interpolated at the others."""
    at = np.arange(x.size)
    return x[at // spacing * spacing] if held else np.interp(at, at[::spacing], x[::spacing])


def low_passed(x: FloatArray, cutoff: float) -> FloatArray:
    """A signal behind a first-order filter; `cutoff` relative to the sampling frequency."""
    pole = np.exp(-2 * np.pi * cutoff)
    return np.asarray(scipy.signal.lfilter([1 - pole], [1, -pole], x, zi=[x[0] * pole])[0])


def _shifted(x: FloatArray, lost: FloatArray) -> FloatArray:
    return np.concatenate([np.full(_LATE, x[0]), x[:-_LATE]])


def _coarse(x: FloatArray, lost: FloatArray) -> FloatArray:
    step = float(np.ptp(x)) / _STEPS
    return np.asarray(np.round(x / step) * step)


def _repeated(x: FloatArray, lost: FloatArray) -> FloatArray:
    return x[np.maximum.accumulate(np.where(lost < 0.03, 0, np.arange(x.size)))]


RECORDERS = {
    "sound": Recorder(lambda x, lost: x),
    "0.5 % of rows 0": Recorder(lambda x, lost: np.where(lost < 0.005, 0.0, x)),
    "3 % of rows repeated": Recorder(_repeated),
    "slow position": Recorder(lambda x, lost: updated_slowly(x, _SLOW, held=True), of_force=False),
    "all interpolated": Recorder(lambda x, lost: updated_slowly(x, _SLOW, held=False)),
    "coarse position": Recorder(_coarse, of_force=False),
    "late position": Recorder(_shifted, of_force=False, late=True),
    "filtered position": Recorder(lambda x, lost: low_passed(x, _LAG), of_force=False, late=True),
    "filtered force": Recorder(lambda x, lost: low_passed(x, _FORCE_LAG), of_positions=False, late=True),
}
"""Of what is done: 4 samples for one, 3 samples late, 1500 steps in the travel, filters of first order."""


def outcome(case: Case, recorder: Recorder, wanted: tuple[str, ...]) -> tuple[bool, int, str]:
    """Whether a diagnosis of what was recorded is right, effects named that are not there, and what it says."""
    logs = [recorder.log(log) for log in case.logs]
    found = diagnose(case.machine.axis, logs[0], validation=logs[1], nominal=case.nominal)
    others = [one for one in found.effects if not (recorder.late and _LATENESS & names(one))]
    false = false_effects(others, case.effects)
    right = bool(names(others[0]).intersection(wanted)) if others and wanted else not (others or wanted)
    return right, len(false), f"{found.verdict:11} {names_of(found.effects)}"


def clear_cases(first: int) -> Iterator[tuple[int, Case, tuple[str, ...]]]:
    """Seeds, cases and effects wanted, from a seed on: a clear effect, or none."""
    for seed in count(first):
        if (case := drawn(seed)) is not None:
            least, *alone = sizes(case)
            if (wanted := sought(case, least, alone)) or not case.effects:
                yield seed, case, wanted


def main() -> None:
    given = parser_of(__doc__, seed=1, cases=15).parse_args()
    sums: dict[str, list[tuple[bool, int]]] = {name: [] for name in RECORDERS}
    for seed, case, wanted in islice(clear_cases(given.seed), given.cases):
        print(f"{seed} {case.machine.kind}, {', '.join(wanted) or 'no effect'}", flush=True)
        for name, recorder in RECORDERS.items():
            right, false, line = outcome(case, recorder, wanted)
            sums[name].append((right, false))
            print(f"    {name:20} {line} {'' if right else 'WRONG'} {'FALSE' if false else ''}", flush=True)
    for name, found in sums.items():
        rights, false = sum(r for r, _ in found), sum(f for _, f in found)
        print(f"{name}: {rights} of {len(found)} right, {false} named that are not there")


if __name__ == "__main__":
    main()
