"""From a log to the observation matrix W and the output y, with the rows that may be used."""

from __future__ import annotations

import math
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
    in_pieces,
    kept_indices,
    kept_of,
)
from symid.errors import SettingError
from symid.identification.coulomb import more_columns, sample_friction, take_off
from symid.identification.filter_ends import leave_out_spoiled
from symid.identification.noise import coefficients
from symid.identification.sampling import (
    STANDSTILL_SHARE,
    WORKERS,
    Sampling,
    filtered,
    linear_part,
    low_pass_of,
    sample_into,
    sampled_rows,
    sampling_of,
)
from symid.identification.scheme import Scheme
from symid.identification.settings import Preparation, completed
from symid.signal_names import split_derivative

_RESTS, _RESTS_OF_DERIVATIVES = 2, 4
"""Margins beside a rest: filters of order 4 leave 2 % of a step of friction there, 0.6 % at three margins.

Derivatives of a force show more of it: on a log of direct_2m1s two margins made Ms 5.2 % wrong at twelve
deviations, three 0.9 %, four 0.3 %. Without derivatives more only cost rows: three raise Table 11 from 1.5 to 2.3 %.
"""
_LONGEST_STOP = 12
"""Longest stop between two motions in one direction that is looked for, over half the shortest rest: a period."""
_STEP = 0.25
"""Half the shift between the signals whose difference is the derivative by their time, in samples."""


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
    with_friction : array of shape (n_equations, n_rows, n_columns), optional
        W with columns of the friction beside drives, see `coulomb`.
    """

    W: FloatArray
    y: FloatArray
    valid: BoolArray
    time: FloatArray
    preparation: Preparation
    with_friction: FloatArray | None = None

    def squares(self, X: FloatArray) -> FloatArray:
        """Sum of squares of what parameters leave in the used rows of each equation."""
        return np.asarray(np.sum(np.where(self.valid, self.y - self.W @ X, 0.0) ** 2, axis=1))


def observe(
    model: GeneratedModel,
    log: Log,
    preparation: Preparation,
    scheme: Scheme | None = None,
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
    scheme : Scheme, optional
        Scheme in place of the one of the preparation, for a comparison.
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
    sampling = sampling_of(
        model, log, chosen, scheme or Scheme(chosen.difference_order, chosen.widening or 1.0)
    )
    if sampling.n_samples <= sampling.padding:
        raise SettingError(
            f"{sampling.n_samples} samples are left between the trimmed ends, too few for the filters: more than "
            f"{sampling.padding} are required, trim less or give a longer log"
        )
    needs_velocities = any(model.sliding) and chosen.standstill != 0
    beside_drives = friction or bool(chosen.coulomb)
    p, more = len(model.minimal_units), more_columns(model) if beside_drives else 0
    # Columns are contiguous while they are filled; at the end W is transposed to rows.
    W = np.empty((len(model.output_names), p + more, sampling.n_rows))
    y = np.empty((W.shape[0], W.shape[2]))
    n_sliding = len(model.sliding_velocities(*np.zeros((len(model.signals), 1))))
    velocities = np.empty((n_sliding, log.n_samples))
    sample_into(sampling, W[:, :p], y, velocities if needs_velocities or beside_drives else None)
    usable = _usable_rows(sampling, velocities[: n_sliding if needs_velocities else 0], highest)
    if beside_drives:
        sample_friction(sampling, W, velocities)
    if chosen.coulomb:
        take_off(model, W, y, chosen.coulomb)
    kept = kept_indices(sampling.n_samples, sampling.factor)
    places = np.arange(before + kept.start, log.n_samples - after, sampling.factor, dtype=np.float64)
    time = log.start + log.sampling_period * places
    W = W.transpose(0, 2, 1)
    if chosen.filter_force and sampling.row_filter is None:
        rate, ends = log.sampling_frequency, (places, log.n_samples - 1 - places)
        leave_out_spoiled(low_pass_of(chosen, 1.0, rate), rate, (W, y, usable), ends)
    return Observation(W[..., :p], y, usable, time, chosen, W if friction else None)


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
    sampling = sampling_of(model, log, chosen, Scheme(chosen.difference_order, chosen.widening or 1.0))
    signals = sampling.motion(0, sampling.n_samples)
    velocities = model.sliding_velocities(*(signals[name] for name in model.signals))
    return np.asarray(np.max(np.abs(velocities), axis=1))


def reaches(model: GeneratedModel, chosen: Preparation, period: float) -> tuple[int, int]:
    """Samples on either side that filtered signals with their derivatives need, and those that rows need of them."""
    assert chosen.cutoff_hz is not None
    signals = LowPass(chosen.cutoff_hz, chosen.order).zero_phase(1 / period).reach
    scheme = Scheme(chosen.difference_order)
    signals += max(model.highest_derivatives.values()) * scheme.reach
    if chosen.late:
        signals += QuinticSpline.reach(max(abs(late) for late in chosen.late.values()) / period)
    rows = Sampling(model, chosen, scheme, period, {}, {}, 0, 0).reach
    rests = _RESTS_OF_DERIVATIVES if model.coulomb_at_drive else _RESTS
    return signals, rows + ((rests + 2) * _standstill_margin(chosen, period) + 1 if any(model.sliding) else 0)


def _standstill_margin(chosen: Preparation, period: float) -> int:
    """Samples on either side of a slow one that are left out: half a period of the cutoff, or one decimated sample."""
    assert chosen.cutoff_hz is not None
    factor = chosen.decimation or 1
    return max(math.ceil(0.5 / (period * chosen.cutoff_hz)), factor if factor > 1 else 0)


@dataclass(frozen=True, eq=False)
class SignalRows:
    """Contribution of some signals to the rows of a log, to which rows are linear, and its change under a delay."""

    # of the part of the model that is linear in the signals; all other signals are 0
    sampling: Sampling
    columns: tuple[int, ...]  # columns of W that they are in, those of the part of the model
    n_columns: int  # columns of W

    @classmethod
    def of(cls, model: GeneratedModel, log: Log, chosen: Preparation, *names: str) -> SignalRows:
        """Rows from the filtered signals of a log; the preparation is the complete one of its observation."""
        before, after = chosen.trim or (0, 0)
        scheme = Scheme(chosen.difference_order)
        own = {name: x[:] for name, x in filtered(model, log, chosen, 1.0, names).items()}
        rest = log.n_samples - before - after
        period = log.sampling_period
        mine = [i for i, flat in enumerate(model.signals) if split_derivative(flat)[0] in names]
        factors = coefficients(model)[:, :-1, mine]
        columns = tuple(np.flatnonzero(np.any(factors, axis=(0, 2))).tolist())
        part = linear_part(model, columns)
        sampling = Sampling(part, chosen, scheme, period, own, {}, before, rest)
        return cls(sampling, columns, factors.shape[1])

    @cached_property
    def rows(self) -> tuple[FloatArray, FloatArray]:
        """Rows of W and y of the window."""
        return self._rows({name: x[:] for name, x in self.sampling.signals.items()})

    def change(self, late: float) -> tuple[FloatArray, FloatArray]:
        """Change of W and y if the signals are moved `late` seconds to an earlier time."""
        return self._rows(
            {name: self._earlier(name, late) - x[:] for name, x in self.sampling.signals.items()}
        )

    @cached_property
    def slope(self) -> tuple[FloatArray, FloatArray]:
        """Derivative of W and y by `late`, per second, by central differences over a part of a sample."""
        step = _STEP * self.sampling.period
        return self._rows(
            {
                name: (self._earlier(name, step) - self._earlier(name, -step)) / (2 * step)
                for name in self.sampling.signals
            }
        )

    @cached_property
    def _splines(self) -> dict[str, QuinticSpline]:
        return {name: QuinticSpline(x[:]) for name, x in self.sampling.signals.items()}

    def _earlier(self, name: str, late: float) -> FloatArray:
        return self._splines[name].earlier(late / self.sampling.period)

    def _rows(self, signals: dict[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
        moved, y = sampled_rows(replace(self.sampling, signals=signals))
        W = np.zeros((*y.shape, self.n_columns))
        W[..., self.columns] = moved.transpose(0, 2, 1)
        return W, y


def _usable_rows(sampling: Sampling, velocities: FloatArray, highest: FloatArray | None) -> BoolArray:
    """Rows of each equation that are not near the standstill of a law that jumps there.

    Besides the slow samples, those within half a period of the cutoff frequency and within one decimated sample of
    them are left out: there filtered velocity and filtered friction have different signs. Of rests and stops, in which
    friction is any part of its level, filters carry that further, from trimmed ends too: velocities are those of the
    whole log.
    """
    chosen, factor = sampling.chosen, sampling.factor
    usable = np.ones((len(sampling.model.sliding), sampling.n_rows), dtype=bool)
    margin = _standstill_margin(chosen, sampling.period)
    offset = kept_indices(sampling.n_samples, factor).start
    inside = slice(sampling.before, sampling.before + sampling.n_samples)
    for row, velocity in enumerate(velocities):
        threshold = chosen.standstill
        if threshold is None:
            seen = velocity[inside]
            own = max(float(seen.max()), -float(seen.min())) if highest is None else float(highest[row])
            threshold = STANDSTILL_SHARE * own
        concerned = [equation for equation, rows in enumerate(sampling.model.sliding) if row in rows]
        # Friction that is taken off the force leaves reversals clean: of equations that hold none of it, rests go.
        jumping = {equation for equation, _ in sampling.model.law_columns}
        taken_off = bool(sampling.model.coulomb_at_drive) and chosen.coulomb != ()
        held = [usable[j] for j in concerned if not taken_off or j in jumping]
        free = [usable[j] for j in concerned if taken_off and j not in jumping]
        core = margin // 6
        rests = _RESTS_OF_DERIVATIVES if taken_off else _RESTS
        for rows, reach, rest in ((held, margin, 0), (held + free, rests * margin, core)):
            whole = velocity, sampling.before, reach + _LONGEST_STOP * rest + 1
            mark = partial(_leave_out, whole, threshold, reach, (offset, factor), rows, rest)
            if rows:
                in_pieces(mark, sampling.n_samples, 0, WORKERS)
    return usable


def _leave_out(
    whole: tuple[FloatArray, int, int],
    threshold: float,
    margin: int,
    kept: tuple[int, int],
    usable: list[BoolArray],
    rest: int,
    piece: Piece,
) -> None:
    """Mark the rows of a piece near standstill as not usable; with `rest`, near rests of more than twice that.

    `whole` is the velocity of the log, the samples trimmed at its beginning, and those that a row sees on either side.
    """
    velocity, before, reach = whole
    first = max(piece.start - reach, -before)
    piece = replace(piece, first=first, last=min(piece.stop + reach, velocity.size - before))
    v = velocity[piece.first + before : piece.last + before]
    slow = np.abs(v) < threshold
    if rest:
        slow = _near(~_near(~slow, rest), rest) | (slow & _stops(v, threshold, _LONGEST_STOP * rest))
    else:
        backward = np.signbit(v)
        slow[1:] |= backward[1:] != backward[:-1]
    places, chosen = kept_of(piece, *kept)
    far = ~_near(slow, margin)[chosen]
    for rows in usable:
        rows[places] &= far


def _stops(velocity: FloatArray, threshold: float, longest: int) -> BoolArray:
    """Spans in which a velocity falls below a threshold and goes on with its sign, up to `longest` samples.

    A span ends at twice the threshold, which noise does not pass to and fro.

    >>> _stops(np.array([3.0, 1.5, 0.5, -0.5, 2.5, 1.5, 2.5, 0.5, -2.5]), 1.0, 3).astype(int).tolist()
    [0, 1, 1, 1, 0, 0, 0, 0, 0]
    """
    speed = np.abs(velocity)
    edges = np.flatnonzero(np.diff(speed < 2 * threshold, prepend=False, append=False))
    begins, ends = edges[::2], edges[1::2]
    inside = (begins > 0) & (ends < speed.size) & (ends - begins <= longest)
    begins, ends = begins[inside], ends[inside]
    goes_on = np.sign(velocity[begins - 1]) == np.sign(velocity[ends])
    if not goes_on.any():
        return np.zeros(speed.size, dtype=bool)
    goes_on &= np.minimum.reduceat(speed, begins) < threshold
    steps = np.zeros(speed.size + 1, dtype=np.int32)
    steps[begins[goes_on]] += 1
    steps[ends[goes_on]] -= 1
    return np.asarray(np.cumsum(steps[:-1]) > 0)


def _near(flags: BoolArray, margin: int) -> BoolArray:
    """Samples with a flag among those up to `margin` before and after them.

    >>> _near(np.array([False, True, False, False]), 1).tolist()
    [True, True, True, False]
    """
    counts = np.zeros(flags.size + 2 * margin + 1, dtype=np.int32)
    np.cumsum(flags, out=counts[margin + 1 : margin + 1 + flags.size])
    counts[margin + 1 + flags.size :] = counts[margin + flags.size]
    return np.asarray(counts[2 * margin + 1 :] > counts[: flags.size])
