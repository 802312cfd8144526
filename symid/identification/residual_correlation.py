"""Auto-correlation of a residual, and its cross-correlation with the prediction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from symid.arrays import BoolArray, FloatArray
from symid.identification.identification_result import Identification
from symid.text import visible

MOST_LAGS = 40
_BAND = float(scipy.special.ndtri(0.995))
"""Half width of the 99 % band of a white residual, in deviations."""


@dataclass(frozen=True, eq=False)
class Correlation:
    """Correlation of a residual with itself or with another signal, by lag in rows, positive where it comes later.

    99 % of the values of an independent residual lie within `band` of 0.
    """

    lag: FloatArray
    value: FloatArray
    band: FloatArray

    @property
    def outside(self) -> float:
        """Share of the values outside the band, that at lag 0 of an auto-correlation left out."""
        counted = ~((self.lag == 0) & (self.value == 1.0))
        return float(np.mean(np.abs(self.value[counted]) > self.band[counted]))


def correlation(residual: FloatArray, other: FloatArray, used: BoolArray, lags: Sequence[int]) -> Correlation:
    """Correlation of a residual with itself or another signal, over the pairs of rows that are both used.

    Their means over the rows used are taken off. Lags are in rows, shorter than the log.

    >>> x = np.random.default_rng(0).standard_normal(2000)
    >>> found = correlation(x, x, np.ones(2000, bool), range(0, 21))
    >>> float(found.value[0]), found.outside
    (1.0, 0.0)
    """
    n = residual.size
    first = np.where(used, residual - residual[used].mean(), 0.0)
    second = np.where(used, other - other[used].mean(), 0.0)
    size = float(np.sqrt(np.sum(first**2) * np.sum(second**2)))
    # Rows that are left out count as 0 and do not enter the number of pairs, on which the band depends.
    value, pairs = np.zeros(len(lags)), np.zeros(len(lags))
    for place, lag in enumerate(lags):
        late, early = slice(max(lag, 0), n + min(lag, 0)), slice(max(-lag, 0), n - max(lag, 0))
        pairs[place] = np.sum(used[late] & used[early])
        value[place] = np.sum(first[late] * second[early]) / size if size else 0.0
    return Correlation(np.array(lags, dtype=float), value, _BAND * np.sqrt(pairs) / used.sum())


def residual_correlations(found: Identification) -> list[tuple[str, Correlation, Correlation]]:
    """Auto- and cross-correlation of the residual of each equation of each log, by the title of its part."""
    parts = []
    for source, run in zip(found.logs, found.observations, strict=True):
        predicted = run.W @ found.fit.solution
        for j, output in enumerate(found.model.output_names):
            residual, used = run.y[j] - predicted[j], run.valid[j]
            most = min(MOST_LAGS, used.size // 4)
            if used.sum() < 4 or most < 1:
                continue
            own = correlation(residual, residual, used, range(most + 1))
            across = correlation(residual, predicted[j], used, range(-most, most + 1))
            parts.append((visible(f"{output}, {source}"), own, across))
    return parts
