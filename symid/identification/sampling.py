"""A model sampled along a log: signals filtered, differentiated, put into the regressor, and thinned to rows."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symid.arrays import FloatArray
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
from symid.identification.scheme import Scheme
from symid.identification.settings import Preparation
from symid.signals import derivative_name

STANDSTILL_SHARE = 0.01
"""Part of the highest speed below which the sign of a velocity is not trusted."""
_WIDEST = 0.4
"""Of the sampling frequency: the highest cutoff to which a filter is widened."""

WORKERS = min(4, os.cpu_count() or 1)
"""Threads that prepare a log: with more, filters are bound by memory, not by the processor."""


@dataclass(frozen=True, eq=False)
class Sampling:
    """Data for sampling the model anywhere between the trimmed ends of a log.

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
    wide : mapping of str to array of shape (n,)
        The same, filtered less, of which nonlinear laws are evaluated; empty if they are evaluated of `signals`.
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
    wide: Mapping[str, FloatArray]
    before: int
    n_samples: int

    @property
    def factor(self) -> int:
        """Samples that become one row."""
        return self.chosen.decimation or 1

    @cached_property
    def low_pass(self) -> ZeroPhaseFilter | None:
        """Filter of what has not passed it as a signal: of nonlinear laws, if the force is filtered."""
        assert self.chosen.cutoff_hz is not None
        laws = self.model.law_columns or self.model.known_laws
        if not (laws and self.chosen.filter_force):
            return None
        return LowPass(self.chosen.cutoff_hz, self.chosen.order).zero_phase(1 / self.period)

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

    def window(
        self, first: int, last: int, recorded: Mapping[str, FloatArray] | None = None
    ) -> dict[str, FloatArray]:
        """Flat names with the derivatives that the model needs, from sample `first` to before sample `last`.

        The differences are those of the whole log: they are taken of as many more samples as they need; of `signals`
        if not of others.
        """
        flat: dict[str, FloatArray] = {}
        first, last = first + self.before, last + self.before
        for name, highest in self.model.highest_derivatives.items():
            whole = (recorded or self.signals)[name]
            margin = highest * self.scheme.reach
            lead = min(margin, first)
            current = whole[first - lead : min(last + margin, whole.size)]
            for order in range(highest + 1):
                flat[derivative_name(name, order)] = current[lead : lead + last - first]
                if order < highest:
                    current = self.scheme.difference(current, self.period)
        return flat


def sampling_of(model: GeneratedModel, log: Log, chosen: Preparation, scheme: Scheme) -> Sampling:
    """A model and a log with its signals filtered, for a complete preparation."""
    before, after = chosen.trim or (0, 0)
    signals, wide = filtered(model, log, chosen, 1.0, model.highest_derivatives), {}
    if scheme.widening > 1.0 and (model.law_columns or model.coulomb_at_drive):
        still = np.broadcast_to(0.0, log.n_samples)  # laws do not hold forces
        motion = [name for name in model.highest_derivatives if name not in model.forces]
        wide = dict.fromkeys(model.forces, still) | filtered(model, log, chosen, scheme.widening, motion)
    n_samples = log.n_samples - before - after
    found = Sampling(model, chosen, scheme, log.sampling_period, signals, wide, before, n_samples)
    if not chosen.coulomb:
        return found
    for force, friction in _coulomb_friction(found, log).items():
        signals[force] = signals[force] - friction
    return replace(found, signals=signals)


def _coulomb_friction(sampling: Sampling, log: Log) -> dict[str, FloatArray]:
    """Friction beside each drive along a whole log, filtered as the force is."""
    model, chosen = sampling.model, sampling.chosen
    assert chosen.coulomb is not None
    motion = replace(sampling, before=0).window(0, log.n_samples, sampling.wide)
    velocities = model.sliding_velocities(*(motion[name] for name in model.signals))
    found: dict[str, FloatArray] = {}
    for (row, _), force, level in zip(
        model.coulomb_at_drive, model.coulomb_drives, chosen.coulomb, strict=True
    ):
        found[force] = found.get(force, 0.0) + level * direction(velocities[row])
    if not chosen.filter_force:
        return found
    lowpass, rate = low_pass_of(chosen, 1.0, log.sampling_frequency), log.sampling_frequency
    return {force: lowpass.apply(friction, rate, workers=WORKERS) for force, friction in found.items()}


def direction(velocity: FloatArray) -> FloatArray:
    """Sign of a velocity, which changes once in a reversal; while the machine stands it stays what it was.

    Examples
    --------
    >>> direction(np.array([1.0, 0.001, -0.001, 0.001, -0.001, -1.0, 0.0, -0.001, -1.0])).tolist()
    [1.0, 1.0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0]
    """
    fast = np.abs(velocity) > STANDSTILL_SHARE * np.max(np.abs(velocity), initial=0.0)
    sign, every = np.sign(velocity), np.arange(velocity.size)
    last = np.maximum.accumulate(np.where(fast, every, 0))
    after = np.minimum.accumulate(np.where(fast, every, velocity.size - 1)[::-1])[::-1]
    before, behind = sign[last], sign[after]
    turned = (sign == behind) & (before != behind)
    # the first sample of a reversal that has the new direction, and all behind it
    turned_since = np.maximum.accumulate(np.where(turned, every, -1)) > last
    return np.where(before == behind, before, np.where(turned_since, behind, before))


def low_pass_of(chosen: Preparation, widening: float, sampling_frequency: float) -> LowPass:
    """Low-pass of signals before they are differentiated."""
    assert chosen.cutoff_hz is not None
    cutoff = max(chosen.cutoff_hz, min(widening * chosen.cutoff_hz, _WIDEST * sampling_frequency))
    return LowPass(cutoff, chosen.order)


def sampled(sampling: Sampling, with_velocities: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
    """W of shape (n_equations, n_parameters, n_rows), y, and the sliding velocities at all samples.

    The model is sampled, filtered and decimated piece by piece, each in the cache of one processor.
    """
    model, n_rows = sampling.model, -(-sampling.n_samples // sampling.factor)
    equations, sliding = len(model.output_names), {row for rows in model.sliding for row in rows}
    W = np.empty((equations, len(model.minimal_units), n_rows))
    y = np.empty((equations, n_rows))
    velocities = np.empty((len(sliding) if with_velocities else 0, sampling.n_samples))
    offset, thin = kept_indices(sampling.n_samples, sampling.factor).start, sampling.row_filter

    def sample(piece: Piece) -> None:
        places, chosen = kept_of(piece, offset, sampling.factor)
        signals = sampling.window(piece.first, piece.last)
        columns, output = model.sample(signals)
        columns = columns.transpose(0, 2, 1)
        if sampling.wide:
            signals = sampling.window(piece.first, piece.last, sampling.wide)
            laws = model.regressor(*(signals[name] for name in model.signals)).transpose(0, 2, 1)
            for place in model.law_columns:
                columns[place] = laws[place]
        if sampling.low_pass is not None:
            for place in model.law_columns:
                columns[place] = sampling.low_pass.apply(columns[place])
            for j in model.known_laws:
                output[j] = sampling.low_pass.apply(output[j])
        rows = ((columns.reshape(-1, columns.shape[-1]), W), (output, y))
        for values, out in rows:
            thinned = values[:, chosen] if thin is None else thin.apply_thinned(values, chosen)
            out[..., places] = thinned.reshape(*out.shape[:-1], -1)
        if with_velocities:
            arguments = (signals[name][piece.inner] for name in model.signals)
            velocities[:, piece.start : piece.stop] = model.sliding_velocities(*arguments)

    in_pieces(sample, sampling.n_samples, sampling.reach, WORKERS)
    _give_back(sampling, W, y)
    return W, y, velocities


def _give_back(sampling: Sampling, W: FloatArray, y: FloatArray) -> None:
    """Add the friction that was taken off the force to the outputs that have a column of it."""
    for (_, parameter), level in zip(
        sampling.model.coulomb_at_drive, sampling.chosen.coulomb or (), strict=False
    ):
        for equation, column in sampling.model.law_columns:
            if column == parameter:
                y[equation] += level * W[equation, column]


def filtered(
    model: GeneratedModel, log: Log, chosen: Preparation, widening: float, names: Iterable[str]
) -> dict[str, FloatArray]:
    """Low-passed signals at the times at which they were; forces are filtered only if the preparation filters them."""
    signals = {name: log[name] for name in names}
    lowpass = low_pass_of(chosen, widening, log.sampling_frequency)
    for name, values in signals.items():
        if chosen.filter_force or name not in model.forces:
            signals[name] = lowpass.apply(values, log.sampling_frequency, workers=WORKERS)
    for name, seconds in chosen.late.items():
        if name in signals:
            signals[name] = QuinticSpline(signals[name]).earlier(seconds / log.sampling_period)
    return signals
