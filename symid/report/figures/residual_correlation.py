"""Auto-correlation of a residual, and its cross-correlation with the prediction."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from symid.arrays import BoolArray, FloatArray
from symid.text import visible

MOST_LAGS = 40
_BAND = float(scipy.special.ndtri(0.995))
"""Half width of the 99 % band of a white residual, in deviations."""


@dataclass(frozen=True, eq=False)
class Correlation:
    """Correlation of a residual with itself or with another signal, by lag in rows, positive where it comes later.

    99 % of the values of a residual of noise alone lie within `band` of `of_noise`, which is 0 where noise is white.
    """

    lag: FloatArray
    value: FloatArray
    of_noise: FloatArray
    band: FloatArray

    @property
    def outside(self) -> float:
        """Share of the values outside the band, without lag 0 of an auto-correlation."""
        counted = ~((self.lag == 0) & (self.value == 1.0))
        return float(np.mean(np.abs(self.value - self.of_noise)[counted] > self.band[counted]))


def correlation(
    residual: FloatArray,
    other: FloatArray,
    used: BoolArray,
    lags: Sequence[int],
    noise: FloatArray | None = None,
) -> Correlation:
    """Correlation of a residual with itself or another signal, over the pairs of rows that are both used.

    Their means over the rows used are subtracted. Lags are in rows, shorter than the log. `noise` is the
    auto-correlation of the noise by lag, from 0 on, where it is not white. The variance of a correlation is then that
    of M. S. Bartlett (Supplement to the Journal of the Royal Statistical Society 8, 1946): the sum over all lags of the
    product of both auto-correlations, divided by the number of rows.

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
    of_noise, spread = np.zeros(len(lags)), 1.0
    if noise is not None:
        if other is residual:
            of_noise, own = noise[np.abs(lags)], noise
        else:
            own = _own_correlation(second, used, noise.size)
        spread = max(1.0, float(noise[0] * own[0] + 2 * noise[1:] @ own[1:]))
    return Correlation(
        np.array(lags, dtype=float), value, of_noise, _BAND * np.sqrt(spread * pairs) / used.sum()
    )


def _own_correlation(values: FloatArray, used: BoolArray, n: int) -> FloatArray:
    """Auto-correlation of values, whose mean is 0 and which are 0 where no row is used, at lags 0 to n - 1."""
    whole = scipy.signal.correlate(values, values, method="fft")[values.size - 1 :]
    return np.asarray((whole / max(whole[0], np.finfo(float).tiny))[:n])


@dataclass(frozen=True, eq=False)
class PredictedOutput:
    """An output of a log as measured and as predicted, in rows of which some are used."""

    name: str  # of the output
    log: str  # source of the log
    unit: str
    measured: FloatArray
    predicted: FloatArray
    used: BoolArray

    @property
    def residual(self) -> FloatArray:
        """Measured less predicted output."""
        return self.measured - self.predicted


class OutputCorrelations(NamedTuple):
    """Correlations of the residual of an output."""

    title: str  # of the output
    own: Correlation  # with itself
    across: Correlation  # with the prediction


def residual_correlations(outputs: Sequence[PredictedOutput]) -> list[OutputCorrelations]:
    """Correlations of the residual of each output that has enough rows."""
    parts = []
    for output in outputs:
        most = min(MOST_LAGS, output.used.size // 4)
        if output.used.sum() < 4 or most < 1:
            continue
        with_itself = correlation(output.residual, output.residual, output.used, range(most + 1))
        across = correlation(output.residual, output.predicted, output.used, range(-most, most + 1))
        parts.append(OutputCorrelations(visible(f"{output.name}, {output.log}"), with_itself, across))
    return parts
