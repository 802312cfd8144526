"""Comparison of models on held-out data, which took no part in the fits and the selection."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symid.arrays import BoolArray, ComplexArray, FloatArray
from symid.diagnosis.findings.gap import Level, Removed
from symid.diagnosis.findings.shares import removed_share, surely_decreases
from symid.diagnosis.findings.strength import FixedBand
from symid.diagnosis.fitting.applied import applied, applied_or_none, errors_of, fitted_to_log
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.state import State
from symid.diagnosis.prediction.corners import SLOW, near_reversals
from symid.diagnosis.prediction.record import Record
from symid.diagnosis.prediction.weighting import Weighting
from symid.diagnosis.thresholds import THRESHOLDS
from symid.signal_processing import power_density

_REVERSAL = 0.02
"""Seconds around a reversal that do not count for the strength of an effect: the longest response of its band."""
ENOUGH = 60
"""Least number of rows; each half then shows the level of its errors to about 20 %."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """Errors of several models on one record, with the same weights.

    With several drives, levels, shares, signals and spectrum belong to one of them.
    """

    weighting: Weighting  # of the record
    # models, simplest first: nominal, re-identified, with the first effect, with the first two, ...
    states: tuple[State | None, ...]
    # shape (n_outputs, n_rows): their weighted errors, in multiples of the noise; nan where no row is kept
    errors: tuple[FloatArray | None, ...]
    drive: int = 0  # index of the drive whose force is compared

    @property
    def record(self) -> Record:
        """The log in the frequency domain on which the models are compared."""
        return self.weighting.record

    def with_effects(self, n: int) -> Comparison:
        """The nominal and the re-identified model, and those with one to `n` effects."""
        return replace(self, states=self.states[: 2 + n], errors=self.errors[: 2 + n])

    def fitted_to_log(self) -> Comparison:
        """The comparison with phases and moments of its models fitted to this log, as in the errors."""
        own = (None if state is None else fitted_to_log(state, self.weighting) for state in self.states)
        return replace(self, states=tuple(own))

    @property
    def of_drives(self) -> tuple[Comparison, ...]:
        """The comparison for the force of each drive."""
        return tuple(replace(self, drive=drive) for drive in range(self.record.n_drives))

    @property
    def of_largest(self) -> Comparison:
        """The comparison for the force with the largest error of the re-identified model, in multiples of the floor."""
        return max(self.of_drives, key=lambda own: own.excess(1, own.drive) / own.floor**2)

    @property
    def motion(self) -> ComplexArray:
        """Spectrum of the position next to the drive."""
        return np.asarray(self.record.motions[self.drive])

    @property
    def measured(self) -> ComplexArray:
        """Spectrum of the force of the drive."""
        return np.asarray(self.record.measured[self.drive])

    @property
    def validated(self) -> int:
        """Number of effects that lower the error on these data; further ones do not surely lower it."""
        errors = [self._relative_error(model) for model in range(1, len(self.states))]
        held = [n for n in range(1, len(errors)) if errors[n] <= THRESHOLDS.falls * min(errors[:n])]
        last = max(held, default=0)
        while last > 1 and not self._surely_better(last + 1):
            last -= 1
        return last

    def _surely_better(self, model: int) -> bool:
        """Whether a model surely has a smaller error than the one before, by the least of a further effect."""
        output = self.output_of(model)
        least = self.excess(model - 1, output) - THRESHOLDS.least_power * float(self.floors[output]) ** 2
        falls = self.excess(model, output) < least
        return falls and surely_decreases(self.squares(model - 1, output), self.squares(model, output))

    @property
    def relative_error(self) -> float:
        """Error with the effects that hold, relative to the re-identified model."""
        return self._relative_error(1 + self.validated)

    def _relative_error(self, model: int) -> float:
        """Rms error relative to the re-identified model, a geometric mean: outputs left with noise hide no gain."""
        outputs = range(len(self.weighting.density))
        shares = [np.mean(self.squares(model, o)) / np.mean(self.squares(1, o)) for o in outputs]
        return float(np.exp(np.mean(np.log(shares)) / 2))

    @cached_property
    def floors(self) -> FloatArray:
        """Weighted rms errors of the outputs that noise alone leaves with all effects in the model."""
        last = self.states[-1]
        if last is None:
            return np.ones(len(self.weighting.density))
        return np.asarray(np.sqrt(last.prediction.noise_through(self.weighting.density)))

    @property
    def floor(self) -> float:
        """Noise floor of the force."""
        return float(self.floors[self.drive])

    def excess(self, model: int, output: int) -> float:
        """Mean square of the weighted error of a model above the floor."""
        return max(float(np.mean(self.squares(model, output))) - float(self.floors[output]) ** 2, 0.0)

    def whole_excess(self, model: int) -> float:
        """Sum of the excess of all forces, in multiples of their floors."""
        return sum(self.excess(model, d) / float(self.floors[d]) ** 2 for d in range(self.record.n_drives))

    def removed(self, before: int, after: int) -> Removed:
        """Share of the re-identified model's excess removed from one model to another, with a 95 % interval.

        The excess is that of the force, or of a further reading if the effect is an error of this reading.
        """
        output = self.output_of(after)
        rows = np.stack([self.squares(i, output) for i in (1, before, after)])
        return removed_share(rows, float(self.floors[output]) ** 2)

    def output_of(self, model: int) -> int:
        """Output that shows the last effect of a model: the force, or a further reading.

        A further reading if the effect is an error of it, or if the effect lowers its excess and not that of the force:
        friction of the load in place of the motor's changes only the reading of the encoder at the load. With several
        forces, the one whose excess the effect lowers most.
        """
        state, outputs = self.states[model], self.record.outputs
        place = state.placed[-1].at if state is not None and state.placed else ""
        if place in outputs:
            return outputs.index(place)
        falls = [
            (self.excess(model - 1, i) - self.excess(model, i)) / float(self.floors[i]) ** 2
            for i in range(len(outputs))
        ]
        n_drives = self.record.n_drives
        drive, most = int(np.argmax(falls[:n_drives])), int(np.argmax(falls))
        return drive if falls[drive] > 0 or not falls[most] > 0 else most

    def showing(self, model: int) -> Comparison:
        """The comparison for the force that shows the last effect of a model."""
        output = self.output_of(model)
        return replace(self, drive=output) if output < self.record.n_drives else self

    def squares(self, model: int, output: int | None = None) -> FloatArray:
        """Squared weighted errors of a model in the kept rows, of the force or of a given output."""
        errors = self.errors[model]
        return (
            np.full(int(self.weighting.kept.sum()), np.nan)
            if errors is None
            else errors[self.drive if output is None else output, self.weighting.kept] ** 2
        )

    @cached_property
    def unit(self) -> float:
        """Force that corresponds to a weighted error of 1: the force noise in the band."""
        return float(1 / self.weighting.density[self.drive].max())

    @property
    def relative_density(self) -> FloatArray:
        """Weight of the force error relative to its maximum, of shape (n_bins,)."""
        return np.asarray(self.weighting.density[self.drive] / self.weighting.density[self.drive].max())

    @cached_property
    def size(self) -> float:
        """Root mean square of the measured force over the kept rows, with the same weights."""
        force = self.record.rows(self.measured * self.relative_density * self.record.taper)
        return float(np.sqrt(np.mean(force[self.weighting.kept] ** 2)))

    def level(self, model: int) -> Level:
        """Force error of a model."""
        return self.level_of(float(np.sqrt(np.mean(self.squares(model)))))

    def level_of(self, multiple: float) -> Level:
        """An error in multiples of the noise as a level of the force."""
        return Level(multiple * self.unit, multiple * self.unit / self.size)

    @property
    def unexplained_share(self) -> float:
        """Share of the re-identified model's excess that remains, see `removed`; nan if there is no excess."""
        felt = self.output_of(2) if len(self.states) > 2 else 0
        output = felt if felt >= self.record.n_drives else self.drive
        before, left = (self.excess(i, output) for i in (1, len(self.errors) - 1))
        least = THRESHOLDS.no_excess * float(self.floors[output]) ** 2
        return min(left / before, 1.0) if before > least else float("nan")

    @property
    def unexplained_of_all(self) -> float:
        """`unexplained_share` of all forces together, in multiples of their floors."""
        n_drives = self.record.n_drives
        felt = self.output_of(2) if len(self.states) > 2 else 0
        if n_drives == 1 or felt >= n_drives:
            return self.unexplained_share
        before, left = (self.whole_excess(i) for i in (1, len(self.errors) - 1))
        return min(left / before, 1.0) if before > n_drives * THRESHOLDS.no_excess else float("nan")

    @cached_property
    def turns(self) -> BoolArray:
        """Rows at which the driven joint turns or stands, of shape (n_rows,)."""
        record = self.record
        velocity = record.rows(1j * record.omega * self.motion)
        inside = record.rows_in_log
        slow = np.abs(velocity) < SLOW * np.abs(velocity[inside]).max(initial=0.0)
        turns = slow | (np.diff(np.signbit(velocity), prepend=np.signbit(velocity[0])) != 0)
        return np.asarray(turns & inside)

    @cached_property
    def in_fixed_band(self) -> FixedBand | None:
        """The model with all effects in a fixed band, away from reversals; None if a model failed."""
        base, last = self.states[1], self.states[-1]
        if base is None or last is None:
            return None
        away = ~near_reversals(self.turns, self.row_rate, _REVERSAL)[self.weighting.kept]
        if away.sum() < ENOUGH:  # an axis that does little but turn
            away = np.ones(away.size, dtype=bool)
        return FixedBand.of(last, self.weighting, away, len(base.placed))

    @property
    def strengths(self) -> FloatArray:
        """Strength of each effect beside the others, see `FixedBand`, shape (n_effects,); 0 if a model failed."""
        band = self.in_fixed_band
        return np.zeros(len(self.states) - 2) if band is None else band.strengths()

    def removed_in_any_model(self, model: int) -> Removed:
        """Share that the last effect of a model removes, see `removed`, with an interval for all models.

        The share depends on the weights of the frequencies and on the values, which absorb a part of the effects that
        are not in the model. The interval also holds the share in a fixed band with the values beside all others.
        """
        own, output, shares = self.removed(model - 1, model), self.output_of(model), []
        if len(self.states) > 3 and output < self.record.n_drives and self.in_fixed_band is not None:
            whole = self.removed(1, len(self.states) - 1).share
            shares.append(whole * float(self.in_fixed_band.removed(output)[model - 2]))
        return own.including(shares, THRESHOLDS.taken_over)

    @property
    def row_rate(self) -> float:
        """Rows per second of the log, Hz."""
        return self.record.n_rows / self.record.period

    @property
    def kept_share(self) -> float:
        """Share of the rows that are kept."""
        return max(float(self.weighting.kept.mean()), 1e-9)

    def power(self, model: int, segment: int) -> tuple[FloatArray, FloatArray]:
        """Frequencies, Hz, and power density of the weighted force error of a model, 0 where no row is kept."""
        errors = self.errors[model]
        rows = np.zeros(self.record.n_rows) if errors is None else np.nan_to_num(errors[self.drive])
        return power_density(rows, self.row_rate, min(segment, rows.size // 4))


def compared(
    record: Record, nominal: State | None, fits: Sequence[Fit], allowed: BoolArray | None
) -> Comparison:
    """Evaluate models on a validation record; only values that belong to a log, such as its initial state, are fitted.

    All errors have the weights of the first fit, the re-identified model. `allowed`, of shape (n_fine,), are the parts
    of the record that may be used.
    """
    base, weighting = applied(fits[0].state, record, allowed)
    models = [nominal, *(fit.state for fit in fits[1:])]
    states = [applied_or_none(model, record, allowed, weighting) for model in models]
    states.insert(1, base)
    errors = (None if state is None else errors_of(state, weighting) for state in states)
    return Comparison(weighting, tuple(states), tuple(errors))
