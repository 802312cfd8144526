"""Observation matrix W and output y of a log, with the rows that may be used."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import BoolArray, FloatArray
from symid.codegen import GeneratedModel
from symid.data import Log
from symid.errors import SettingError
from symid.identification.rows.bands import completed
from symid.identification.rows.coulomb import more_columns, sample_friction, take_off
from symid.identification.rows.filtered_signals import low_pass_of
from symid.identification.rows.sampling import Sampling, sample_into, sampling_of
from symid.identification.rows.settings import Preparation, Scheme
from symid.identification.rows.usable_rows import leave_out_spoiled, usable_rows
from symid.signal_processing import kept_indices


@dataclass(frozen=True, eq=False)
class Observation:
    """A sampled model."""

    W: FloatArray
    """Observation matrix; shape (n_equations, n_rows, n_parameters)."""
    y: FloatArray
    """Output; shape (n_equations, n_rows)."""
    valid: BoolArray
    """Rows that enter the estimation; shape (n_equations, n_rows)."""
    time: FloatArray
    """Time of each row, s; shape (n_rows,)."""
    preparation: Preparation
    """The settings used, complete."""
    with_friction: FloatArray | None = None
    """W with columns of the friction beside drives, see `coulomb`; shape (n_equations, n_rows, n_columns), optional."""
    highest: FloatArray | None = None
    """Highest speed of each sliding velocity, from which the limit of standstill follows; shape (n_sliding,),
    optional."""

    def squares(self, X: FloatArray) -> FloatArray:
        """Sum of squares of the residual of parameters in the used rows of each equation."""
        return np.asarray(np.sum(np.where(self.valid, self.y - self.W @ X, 0.0) ** 2, axis=1))


def observe(
    model: GeneratedModel,
    log: Log,
    preparation: Preparation,
    *,
    highest: FloatArray | None = None,
    friction: bool = False,
) -> Observation:
    """Filter and differentiate a log, evaluate the regressor, decimate, and choose the rows.

    Parameters
    ----------
    model : GeneratedModel
        Its signals must be in the log.
    log : Log
        A run of the axis.
    preparation : Preparation
        Settings; those that are None are chosen from the log.
    highest : array of shape (n_sliding,), optional
        Highest speed of each sliding velocity, from which the limit of standstill follows; by default that of the log.
    friction : bool
        Whether columns of the friction beside drives are wanted.

    Raises
    ------
    LogError
        If a signal is missing.
    SettingError
        If a setting is not possible for this log.
    """
    chosen = completed(preparation, log, model)
    before, after = trimmed_ends(chosen, log.n_samples)
    sampling = _sampling(model, log, chosen, Scheme(chosen.difference_order, chosen.widening or 1.0))
    needs_velocities = any(model.sliding) and chosen.standstill != 0
    W, y, velocities = _filled(sampling, log.n_samples, friction, needs_velocities)
    sliding = velocities[: len(velocities) if needs_velocities else 0]
    if needs_velocities:
        log.kept(_of_velocities(sampling), lambda: velocities)
    if highest is None:
        inside = sliding[:, before : before + sampling.n_samples]
        highest = np.maximum(inside.max(axis=1), -inside.min(axis=1))
    usable = usable_rows(sampling, sliding, highest)
    kept = kept_indices(sampling.n_samples, sampling.factor)
    first = before + kept.start
    time = np.arange(first, log.n_samples - after, sampling.factor, dtype=np.float64)
    time *= log.sampling_period
    time += log.start
    if chosen.filter_force and sampling.row_filter is None:
        rate, low_pass = log.sampling_frequency, low_pass_of(chosen, 1.0, log.sampling_frequency)
        leave_out_spoiled(low_pass, rate, (W, y, usable), (first, after), sampling.factor)
    p = len(model.minimal_units)
    return Observation(W[..., :p], y, usable, time, chosen, W if friction else None, highest)


def rows_by(
    model: GeneratedModel, log: Log, chosen: Preparation, scheme: Scheme
) -> tuple[FloatArray, FloatArray]:
    """W and y of all rows of a log by another scheme than that of its complete preparation."""
    W, y, _ = _filled(_sampling(model, log, chosen, scheme), log.n_samples)
    return W[..., : len(model.minimal_units)], y


def _sampling(model: GeneratedModel, log: Log, chosen: Preparation, scheme: Scheme) -> Sampling:
    """`sampling_of`; SettingError if too few samples are left between the trimmed ends."""
    sampling = sampling_of(model, log, chosen, scheme)
    if sampling.n_samples <= sampling.padding:
        raise SettingError(
            f"{sampling.n_samples} samples are left between the trimmed ends, too few for the filters: more than "
            f"{sampling.padding} are required, trim less or give a longer log"
        )
    return sampling


def _filled(
    sampling: Sampling, n_samples: int, friction: bool = False, needs_velocities: bool = False
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """W, with friction beside drives if that is wanted or taken off, y, and sliding velocities if needed."""
    model, levels = sampling.model, sampling.chosen.coulomb
    beside_drives = friction or bool(levels)
    p, more = len(model.minimal_units), more_columns(model) if beside_drives else 0
    # Columns are contiguous while they are filled; at the end W is transposed to rows.
    W = np.empty((len(model.output_names), p + more, sampling.n_rows))
    y = np.empty((W.shape[0], W.shape[2]))
    n_sliding = len(model.sliding_velocities(*np.zeros((len(model.signals), 1))))
    velocities = np.empty((n_sliding, n_samples))
    sample_into(sampling, W[:, :p], y, velocities if needs_velocities or beside_drives else None)
    if beside_drives:
        sample_friction(sampling, W, velocities)
    if levels:
        take_off(model, W, y, levels)
    return W.transpose(0, 2, 1), y, velocities


def without_levels(model: GeneratedModel, seen: Observation, levels: tuple[float, ...]) -> Observation:
    """The rows without friction of given levels beside the drives, in place of those with columns of it."""
    assert seen.with_friction is not None
    take_off(model, seen.with_friction.transpose(0, 2, 1), seen.y, levels)
    return replace(seen, preparation=replace(seen.preparation, coulomb=levels), with_friction=None)


def trimmed_ends(chosen: Preparation, n_samples: int) -> tuple[int, int]:
    """Samples trimmed at the beginning and at the end; SettingError if that leaves none."""
    before, after = chosen.trim or (0, 0)
    if before + after >= n_samples:
        raise SettingError(f"trimming {before} and {after} of {n_samples} samples leaves nothing: trim less")
    return before, after


def highest_speeds(model: GeneratedModel, log: Log, chosen: Preparation) -> FloatArray:
    """Highest speed of each sliding velocity between the trimmed ends of a log, shape (n_sliding,)."""
    return np.asarray(np.max(np.abs(sliding_velocities(model, log, chosen)), axis=1))


def sliding_velocities(model: GeneratedModel, log: Log, chosen: Preparation) -> FloatArray:
    """Each sliding velocity at the samples between the trimmed ends of a log, shape (n_sliding, n_samples)."""
    sampling = sampling_of(model, log, chosen, Scheme(chosen.difference_order, chosen.widening or 1.0))

    def found() -> FloatArray:
        signals = sampling.motion(0, sampling.n_samples)
        return np.asarray(model.sliding_velocities(*(signals[name] for name in model.signals)))

    return log.kept(_of_velocities(sampling), found) if sampling.n_samples == log.n_samples else found()


def _of_velocities(sampling: Sampling) -> Hashable:
    """Key of the sliding velocities at all samples of a log."""
    signals = (sampling.wide or sampling.signals).values()
    return sliding_velocities, sampling.model.sliding_velocities, sampling.scheme, *signals
