"""Detection of sensors whose reading is in proportion to the predicted one, but not the same: a wrong gain."""

from __future__ import annotations

import numpy as np

from symid.diagnosis.fitting.fit import Fit

_LEVEL = 10.0
"""Error of a reading in multiples of its noise below which its gain is not doubted."""
_OFF = 0.03
"""Least relative error of a gain."""
_ALL_OF_IT = 0.95
"""Share of the power of the error that a wrong gain takes away: effects of the machine are not in proportion."""


def wrong_gain(fit: Fit) -> str:
    """Sentence if another gain of a sensor removes nearly all of its error; otherwise empty."""
    prediction, weighting = fit.state.prediction, fit.weighting
    record, levels = prediction.record, prediction.levels
    if not levels:
        return ""
    rows = weighting.rows(np.stack([record.measured, prediction.outputs]))[..., weighting.kept]
    for name, level, read, predicted in zip(
        record.readings, levels[record.n_drives :], *rows[:, record.n_drives :], strict=True
    ):
        power = float(read @ read)
        if level < _LEVEL or not power:
            continue
        factor = float(read @ predicted) / power
        before, after = (float(np.sum((predicted - x * read) ** 2)) for x in (1.0, factor))
        if abs(factor - 1.0) > _OFF and after < (1.0 - _ALL_OF_IT) * before:
            return (
                f"{name} would have to be {factor:.3g} times as large to agree with the other signals: its unit or "
                "gain is wrong, or a ratio of the axis"
            )
    return ""
