"""From a log to the observation matrix W and the output y, with the rows that may be used."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from symid.arrays import BoolArray, FloatArray
from symid.codegen import GeneratedModel
from symid.data import (
    Log,
    LowPass,
    Piece,
    QuinticSpline,
    ZeroPhaseFilter,
    decimation_filter,
    in_pieces,
    kept_indices,
    kept_of,
)
from symid.errors import SettingError
from symid.identification.scheme import PAPER, Scheme
from symid.identification.settings import Preparation, completed
from symid.signals import derivative_name

_STANDSTILL_SHARE = 0.01
"""Part of the highest speed below which the sign of a velocity is not trusted."""

_WIDEST = 0.4
"""Of the sampling frequency: the highest cutoff to which a filter is widened."""

_WORKERS = min(4, os.cpu_count() or 1)
"""Threads that prepare a log: filters are bound by the processor up to about so many, by memory beyond."""


@dataclass(frozen=True, eq=False)
class Observation:
    """A sampled model.

    Parameters
    ----------
    W : array of shape (n_equations, n_rows, n_parameters)
        Observation matrix.
    y : array of shape (n_equations, n_rows)
        Output.
    valid : bool array of shape (n_equations, n_rows)
        Rows that enter the estimation.
    time : array of shape (n_rows,)
        Time of each row, s.
    preparation : Preparation
        The settings used, complete.
    """

    W: FloatArray
    y: FloatArray
    valid: BoolArray
    time: FloatArray
    preparation: Preparation


def observe(
    model: GeneratedModel,
    log: Log,
    preparation: Preparation,
    scheme: Scheme = PAPER,
    *,
    highest: FloatArray | None = None,
) -> Observation:
    """Filter and differentiate a log, evaluate the regressor, decimate, and choose the rows.

    Parameters
    ----------
    model : GeneratedModel
        Its signals must be in the log.
    log : Log
        A run of the axis.
    preparation : Preparation
        What is left open is chosen from the log.
    scheme : Scheme
        Another one than the paper's, to compare with it.
    highest : array of shape (n_sliding,), optional
        Highest speed of each sliding velocity, where that of the log itself is not the one that tells what standstill
        is.

    Raises
    ------
    LogError
        If a signal is missing.
    SettingError
        If a setting is not possible for this log.
    """
    chosen = completed(preparation, log, model)
    before, after = ends_of(chosen, log.n_samples)
    sampling = _sampling(model, log, chosen, scheme)
    if sampling.n_samples <= sampling.padding:
        raise SettingError(
            f"{sampling.n_samples} samples are left between the trimmed ends, too few for the filters: more than "
            f"{sampling.padding} are required, trim less or give a longer log"
        )
    W, y, velocities = _sampled(sampling, sampling.needs_velocities)
    usable = _usable_rows(sampling, velocities, highest)
    kept = kept_indices(sampling.n_samples, sampling.factor)
    places = np.arange(before + kept.start, log.n_samples - after, sampling.factor, dtype=np.float64)
    return Observation(W.transpose(0, 2, 1), y, usable, log.start + log.sampling_period * places, chosen)


def ends_of(chosen: Preparation, n_samples: int) -> tuple[int, int]:
    """Samples trimmed at the beginning and at the end; SettingError if that leaves none."""
    before, after = chosen.trim or (0, 0)
    if before + after >= n_samples:
        raise SettingError(f"trimming {before} and {after} of {n_samples} samples leaves nothing: trim less")
    return before, after


def highest_speeds(model: GeneratedModel, log: Log, chosen: Preparation) -> FloatArray:
    """Highest speed of each sliding velocity between the trimmed ends of a log, shape (n_sliding,).

    Parameters
    ----------
    model, log
        As in `observe`.
    chosen : Preparation
        Complete.
    """
    sampling = _sampling(model, log, chosen, PAPER)
    signals = sampling.window(0, sampling.n_samples)
    velocities = model.sliding_velocities(*(signals[name] for name in model.signals))
    return np.asarray(np.max(np.abs(velocities), axis=1))


def reaches(model: GeneratedModel, chosen: Preparation, period: float) -> tuple[int, int]:
    """Samples on either side that filtered signals with their derivatives need, and those that rows need of them.

    Parameters
    ----------
    model : GeneratedModel
        Says how often signals are differentiated, and which laws are filtered.
    chosen : Preparation
        Complete.
    period : float
        Sampling period, s.
    """
    assert chosen.cutoff_hz is not None
    signals = LowPass(chosen.cutoff_hz, chosen.order).zero_phase(1 / period).reach
    signals += max(model.highest_derivatives.values()) * PAPER.reach
    if chosen.late:
        signals += QuinticSpline.reach(max(abs(late) for late in chosen.late.values()) / period)
    rows = _Sampling(model, chosen, PAPER, period, {}, 0, 0).reach
    return signals, rows + (_standstill_margin(chosen, period) + 1 if any(model.sliding) else 0)


def _standstill_margin(chosen: Preparation, period: float) -> int:
    """Samples on either side of a slow one that are left out: half a period of the cutoff, or one decimated sample."""
    assert chosen.cutoff_hz is not None
    factor = chosen.decimation or 1
    return max(math.ceil(0.5 / (period * chosen.cutoff_hz)), factor if factor > 1 else 0)


@dataclass(frozen=True, eq=False)
class ForceRows:
    """By how much the rows of a log change if its force is moved in time: they are linear in it.

    Parameters
    ----------
    sampling : _Sampling
        Of the part of the model that is linear in the signals, of which all but the force are still.
    force : QuinticSpline
        The filtered force.
    """

    sampling: _Sampling
    force: QuinticSpline

    @classmethod
    def of(cls, model: GeneratedModel, log: Log, chosen: Preparation) -> ForceRows:
        """That of a log, with the complete preparation of its observation."""
        before, after = chosen.trim or (0, 0)
        still = np.broadcast_to(0.0, log.n_samples)
        force = _filtered(model, log, chosen, PAPER.widening, (model.force,))
        signals = {**dict.fromkeys(model.highest_derivatives, still), **force}
        rest = log.n_samples - before - after
        sampling = _Sampling(_linear(model), chosen, PAPER, log.sampling_period, signals, before, rest)
        return cls(sampling, QuinticSpline(signals[model.force]))

    def change(self, late: float) -> tuple[FloatArray, FloatArray]:
        """Of W and y, by a force that is moved `late` seconds to an earlier time."""
        return self._rows(self._earlier(late) - self.force.values)

    def slope(self, step: float) -> tuple[FloatArray, FloatArray]:
        """Of W and y by second, from forces that are moved `step` seconds to either side."""
        return self._rows((self._earlier(step) - self._earlier(-step)) / (2 * step))

    def _earlier(self, late: float) -> FloatArray:
        return self.force.earlier(late / self.sampling.period)

    def _rows(self, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        signals = {**self.sampling.signals, self.sampling.model.force: force}
        W, y, _ = _sampled(replace(self.sampling, signals=signals), with_velocities=False)
        return W.transpose(0, 2, 1), y


def _linear(model: GeneratedModel) -> GeneratedModel:
    """The model less what it is at rest: what is linear in the signals remains, of laws nothing as long as it rests."""
    rest = {name: np.zeros(1) for name in model.signals}
    W, y = model.sample(rest)
    return replace(
        model,
        law_columns=(),
        regressor=lambda *signals: model.regressor(*signals) - W,
        output=lambda *signals: model.output(*signals) - y,
    )


def _sampling(model: GeneratedModel, log: Log, chosen: Preparation, scheme: Scheme) -> _Sampling:
    before, after = chosen.trim or (0, 0)
    signals = _filtered(model, log, chosen, scheme.widening, model.highest_derivatives)
    return _Sampling(
        model, chosen, scheme, log.sampling_period, signals, before, log.n_samples - before - after
    )


@dataclass(frozen=True, eq=False)
class _Sampling:
    """What it takes to sample the model anywhere between the trimmed ends of a log.

    Parameters
    ----------
    model : GeneratedModel
        Regressor and output.
    chosen : Preparation
        Complete.
    scheme : Scheme
        How derivatives and laws are made.
    period : float
        Sampling period, s.
    signals : mapping of str to array of shape (n,)
        Filtered signals of the whole log.
    before : int
        Samples trimmed at the beginning.
    n_samples : int
        Samples between the ends.
    """

    model: GeneratedModel
    chosen: Preparation
    scheme: Scheme
    period: float
    signals: Mapping[str, FloatArray]
    before: int
    n_samples: int

    @property
    def factor(self) -> int:
        """Samples that become one row."""
        return self.chosen.decimation or 1

    @cached_property
    def low_pass(self) -> ZeroPhaseFilter | None:
        """Filter of what has not passed it as a signal: of nonlinear laws, if the force is filtered, or of all rows."""
        assert self.chosen.cutoff_hz is not None
        if not (self.filters_all or (self.model.law_columns and self.chosen.filter_force)):
            return None
        return LowPass(self.chosen.cutoff_hz, self.chosen.order).zero_phase(1 / self.period)

    @property
    def filters_all(self) -> bool:
        """Whether rows are filtered rather than signals."""
        return self.scheme.widening > 1.0

    @cached_property
    def row_filter(self) -> ZeroPhaseFilter | None:
        """Filter of all rows before samples are left out."""
        return decimation_filter(self.factor) if self.factor > 1 else None

    @property
    def needs_velocities(self) -> bool:
        """Whether rows near standstill have to be found."""
        return any(self.model.sliding) and self.chosen.standstill != 0

    @property
    def reach(self) -> int:
        """Samples on either side that the filters need."""
        return sum(f.reach for f in (self.low_pass, self.row_filter) if f is not None)

    @property
    def padding(self) -> int:
        """Samples that there must be more of for the filters."""
        return max((f.padding for f in (self.low_pass, self.row_filter) if f is not None), default=0)

    def window(self, first: int, last: int) -> dict[str, FloatArray]:
        """Flat names with the derivatives that the model needs, from sample `first` to before sample `last`.

        The differences are those of the whole log: they are taken of as many more samples as they need.
        """
        flat: dict[str, FloatArray] = {}
        first, last = first + self.before, last + self.before
        for name, highest in self.model.highest_derivatives.items():
            whole = self.signals[name]
            margin = highest * self.scheme.reach
            lead = min(margin, first)
            current = whole[first - lead : min(last + margin, whole.size)]
            for order in range(highest + 1):
                flat[derivative_name(name, order)] = current[lead : lead + last - first]
                if order < highest:
                    current = self.scheme.difference(current, self.period)
        return flat


def _sampled(sampling: _Sampling, with_velocities: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
    """W of shape (n_equations, n_parameters, n_rows), y, and the sliding velocities at all samples.

    The model is sampled, filtered and decimated piece by piece, each in the cache of one processor.
    """
    model, n_rows = sampling.model, -(-sampling.n_samples // sampling.factor)
    equations, sliding = len(model.output_names), {row for rows in model.sliding for row in rows}
    W = np.empty((equations, len(model.minimal_units), n_rows))
    y = np.empty((equations, n_rows))
    velocities = np.empty((len(sliding) if with_velocities else 0, sampling.n_samples))
    offset = kept_indices(sampling.n_samples, sampling.factor).start

    def sample(piece: Piece) -> None:
        places, chosen = kept_of(piece, offset, sampling.factor)
        signals = sampling.window(piece.first, piece.last)
        columns, output = model.sample(signals)
        columns = columns.transpose(0, 2, 1)
        if sampling.low_pass is not None:
            every = sampling.filters_all
            for place in np.ndindex(columns.shape[:2]) if every else model.law_columns:
                columns[place] = sampling.low_pass.apply(columns[place])
            for row in output if every else ():
                row[:] = sampling.low_pass.apply(row)
        _thin(columns, sampling.row_filter, W[..., places], chosen)
        _thin(output, sampling.row_filter, y[..., places], chosen)
        if with_velocities:
            arguments = (signals[name][piece.inner] for name in model.signals)
            velocities[:, piece.start : piece.stop] = model.sliding_velocities(*arguments)

    in_pieces(sample, sampling.n_samples, sampling.reach, _WORKERS)
    return W, y, velocities


def _thin(rows: FloatArray, row_filter: ZeroPhaseFilter | None, out: FloatArray, chosen: slice) -> None:
    """Write the chosen samples of filtered rows."""
    if row_filter is None:
        out[...] = rows[..., chosen]
        return
    for row in np.ndindex(rows.shape[:-1]):
        out[row] = row_filter.apply(rows[row])[chosen]


def _filtered(
    model: GeneratedModel, log: Log, chosen: Preparation, widening: float, names: Iterable[str]
) -> dict[str, FloatArray]:
    """Low-passed signals at the times at which they were; the force is filtered only if the preparation says so."""
    assert chosen.cutoff_hz is not None
    signals = {name: log[name] for name in names}
    cutoff = max(chosen.cutoff_hz, min(widening * chosen.cutoff_hz, _WIDEST * log.sampling_frequency))
    lowpass = LowPass(cutoff, chosen.order)
    for name, values in signals.items():
        if chosen.filter_force or name != model.force:
            signals[name] = lowpass.apply(values, log.sampling_frequency, workers=_WORKERS)
    for name, seconds in chosen.late.items():
        if name in signals:
            signals[name] = QuinticSpline(signals[name]).earlier(seconds / log.sampling_period)
    return signals


def _usable_rows(sampling: _Sampling, velocities: FloatArray, highest: FloatArray | None) -> BoolArray:
    """Rows of each equation that are not near the standstill of a law that jumps there.

    Besides the slow samples, those within half a period of the cutoff frequency and within one decimated sample of
    them are left out: there filtered velocity and filtered friction have different signs.
    """
    chosen, factor = sampling.chosen, sampling.factor
    usable = np.ones((len(sampling.model.sliding), -(-sampling.n_samples // factor)), dtype=bool)
    margin = _standstill_margin(chosen, sampling.period)
    offset = kept_indices(sampling.n_samples, factor).start
    for row, velocity in enumerate(velocities):
        threshold = chosen.standstill
        if threshold is None:
            own = (
                max(float(velocity.max()), -float(velocity.min())) if highest is None else float(highest[row])
            )
            threshold = _STANDSTILL_SHARE * own
        concerned = [equation for equation, rows in enumerate(sampling.model.sliding) if row in rows]
        mark = partial(
            _leave_out, velocity, threshold, margin, (offset, factor), [usable[j] for j in concerned]
        )
        in_pieces(mark, sampling.n_samples, margin + 1, _WORKERS)
    return usable


def _leave_out(
    velocity: FloatArray,
    threshold: float,
    margin: int,
    kept: tuple[int, int],
    usable: list[BoolArray],
    piece: Piece,
) -> None:
    """Mark the rows of a piece that are near standstill as not usable."""
    v = velocity[piece.first : piece.last]
    slow = np.abs(v) < threshold
    backward = np.signbit(v)
    slow[1:] |= backward[1:] != backward[:-1]
    places, chosen = kept_of(piece, *kept)
    far = ~_near(slow, margin)[chosen]
    for rows in usable:
        rows[places] &= far


def _near(flags: BoolArray, margin: int) -> BoolArray:
    """Samples with a flag among those up to `margin` before and after them.

    Examples
    --------
    >>> _near(np.array([False, True, False, False]), 1).tolist()
    [True, True, True, False]
    """
    counts = np.zeros(flags.size + 2 * margin + 1, dtype=np.int32)
    np.cumsum(flags, out=counts[margin + 1 : margin + 1 + flags.size])
    counts[margin + 1 + flags.size :] = counts[margin + flags.size]
    return np.asarray(counts[2 * margin + 1 :] > counts[: flags.size])
