"""A model sampled along a log: signals filtered, differentiated, put into the regressor, and thinned to rows."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from symid.arrays import FloatArray
from symid.codegen import GeneratedModel
from symid.data import Log
from symid.identification.rows.filtered_signals import Filtered, Signal, filtered
from symid.identification.rows.settings import Preparation, Scheme
from symid.signal_names import derivative_name
from symid.signal_processing import (
    LowPass,
    Piece,
    ZeroPhaseFilter,
    decimation_filter,
    in_pieces,
    kept_indices,
    kept_of,
)

STANDSTILL_SHARE = 0.01
"""Part of the highest speed below which the sign of a velocity is not trusted."""
SPARSE = 8
"""Distance of rows, in samples, from which what is linear in the signals is made at these alone."""

WORKERS = min(4, os.cpu_count() or 1)
"""Threads that prepare a log: with more, filters are bound by memory, not by the processor."""


@dataclass(frozen=True, eq=False)
class Sampling:
    """Data for sampling the model anywhere between the trimmed ends of a log."""

    model: GeneratedModel  # regressor and output
    chosen: Preparation  # complete
    scheme: Scheme  # how derivatives and laws are made
    period: float  # sampling period, s
    # shape (n,): filtered signals of the whole log; those that are not among them are still
    signals: Mapping[str, Signal]
    # shape (n,): motion for nonlinear laws, filtered with a higher cutoff; empty if they are evaluated with
    # `signals`
    wide: Mapping[str, Signal]
    before: int  # samples trimmed at the beginning
    n_samples: int  # samples between the ends

    @property
    def factor(self) -> int:
        """Decimation: samples of the log for each row."""
        return self.chosen.decimation or 1

    @property
    def n_rows(self) -> int:
        """Number of rows that remain after decimation."""
        return -(-self.n_samples // self.factor)

    @cached_property
    def low_pass(self) -> ZeroPhaseFilter | None:
        """Filter of nonlinear laws, which have not passed it as signals, if the force is filtered."""
        assert self.chosen.cutoff_hz is not None
        laws = self.model.law_columns or self.model.known_laws
        if not (laws and self.chosen.filter_force):
            return None
        return LowPass(self.chosen.cutoff_hz, self.chosen.order).zero_phase(1 / self.period)

    @cached_property
    def row_filter(self) -> ZeroPhaseFilter | None:
        """Filter of all rows before samples are left out; None if they need none."""
        factor = self.chosen.filtered_decimation(self.period)
        return decimation_filter(factor) if factor > 1 else None

    @property
    def kept(self) -> slice:
        """Samples of the log that rows keep."""
        first = self.before + kept_indices(self.n_samples, self.factor).start
        return slice(first, self.before + self.n_samples, self.factor)

    @property
    def is_sparse(self) -> bool:
        """Whether what is linear in the signals is made at the samples that are kept, without all others."""
        return self.row_filter is None and self.factor >= SPARSE and not self.model.known_laws

    @property
    def reach(self) -> int:
        """Samples on either side that the filters need."""
        return sum(f.reach for f in (self.low_pass, self.row_filter) if f is not None)

    @property
    def padding(self) -> int:
        """Samples beyond which a log must be longer for the filters."""
        return max((f.padding for f in (self.low_pass, self.row_filter) if f is not None), default=0)

    def window(self, first: int, last: int) -> dict[str, FloatArray]:
        """Flat names with the derivatives that the model needs, from sample `first` to before sample `last`.

        The differences are those of the whole log: they are taken of as many more samples as they need.
        """
        return self._derivatives(self.signals, first, last, self.model.highest_derivatives)

    def motion(self, first: int, last: int) -> dict[str, FloatArray]:
        """Signals for laws and sliding velocities: less filtered; forces and, as a rule, accelerations are 0."""
        if not self.wide:
            return self.window(first, last)
        highest = self.model.highest_derivatives
        if self.model.laws_of_velocity:
            highest = {name: min(order, 1) for name, order in highest.items()}
        return self._derivatives(self.wide, first, last, highest)

    def at(self, places: slice) -> dict[str, FloatArray]:
        """Flat names with the derivatives that the model needs, at sparse samples."""
        places = slice(places.start + self.before, places.stop + self.before, places.step)
        flat = dict.fromkeys(
            self.model.signals, np.broadcast_to(0.0, len(range(*places.indices(places.stop))))
        )
        for name, whole in self.signals.items():
            highest = self.model.highest_derivatives[name]
            if not highest and isinstance(whole, Filtered):
                flat[derivative_name(name, 0)] = whole.at(places)
                continue
            margin = highest * self.scheme.reach
            low = max(places.start - margin, 0)
            values = whole[low : min(places.stop + margin, whole.size)]
            kept = slice(places.start - low, places.stop - low, places.step)
            for order, x in enumerate(self.scheme.derivatives_at(values, self.period, highest, kept)):
                flat[derivative_name(name, order)] = x
        return flat

    def thinned(self) -> dict[str, FloatArray]:
        """Flat names with the derivatives that the model needs, as they are in rows to which they are linear."""
        kept = kept_indices(self.n_samples, self.factor)
        if self.is_sparse:
            return self.at(kept)
        thin, whole = self.row_filter, self.window(0, self.n_samples)
        if thin is None:
            return {name: x[kept] for name, x in whole.items()}
        return {name: thin.apply_thinned(x[None], kept)[0] for name, x in whole.items()}

    def of_law(self, x: FloatArray, kept: slice = slice(None)) -> FloatArray:
        """Samples of the values of a law, which have not passed the filter as signals."""
        return x[kept] if self.low_pass is None else self.low_pass.apply_thinned(x[None], kept)[0]

    def _derivatives(
        self, signals: Mapping[str, Signal], first: int, last: int, highest: Mapping[str, int]
    ) -> dict[str, FloatArray]:
        flat = dict.fromkeys(self.model.signals, np.broadcast_to(0.0, last - first))
        first, last = first + self.before, last + self.before
        for name, whole in signals.items():
            margin = highest[name] * self.scheme.reach
            lead = min(margin, first)
            current = whole[first - lead : min(last + margin, whole.size)]
            for order in range(highest[name] + 1):
                flat[derivative_name(name, order)] = current[lead : lead + last - first]
                if order < highest[name]:
                    current = self.scheme.difference(current, self.period)
        return flat


def sampling_of(model: GeneratedModel, log: Log, chosen: Preparation, scheme: Scheme) -> Sampling:
    """A model and a log with its signals filtered, for a complete preparation."""
    before, after = chosen.trim or (0, 0)
    signals, wide = filtered(model, log, chosen, 1.0, model.highest_derivatives), dict[str, Filtered]()
    if scheme.widening > 1.0 and (model.law_columns or model.coulomb_at_drive):
        motion = [name for name in model.highest_derivatives if name not in model.forces]
        wide = filtered(model, log, chosen, scheme.widening, motion)
    n_samples = log.n_samples - before - after
    return Sampling(model, chosen, scheme, log.sampling_period, signals, wide, before, n_samples)


@lru_cache(maxsize=64)  # every signal of every log asks for it
def linear_part(model: GeneratedModel, columns: tuple[int, ...] | None = None) -> GeneratedModel:
    """The model less what it is at rest: what is linear in the signals remains, of laws nothing as long as it rests.

    Of all columns of W, or of some.
    """
    rest = {name: np.zeros(1) for name in model.signals}
    W, y = model.sample(rest)
    units = list(model.minimal_units.items())
    chosen = range(len(units)) if columns is None else columns

    def regressor(*signals: FloatArray) -> FloatArray:
        if not chosen:
            return np.empty((len(W), signals[0].size, 0))
        rows = model.regressor(*signals) - W
        return rows if columns is None else rows[..., columns]

    return replace(
        model,
        minimal_units=dict(units[i] for i in chosen),
        law_columns=(),
        coulomb_at_drive=(),
        coulomb_drives=(),
        regressor=regressor,
        output=lambda *signals: model.output(*signals) - y,
    )


def sampled_rows(sampling: Sampling) -> tuple[FloatArray, FloatArray]:
    """W of shape (n_equations, n_parameters, n_rows), and y."""
    shape = (len(sampling.model.output_names), len(sampling.model.minimal_units), sampling.n_rows)
    W, y = np.empty(shape), np.empty((shape[0], shape[2]))
    sample_into(sampling, W, y)
    return W, y


def sample_into(
    sampling: Sampling, W: FloatArray, y: FloatArray, velocities: FloatArray | None = None
) -> None:
    """Sample the model, filter and decimate it piece by piece, each in the cache of one processor.

    Fills W and y, and the sliding velocities, of shape (n_sliding, n), at all samples of the log.
    """
    model, before = sampling.model, sampling.before
    offset, thin = kept_indices(sampling.n_samples, sampling.factor).start, sampling.row_filter

    def sample(piece: Piece) -> None:
        places, chosen = kept_of(piece, offset, sampling.factor)
        first, last = piece.first, piece.last
        if velocities is not None:  # those of the trimmed ends too
            first = -before if piece.start == 0 else first
            last = velocities.shape[1] - before if piece.stop == sampling.n_samples else last
        # What is linear in the signals is made at the samples that are kept, if they are sparse; laws at all samples.
        is_sparse = sampling.is_sparse
        is_linear = velocities is None and not model.law_columns
        motion = {} if is_sparse and is_linear else sampling.motion(first, last)
        inside = slice(piece.first - first, piece.last - first)
        within = {name: values[inside] for name, values in motion.items()}
        if is_sparse:
            signals = sampling.at(slice(piece.first + chosen.start, piece.first + chosen.stop, chosen.step))
        else:
            signals = sampling.window(piece.first, piece.last) if sampling.wide else within
        columns, output = model.sample(signals)
        columns = laws = columns.transpose(0, 2, 1)
        if model.law_columns and (sampling.wide or is_sparse):
            laws = model.regressor(*(within[name] for name in model.signals)).transpose(0, 2, 1)
        kept, chosen = (chosen, slice(None)) if is_sparse else (slice(None), chosen)
        for place in model.law_columns:
            columns[place] = sampling.of_law(laws[place], kept)
        for j in model.known_laws:
            output[j] = sampling.of_law(output[j])
        rows = ((columns.reshape(-1, columns.shape[-1]), W), (output, y))
        for values, out in rows:
            thinned = values[:, chosen] if thin is None else thin.apply_thinned(values, chosen)
            out[..., places] = thinned.reshape(*out.shape[:-1], thinned.shape[-1])
        if velocities is not None:
            begin = first if piece.start == 0 else piece.start
            end = last if piece.stop == sampling.n_samples else piece.stop
            arguments = (motion[name][begin - first : end - first] for name in model.signals)
            velocities[:, begin + before : end + before] = model.sliding_velocities(*arguments)

    in_pieces(sample, sampling.n_samples, sampling.reach, WORKERS)
