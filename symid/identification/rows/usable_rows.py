"""Rows that enter an estimate, not near a standstill or spoiled by the ends, and the samples on which they depend."""

import math
from dataclasses import replace
from functools import partial

import numpy as np

from symid.arrays import BoolArray, FloatArray, least_squares, runs_of_true
from symid.codegen import GeneratedModel
from symid.identification.rows.sampling import STANDSTILL_SHARE, WORKERS, Sampling
from symid.identification.rows.settings import Preparation, Scheme
from symid.signal_processing import LowPass, Piece, QuinticSpline, in_pieces, kept_indices, kept_of

_RESTS, _RESTS_OF_MODES = 2, 4
"""Margins beside a rest: filters of order 4 leave 2 % of a step of friction there, 0.6 % at three margins.

What is left has one sign at all reversals of a kind. Dampers of a flexible axis are as small: of a ball screw in closed
loop that sticks at reversals, two margins made Ft 21 % wrong at five deviations, three 6 %, four 1.6 %; of a
direct_2m1s, Ms 5.2, 0.9 and 0.3 %. For rigid axes more only cost rows: three raise Table 11 from 1.5 to 2.3 %.
"""
_LONGEST_STOP = 12
"""Longest stop between two motions in one direction that is looked for, over half the shortest rest: a period."""
_PERIODS = 40
"""Periods of the cutoff next to an end whose rows determine parameters and transient together."""
_ROWS_EACH = 3
"""Rows needed at least for each parameter and pole."""
_STANDS_OUT, _FADED = 4.0, 0.25
"""Transient over the rms of the residual from which it is taken for one, and from which on rows are used again."""
_FORGOTTEN = 1e-12
"""Transient, as a share of that at the end, which no number shows beside the signals."""
_DEPENDENT = 1e-10
"""Singular value over the largest, for columns of unit norm, that counts as rounding."""
_EXACT = 1e-7
"""Residual over the output which no sensor shows: exact logs keep their rows."""


def reaches(model: GeneratedModel, chosen: Preparation, period: float) -> tuple[int, int]:
    """Samples on either side that filtered signals with their derivatives need, and those that rows need of them."""
    assert chosen.cutoff_hz is not None
    signals = LowPass(chosen.cutoff_hz, chosen.order).zero_phase(1 / period).reach
    scheme = Scheme(chosen.difference_order)
    signals += max(model.highest_derivatives.values()) * scheme.reach
    if chosen.late:
        signals += QuinticSpline.reach((max(map(abs, chosen.late.values())) + chosen.hold) / period)
    rows = Sampling(model, chosen, scheme, period, {}, {}, 0, 0).reach
    return signals, rows + (
        (_rests(model) + 2) * _standstill_margin(chosen, period) + 1 if any(model.sliding) else 0
    )


def _standstill_margin(chosen: Preparation, period: float) -> int:
    """Samples on either side of a slow one that are left out: half a period of the cutoff, or one decimated sample."""
    assert chosen.cutoff_hz is not None
    factor = chosen.decimation or 1
    return max(math.ceil(0.5 / (period * chosen.cutoff_hz)), factor if factor > 1 else 0)


def _rests(model: GeneratedModel) -> int:
    """Margins beside a rest."""
    return _RESTS_OF_MODES if model.is_flexible else _RESTS


def usable_rows(sampling: Sampling, velocities: FloatArray, highest: FloatArray) -> BoolArray:
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
    for row, velocity in enumerate(velocities):
        threshold = chosen.standstill
        if threshold is None:
            threshold = STANDSTILL_SHARE * float(highest[row])
        concerned = [equation for equation, rows in enumerate(sampling.model.sliding) if row in rows]
        # Friction that is taken off the force leaves reversals clean: of equations that hold none of it, rests go.
        jumping = {equation for equation, _ in sampling.model.law_columns}
        taken_off = bool(sampling.model.coulomb_at_drive) and chosen.coulomb != ()
        held = [usable[j] for j in concerned if not taken_off or j in jumping]
        free = [usable[j] for j in concerned if taken_off and j not in jumping]
        core = margin // 6
        for rows, reach, rest in ((held, margin, 0), (held + free, _rests(sampling.model) * margin, core)):
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
    begins, ends = runs_of_true(speed < 2 * threshold).T
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


def leave_out_spoiled(
    low_pass: LowPass,
    sampling_frequency: float,
    rows: tuple[FloatArray, FloatArray, BoolArray],
    ends: tuple[int, int],
    step: int,
) -> None:
    """Mark the rows as not usable in which a transient of one of the ends stands out.

    A filter continues what lies outside of a log, wrongly where motion does not rest there. What that adds to each row
    decays with the poles p of the filter: a sum of c p^k at k samples from the end. All columns of W and y have passed
    the same filter, so that the residual holds one such transient at each end. It is fitted beside the parameters to
    the rows next to the end, and rows in which it stands out of their residual are left out.

    All columns have passed the filter `low_pass`. `rows` are W, y and usable, of shapes (n_equations, n_rows,
    n_columns) and (n_equations, n_rows), one for every `step`-th sample; `ends` the samples before the first row and
    behind the last.
    """
    passed = low_pass.zero_phase(sampling_frequency)
    n_rows = rows[1].shape[1]
    inner = np.arange(min(math.ceil(_PERIODS * sampling_frequency / low_pass.cutoff_hz / step), n_rows))
    transients = passed.transients(inner * float(step))
    for outside, near in zip(ends, (inner, n_rows - 1 - inner), strict=True):
        if np.abs(passed.transients(np.array([float(outside)]))).max() < _FORGOTTEN:
            continue
        for W, y, usable in zip(*rows, strict=True):
            used = usable[near]
            spoiled = np.flatnonzero(_stands_out(W[near[used]], y[near[used]], transients[used]))
            usable[near[used][: spoiled.max(initial=-1) + 1]] = False


def _stands_out(W: FloatArray, y: FloatArray, transients: FloatArray) -> BoolArray:
    """Rows of an equation in which the transient of an end, a sum of columns, is not small against the residual."""
    columns = np.concatenate((W, transients), axis=1)
    if len(columns) < _ROWS_EACH * columns.shape[1]:
        return np.zeros(len(columns), dtype=bool)
    # An equation need not hold all parameters, and filters leave some rounding between columns that depend on others.
    factors = least_squares(columns, y, rcond=_DEPENDENT)
    left = y - columns @ factors
    rms = math.sqrt(float(left @ left) / (len(columns) - columns.shape[1]))
    rms = max(rms, _EXACT * math.sqrt(float(y @ y) / y.size))
    added = np.abs(transients @ factors[W.shape[1] :])
    return np.asarray((added > _FADED * rms) & (added.max() > _STANDS_OUT * rms))
