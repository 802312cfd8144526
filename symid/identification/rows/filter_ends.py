"""Rows near the ends of a log that are spoiled by the start of its filter.

A filter continues what lies outside of a log, wrongly where motion does not rest there. What that adds to each row
decays with the poles p of the filter: a sum of c p^k at k samples from the end. All columns of W and y have passed the
same filter, so that the residual holds one such transient at each end. It is fitted beside the parameters to the rows
next to the end, and rows in which it stands out of their residual are left out.
"""

from __future__ import annotations

import math

import numpy as np

from symid.arrays import BoolArray, FloatArray, least_squares
from symid.data import LowPass

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


def leave_out_spoiled(
    low_pass: LowPass,
    sampling_frequency: float,
    rows: tuple[FloatArray, FloatArray, BoolArray],
    ends: tuple[FloatArray, FloatArray],
) -> None:
    """Mark the rows as not usable in which a transient of one of the ends stands out.

    All columns have passed the filter `low_pass`. `rows` are W, y and usable, of shapes (n_equations, n_rows,
    n_columns) and (n_equations, n_rows); `ends` the samples from the first one of the log to each row, and from each
    row to the last.
    """
    passed = low_pass.zero_phase(sampling_frequency)
    reach = _PERIODS * sampling_frequency / low_pass.cutoff_hz
    for distance, way in zip(ends, (1, -1), strict=True):
        near = np.flatnonzero(distance < distance.min() + reach)[::way]
        places = distance[near]
        if np.abs(passed.transients(places[:1])).max() < _FORGOTTEN:
            continue
        transients = passed.transients(places - places[0])
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
