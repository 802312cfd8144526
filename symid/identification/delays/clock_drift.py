"""Drift of two clocks against each other: a delay that grows along the logs.

A drift by several rows changes the best lag between the thirds of the logs. A smaller one is tested at the constant
delay found before, where the residual no longer depends on a delay to second order: the derivative of the residual by
the delay, times the time within the log, is one more column. Its deviation is that of the scatter between blocks of
the logs, so that every unmodelled effect counts as noise from block to block (K.-Y. Liang and S. Zeger, Biometrika
73, 1986).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from symid.arrays import FloatArray, unexplained_by
from symid.data.quality import CLOCK_DIFFERENCE
from symid.estimation import LeastSquares
from symid.identification.criteria import CRITERIA
from symid.identification.delays.lag_scan import scan
from symid.identification.delays.refined_delay import Shifting
from symid.identification.delays.timing import Timing
from symid.identification.rows.excerpts import Excerpt, course_of

_WORST_CLOCK = 0.02
"""Largest relative difference of two clocks; a delay that grows faster has another cause."""
_BLOCKS = 12
"""Number of blocks of all logs together; each part has at least 3."""
_LINE = 2
"""Parameters of a line through the delays of blocks."""
_DRIFTED_ROWS = 2
"""Rows by which the delays of two thirds must differ: noise moves them by one."""
_APART = 2 / 3
"""Part of a log between the middles of its first and last third."""
_UNEVEN = 0.2
"""Part of their difference by which the delay of the middle third may differ from the mean of the others."""
_SEVERAL = 2.0
"""Blocks in which a delay must show, by their power: an error at one event of a log is no drift of a clock."""
_CHANGED = 1e-3
"""Share of a force's changes that each third of the logs must hold, to show a delay."""
_FASTER = 1.5
"""Ratio of the frequencies of two thirds of a log from which on other effects delay them differently."""
_INDEPENDENT = 1e-8
"""Least share of the growth column's power that is linearly independent of the other columns."""


class _Growth(NamedTuple):
    """Growth of a delay, s, its deviation, and the share of the residual's power that it explains."""

    seconds: float = 0.0
    deviation: float = 0.0
    explained: float = 0.0


def drift_by_rows(parts: Sequence[Excerpt], fit: LeastSquares, forces: Sequence[str]) -> str:
    """Statement on a force whose delay grows by whole rows over the thirds of the logs; empty without one."""
    row = parts[0].log.sampling_period * (parts[0].observation.preparation.decimation or 1)
    for force in forces:
        frequencies, shares = _changes(parts, force)
        if min(shares) < _CHANGED:
            continue
        thirds = [scan(parts, fit, (force,), (k,)).best for k in range(3)]
        first, middle, last = (lag.late for lag in thirds)
        grows = abs(first - last) >= _DRIFTED_ROWS * row
        is_even = abs(2 * middle - first - last) <= _DRIFTED_ROWS * row + _UNEVEN * abs(last - first)
        lags, lefts = np.abs([first, middle, last]), np.array([lag.left for lag in thirds])
        better = (
            np.all((lags <= row) | (lefts < CRITERIA.delay_leaves))
            and lefts[np.argmax(lags)] < CRITERIA.delay_leaves
        )
        if grows and is_even and better:
            length = np.mean([part.log.n_samples * part.log.sampling_period for part in parts])
            rate = abs(last - first) / (_APART * length)
            cause = (
                f"its clock runs at another rate (by {100 * rate:.2g} %); resample it by its own time stamps"
            )
            if max(frequencies) > _FASTER * min(frequencies) or rate > CLOCK_DIFFERENCE:
                cause = f"the model lacks an effect, such as friction, a flexibility or a lag, or {cause}"
            late = f"{1e3 * first:.3g} ms late in the first third and {1e3 * last:.3g} ms in the last"
            return f"{force} is {late}: {cause}"
    return ""


def _changes(parts: Sequence[Excerpt], force: str) -> tuple[FloatArray, FloatArray]:
    """Rms of the changes of a force relative to its own in each third of the logs, and their share of all."""
    changes, power = np.zeros(3), np.zeros(3)
    for part in parts:
        for k, x in enumerate(np.array_split(part.log[force], 3)):
            step, apart = np.diff(x), x - x.mean()
            changes[k] += step @ step
            power[k] += apart @ apart
    tiny = np.finfo(float).tiny
    return np.sqrt(changes / np.maximum(power, tiny)), changes / max(float(changes.sum()), tiny)


def drift_within_a_row(parts: Sequence[Excerpt], fit: LeastSquares, delays: Sequence[Timing]) -> str:
    """Statement on a delay that grows along the logs by less than a row; empty without one."""
    period = parts[0].log.sampling_period
    longest = _WORST_CLOCK * period * max(part.log.n_samples for part in parts)
    for delay in delays:
        growth = _growth(parts, fit, delay)
        size = abs(growth.seconds)
        is_certain = size > CRITERIA.clock_certain * growth.deviation
        matters = growth.explained > CRITERIA.clock_explains and size > CRITERIA.clock_drift * period
        if is_certain and matters and size < longest:
            return (
                f"the time of {' and '.join(delay.moved)} drifts by {growth.seconds / period:+.2g} samples from the "
                "start to the end of the log against the other signals: clocks run at different rates; resample by "
                "their own time stamps"
            )
    return ""


def _growth(parts: Sequence[Excerpt], fit: LeastSquares, delay: Timing) -> _Growth:
    """Growth of a delay from the start to the end of the logs, beside its mean and parameters that drift."""
    rows, growing, blocks = [], [], []
    each = max(3, round(_BLOCKS / len(parts)))
    for k, part in enumerate(parts):
        late = delay.late if delay.signal in delay.moved else -delay.late
        seen = Shifting(part, delay.moved).with_tangent(late, delay.parameters)
        course = course_of(parts, part)
        place = each * k + np.arange(seen.time.size) * each // seen.time.size
        for j, used in enumerate(seen.valid):
            weight = fit.weights[part.of * len(seen.valid) + j]
            rows.append(weight * np.column_stack([seen.W[j], seen.y[j]])[used])
            growing.append(rows[-1][:, :-1] * course[used, None])
            blocks.append(place[used])
    # Frisch, Waugh and Lovell: the column and the output without what the mean delay and the parameters explain, which
    # may drift themselves, as friction does that warms up; their ratio is the growth. Its deviation comes from the
    # scatter of sums over blocks, as residuals are correlated.
    every, drifting, block = np.concatenate(rows), np.concatenate(growing), np.concatenate(blocks)
    column, columns = drifting[:, -1], np.column_stack([every[:, :-1], drifting[:, :-1]])
    own, left = unexplained_by(columns, np.column_stack([column, every[:, -1]])).T
    power = float(own @ own)
    if power <= _INDEPENDENT * float(column @ column):
        return _Growth()
    shown = np.bincount(block, own**2)
    if power**2 < _SEVERAL * float(shown @ shown):
        return _Growth()
    growth = float(own @ left) / power
    sums = np.bincount(block, own * (left - growth * own))
    n = np.unique(block).size
    deviation = np.sqrt(float(sums @ sums) * n / max(n - _LINE, 1)) / power
    explained = growth**2 * power / max(float(left @ left), np.finfo(float).tiny)
    return _Growth(growth, float(deviation), explained)
