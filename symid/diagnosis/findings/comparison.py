"""Models compared on data that took no part in any choice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symid.arrays import BoolArray, ComplexArray, FloatArray
from symid.data.density import power_density
from symid.diagnosis.findings.gap import Gap, Level, NotRepeated, Removed, Reversal
from symid.diagnosis.findings.repetition import repetition
from symid.diagnosis.findings.shares import closed_fraction, closed_interval, removed_share
from symid.diagnosis.fitting.applied import applied, errors_of, fitted_to_log
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.state import State
from symid.diagnosis.prediction.record import Record
from symid.diagnosis.prediction.reversal import SLOW, near
from symid.diagnosis.prediction.weighting import Weighting
from symid.diagnosis.thresholds import THRESHOLDS

_UNEVEN = 2.0
_FEW = 8
_ENOUGH = 60
"""Rows of which either half shows the level of its errors to some 20 %."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """Errors of several models on one record, with the same weights.

    Of an axis with several drives, levels, shares, signals and spectrum are those of one of them.
    """

    weighting: Weighting  # of the record
    # models, simplest first: nominal, re-identified, with the first effect, the first two,
    states: tuple[State | None, ...]
    # shape (n_outputs, n_rows): their weighted errors, in multiples of the noise; nan where no row is kept
    errors: tuple[FloatArray | None, ...]
    drive: int = 0  # whose force is looked at

    @property
    def record(self) -> Record:
        """The log."""
        return self.weighting.record

    def with_effects(self, n: int) -> Comparison:
        """The nominal and the re-identified model, and those with one to `n` effects."""
        return replace(self, states=self.states[: 2 + n], errors=self.errors[: 2 + n])

    def fitted_to_log(self) -> Comparison:
        """The same models with the phases and moments of this log, which only their errors leave out so far."""
        own = (None if state is None else fitted_to_log(state, self.weighting) for state in self.states)
        return replace(self, states=tuple(own))

    @property
    def of_drives(self) -> tuple[Comparison, ...]:
        """The same for the force of each drive."""
        return tuple(replace(self, drive=drive) for drive in range(self.record.n_drives))

    @property
    def of_largest(self) -> Comparison:
        """The same for the force in which the re-identified model errs most, in multiples of the floor."""
        return max(self.of_drives, key=lambda own: own.excess(1, own.drive) / own.floor**2)

    @property
    def motion(self) -> ComplexArray:
        """Spectrum of the position next to the drive."""
        return np.asarray(self.record.motions[self.drive])

    @property
    def measured(self) -> ComplexArray:
        """Spectrum of its force."""
        return np.asarray(self.record.measured[self.drive])

    @property
    def upheld(self) -> int:
        """How many of the effects hold on these data: what follows makes the error grow, or may do so."""
        errors = [self._misfit(model) for model in range(1, len(self.states))]
        held = [n for n in range(1, len(errors)) if errors[n] <= THRESHOLDS.falls * min(errors[:n])]
        last = max(held, default=0)
        while last > 1 and not self.removed(last, last + 1).low > 0:
            last -= 1
        return last

    @property
    def worsened(self) -> int | None:
        """The first of several effects that clearly makes the error, or a hidden motion, grow on these data."""
        n_effects = len(self.states) - 2
        grows = (
            n for n in range(n_effects) if self.states[n + 2] is None or self.removed(n + 1, n + 2).high < 0
        )
        return next(grows, None) if n_effects > 1 else None

    @property
    def misfit(self) -> float:
        """That of the effects that hold, relative to the re-identified model."""
        return self._misfit(1 + self.upheld)

    def _misfit(self, model: int) -> float:
        """Root mean square of the errors of all outputs, each relative to that of the re-identified model."""
        outputs = range(len(self.weighting.density))
        shares = [np.mean(self.squares(model, o)) / np.mean(self.squares(1, o)) for o in outputs]
        return float(np.sqrt(np.mean(shares)))

    @cached_property
    def floors(self) -> FloatArray:
        """Weighted errors of the outputs that noise alone would leave of the model with all effects."""
        last = self.states[-1]
        if last is None:
            return np.ones(len(self.weighting.density))
        return np.asarray(np.sqrt(last.prediction.noise_through(self.weighting.density)))

    @property
    def floor(self) -> float:
        """That of the force."""
        return float(self.floors[self.drive])

    def excess(self, model: int, output: int) -> float:
        """Mean square of an error of a model above the floor, in the unit of the weights."""
        return max(float(np.mean(self.squares(model, output))) - float(self.floors[output]) ** 2, 0.0)

    def whole_excess(self, model: int) -> float:
        """Sum of the excess of all forces, in multiples of their floors."""
        return sum(self.excess(model, d) / float(self.floors[d]) ** 2 for d in range(self.record.n_drives))

    def removed(self, before: int, after: int) -> Removed:
        """Share of the re-identified model's excess that goes from one model to another, with a 95 % interval.

        It is that of the force, and that of a further reading for an error of this reading.
        """
        output = self._output_of(after)
        rows = np.stack([self.squares(i, output) for i in (1, before, after)])
        return removed_share(rows, float(self.floors[output]) ** 2)

    def _output_of(self, model: int) -> int:
        """Output in which the last effect of a model is felt: the force, except for errors of further readings.

        Of several forces, the one whose excess it lowers most.
        """
        state, outputs = self.states[model], self.record.outputs
        place = state.placed[-1].at if state is not None and state.placed else ""
        if place in outputs:
            return outputs.index(place)
        if len(self.record.forces) == 1:
            return 0
        return max(
            range(self.record.n_drives),
            key=lambda d: (self.excess(model - 1, d) - self.excess(model, d)) / self.floors[d] ** 2,
        )

    def felt_by(self, model: int) -> Comparison:
        """The same for the force in which the last effect of a model is felt."""
        output = self._output_of(model)
        return replace(self, drive=output) if output < self.record.n_drives else self

    def squares(self, model: int, output: int | None = None) -> FloatArray:
        """Squares of a weighted error in the kept rows: that of the force, or of any output."""
        errors = self.errors[model]
        return (
            np.full(int(self.weighting.kept.sum()), np.nan)
            if errors is None
            else errors[self.drive if output is None else output, self.weighting.kept] ** 2
        )

    @cached_property
    def unit(self) -> float:
        """Force that a weighted error of 1 stands for: the force noise in the band."""
        return float(1 / self.weighting.density[self.drive].max())

    @property
    def _relative_density(self) -> FloatArray:
        """Weight of the force error relative to that of force noise alone, of shape (n_bins,)."""
        density = self.weighting.density[self.drive]
        return np.asarray(density / density.max())

    @cached_property
    def size(self) -> float:
        """Root mean square of the measured force over the kept rows, with the same weights."""
        force = self.record.rows(self.measured * self._relative_density * self.record.taper)
        return float(np.sqrt(np.mean(force[self.weighting.kept] ** 2)))

    def level(self, model: int) -> Level:
        """Force error of a model."""
        return self._level(float(np.sqrt(np.mean(self.squares(model)))))

    def _level(self, multiple: float) -> Level:
        return Level(multiple * self.unit, multiple * self.unit / self.size)

    def gap(self) -> Gap:
        """The gap before and after."""
        axis, signal = self.record.dynamics.axis, self.record.forces[self.drive]
        re, explained = self.squares(1), self.squares(len(self.errors) - 1)
        return Gap(
            signal=signal,
            unit=str(axis.signal_units[signal]),
            band_hz=self.half_power_hz,
            nominal=None if self.errors[0] is None else self.level(0),
            reidentified=self.level(1),
            explained=self.level(len(self.errors) - 1),
            noise_floor=self._level(self.floor),
            steps=tuple(self.level(i) for i in range(2, len(self.errors))),
            closed_fraction=closed_fraction(re, explained, self.floor),
            closed_interval=closed_interval(re, explained, self.floor),
            unexplained_share=self.unexplained_share,
            reversal=self.reversal(),
            not_repeated=self.not_repeated(),
        )

    @property
    def unexplained_share(self) -> float:
        """Share of the re-identified model's excess that stays, see `removed`; nan if it has none."""
        felt = self._output_of(2) if len(self.states) > 2 else 0
        output = felt if felt >= self.record.n_drives else self.drive
        before, left = (self.excess(i, output) for i in (1, len(self.errors) - 1))
        least = THRESHOLDS.no_excess * float(self.floors[output]) ** 2
        return min(left / before, 1.0) if before > least else float("nan")

    @property
    def unexplained_of_all(self) -> float:
        """The same of all forces together, in multiples of their floors."""
        n_drives = self.record.n_drives
        felt = self._output_of(2) if len(self.states) > 2 else 0
        if n_drives == 1 or felt >= n_drives:
            return self.unexplained_share
        before, left = (self.whole_excess(i) for i in (1, len(self.errors) - 1))
        return min(left / before, 1.0) if before > n_drives * THRESHOLDS.no_excess else float("nan")

    @cached_property
    def near_reversal(self) -> BoolArray:
        """Kept rows within some time of a reversal or of a standstill of the driven joint."""
        record = self.record
        velocity = record.rows(1j * record.omega * self.motion)
        inside = record.rows_in_log
        slow = np.abs(velocity) < SLOW * np.abs(velocity[inside]).max(initial=0.0)
        turns = slow | (np.diff(np.signbit(velocity), prepend=np.signbit(velocity[0])) != 0)
        return near(turns & inside, self.row_rate)[self.weighting.kept]

    @cached_property
    def is_stationary(self) -> bool:
        """Whether the re-identified model errs as much where the axis moves little as where it moves much.

        Rows are halved by the speed and by the acceleration of the driven joint. Noise of any colour does not know of
        the motion; an error of the model does. A few rows cannot show it.
        """
        record, kept = self.record, self.weighting.kept
        if kept.sum() < _ENOUGH:
            return False
        s, squares = 1j * record.omega, self.squares(1)
        for motion in (s * self.motion, s**2 * self.motion * record.taper):
            course = np.abs(record.rows(motion)[kept])
            lively = course > np.median(course)
            halves = np.mean(squares[lively]), np.mean(squares[~lively])
            if max(halves) > _UNEVEN * min(halves):
                return False
        return True

    def reversal(self) -> Reversal | None:
        """Force error near reversals; None where the log has none."""
        near = self.near_reversal
        if near.sum() < _FEW:
            return None
        re, explained = (
            self._level(float(np.sqrt(np.mean(self.squares(i)[near])))) for i in (1, len(self.errors) - 1)
        )
        return Reversal(re, explained)

    def not_repeated(self) -> NotRepeated | None:
        """Part of the last model's force error that is new each time; None where the motion does not repeat."""
        record, inside = self.record, self.record.rows_in_log
        errors = self.errors[-1]
        if errors is None:
            return None
        motion, error = record.rows(self.motion)[inside], np.nan_to_num(errors[self.drive])[inside]
        found = repetition(motion, error, self.weighting.kept[inside])
        return None if found is None else NotRepeated(found.rows / self.row_rate, self._level(found.rms))

    @cached_property
    def half_power_hz(self) -> float:
        """Frequency at which the weight of the force error has fallen to 0.7."""
        fallen = np.flatnonzero(self._relative_density < np.sqrt(0.5))
        bins = fallen[fallen > 8]
        return float(self.record.omega[bins[0]] / (2 * np.pi)) if bins.size else self.record.band_hz

    @property
    def row_rate(self) -> float:
        """Rows a second, Hz."""
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
    """Apply models to a validation record; only what belongs to a log, such as its beginning, is fitted to it.

    All errors are weighted alike: by the noise that the first of the fits, the re-identified model, lets through.
    `allowed`, of shape (n_fine,), are the parts of the record that may be used.
    """
    base, weighting = applied(fits[0].state, record, allowed)
    models = [nominal, *(fit.state for fit in fits[1:])]
    states = [_applied(model, record, allowed, weighting) for model in models]
    states.insert(1, base)
    errors = (None if state is None else errors_of(state, weighting) for state in states)
    return Comparison(weighting, tuple(states), tuple(errors))


def _applied(
    model: State | None, record: Record, allowed: BoolArray | None, weighting: Weighting
) -> State | None:
    """A model under a record; None without one, or where its hidden motion grows without bound there."""
    if model is None:
        return None
    try:
        return applied(model, record, allowed)[0].weighted(weighting)
    except OverflowError:
        return None
