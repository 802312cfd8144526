"""Spread of a parameter between runs, compared with the intervals of the runs.

The value of run i is x_i = mu + b_i + e_i, where e_i has the standard deviation s_i stated by the identification and
b_i the variance tau^2 between runs. Test, estimate and interval of tau^2 follow from the generalised statistic

    Q(tau^2) = sum_i w_i (x_i - mean)^2,  w_i = 1 / (s_i^2 + tau^2),  mean = sum w_i x_i / sum w_i,

which is chi-square with K - 1 degrees of freedom at the true tau^2. Q(0) is Cochran's test of heterogeneity (1954).
Q(tau^2) = K - 1 is the estimate of Paule and Mandel (1982), which assumes no distribution of b. The values of tau^2 at
which Q is a quantile of its distribution are its confidence limits (Q-profile, Viechtbauer 2007). Veroniki et al.
(2016) recommend both. The deviation of the mean is that of Hartung and Knapp (2001). Several parameters are tested
together by Holm's step-down procedure (1979), which is valid for any dependence between them.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy

from symid.arrays import FloatArray
from symid.errors import SettingError

_LEAST_RUNS = 3
"""Smallest number of runs for a spread."""
_TAIL = 0.025
_LEAST_SHARE = 0.1
"""Variance between runs that counts, relative to the stated one, which has an accuracy of some 5 %."""
_FALSE = 0.01
"""Probability that an axis is called different although no parameter of it differs."""


@dataclass(frozen=True)
class Spread:
    """One parameter over several runs. All fields except probability and Q have the unit of the parameter."""

    runs: int
    """Number of runs with a value and a deviation."""
    mean: float
    """Mean over the runs."""
    mean_std: float
    """Its standard deviation by Hartung and Knapp."""
    between: float
    """Standard deviation between runs, tau; 0 if the intervals explain all scatter."""
    between_interval: tuple[float, float]
    """95 % interval of `between`."""
    promised: float
    """Typical standard deviation of a run as stated by its interval (Higgins and Thompson, 2002)."""
    statistic: float
    """Cochran's Q, chi-square with `runs` - 1 degrees of freedom if runs do not differ."""
    probability: float
    """Probability of a Q at least as large if runs do not differ; nan below three runs."""

    @property
    def relative_between(self) -> float:
        """Standard deviation between runs relative to the mean; nan if that is 0."""
        return self.between / abs(self.mean) if self.mean else math.nan

    @property
    def relative_promised(self) -> float:
        """Stated standard deviation relative to the mean; nan if that is 0."""
        return self.promised / abs(self.mean) if self.mean else math.nan

    @property
    def exceeds_tolerance(self) -> bool:
        """Whether the variance between runs exceeds a tenth of the stated one, at its lower confidence limit."""
        return self.between_interval[0] ** 2 > _LEAST_SHARE * self.promised**2

    @property
    def share(self) -> float:
        """Share of the variance between runs in that of one run, I^2."""
        total = self.between**2 + self.promised**2
        return self.between**2 / total if total > 0 else 0.0


@dataclass(frozen=True)
class SpreadVerdict:
    """Whether an axis is the same from run to run."""

    differs: bool  # whether a parameter differs beyond its intervals
    parameters: tuple[str, ...]  # parameters that differ, the one with the largest share first
    sentence: str  # verdict in words
    probabilities: Mapping[str, float]  # probabilities adjusted for the number of parameters (Holm)


def robust_deviation(values: FloatArray) -> float:
    """Robust standard deviation, from the median absolute deviation.

    >>> import numpy as np
    >>> round(robust_deviation(np.array([1.0, 2.0, 3.0, 1000.0])), 2)
    1.48
    """
    return 1.4826 * float(np.median(np.abs(values - np.median(values))))


def spread_between(values: npt.ArrayLike, deviations: npt.ArrayLike) -> Spread:
    """Spread of a parameter between runs, those without a finite value or a positive deviation left out.

    Ten runs with a stated deviation of 0.1 and a larger scatter:

    >>> import numpy as np
    >>> values = 5 + np.array([0.4, -0.5, 0.1, 0.6, -0.3, -0.2, 0.5, -0.6, 0.2, -0.2])
    >>> found = spread_between(values, np.full(10, 0.1))
    >>> round(found.mean, 2), round(found.between, 2), found.probability < 1e-6
    (5.0, 0.41, True)
    """
    x, s = np.asarray(values, dtype=np.float64), np.asarray(deviations, dtype=np.float64)
    if x.ndim != 1 or x.shape != s.shape:
        raise SettingError(f"values of shape {x.shape}, deviations {s.shape}: one of each for each run")
    known = np.isfinite(x) & np.isfinite(s) & (s > 0)
    x, s = x[known], s[known]
    if x.size < _LEAST_RUNS:
        return _without_spread(x, s)
    freedom = x.size - 1
    # In units of the mean deviation, squares of very small parameters do not underflow.
    unit = float(np.exp(np.mean(np.log(s))))
    x, variance = x / unit, (s / unit) ** 2
    tau2 = variance_at(x, variance, freedom)
    tails = [float(scipy.special.chdtri(freedom, tail)) for tail in (_TAIL, 1 - _TAIL)]
    ends = [variance_at(x, variance, quantile) for quantile in tails]
    low, high = (math.sqrt(end) * unit for end in ends)
    weights = 1 / (variance + tau2)
    mean = float(weights @ x / weights.sum())
    excess = max(float(weights @ (x - mean) ** 2) / freedom, 1.0)
    Q = generalised_statistic(x, variance, 0.0)
    w = 1 / variance
    typical = float((w.size - 1) * w.sum() / (w.sum() ** 2 - w @ w))  # Higgins and Thompson, 2002
    return Spread(
        runs=int(x.size),
        mean=mean * unit,
        mean_std=math.sqrt(excess / weights.sum()) * unit,
        between=math.sqrt(tau2) * unit,
        between_interval=(low, high),
        promised=math.sqrt(typical) * unit,
        statistic=Q,
        probability=float(scipy.special.chdtrc(freedom, Q)),
    )


def generalised_statistic(x: FloatArray, variance: FloatArray, between: float) -> float:
    """Q of values with their stated variances, at a variance between runs.

    >>> import numpy as np
    >>> generalised_statistic(np.array([0.0, 2.0]), np.ones(2), 1.0)
    1.0
    """
    weights = 1 / (variance + between)
    mean = weights @ x / weights.sum()
    return float(weights @ (x - mean) ** 2)


def variance_at(x: FloatArray, variance: FloatArray, target: float) -> float:
    """Variance between runs at which Q equals a target; 0 if Q(0) is below it.

    >>> import numpy as np
    >>> round(variance_at(np.array([0.0, 2.0]), np.ones(2), 1.0), 9)
    1.0
    """
    high = float(np.sum((x - x.mean()) ** 2)) / target + float(variance.max())  # Q is below the target there
    return variance_where_zero(lambda tau2: generalised_statistic(x, variance, tau2) - target, high)


def variance_where_zero(excess: Callable[[float], float], high: float) -> float:
    """Zero of a decreasing function of a variance below `high`; 0 if the function is not positive at 0.

    >>> round(variance_where_zero(lambda tau2: 3.0 - tau2, 10.0), 9), variance_where_zero(lambda tau2: -1.0, 10.0)
    (3.0, 0.0)
    """
    return 0.0 if excess(0.0) <= 0 else float(scipy.optimize.brentq(excess, 0.0, high, xtol=1e-12 * high))


def judge_spread(spreads: Mapping[str, Spread]) -> SpreadVerdict:
    """Whether the axis differs from run to run, and in which parameters.

    A variance between runs below a tenth of the stated one never counts as a difference: it would be significant with
    thousands of runs, but intervals are not that accurate.

    >>> import numpy as np
    >>> noise = np.random.default_rng(3).standard_normal((2, 40))
    >>> steady = spread_between(20 + 0.1 * noise[0], np.full(40, 0.1))
    >>> loose = spread_between(50 + 2.0 * noise[1], np.full(40, 0.4))
    >>> judge_spread({"M": steady, "Fs": loose}).sentence
    'the axis differs from run to run, in Fs: 4 % between runs where the intervals promise 0.8 %'
    >>> judge_spread({"M": steady}).sentence
    'within noise: 40 runs scatter as their intervals promise'
    """
    known = {name: spread for name, spread in spreads.items() if math.isfinite(spread.probability)}
    if not known:
        most = max((spread.runs for spread in spreads.values()), default=0)
        sentence = f"not known: {most} runs with intervals; {_LEAST_RUNS} are required"
        return SpreadVerdict(False, (), sentence, {})
    adjusted = dict(zip(known, _holm([spread.probability for spread in known.values()]), strict=True))
    differing = [n for n in known if adjusted[n] < _FALSE and known[n].exceeds_tolerance]
    differing.sort(key=lambda name: -known[name].share)
    if not differing:
        runs = max(spread.runs for spread in known.values())
        sentence = f"within noise: {runs} runs scatter as their intervals promise"
        return SpreadVerdict(False, (), sentence, adjusted)
    sizes = "; ".join(_size(name, known[name]) for name in differing)
    sentence = f"the axis differs from run to run, in {sizes}"
    return SpreadVerdict(True, tuple(differing), sentence, adjusted)


def _size(name: str, spread: Spread) -> str:
    """A spread in percent, or in the unit of the parameter if the mean may be 0."""
    if abs(spread.mean) > 2 * math.hypot(spread.between, spread.promised):
        sizes = [f"{100 * size:.2g} %" for size in (spread.relative_between, spread.relative_promised)]
    else:
        sizes = [f"{size:.2g}" for size in (spread.between, spread.promised)]
    return f"{name}: {sizes[0]} between runs where the intervals promise {sizes[1]}"


def _without_spread(x: FloatArray, s: FloatArray) -> Spread:
    nan = math.nan
    if not x.size:
        return Spread(0, nan, nan, nan, (nan, nan), nan, nan, nan)
    weights = (s.min() / s) ** 2
    mean, std = float(weights @ x / weights.sum()), float(s.min() / math.sqrt(weights.sum()))
    promised = float(np.sqrt(np.mean((s / s.max()) ** 2)) * s.max())
    return Spread(int(x.size), mean, std, nan, (nan, nan), promised, nan, nan)


def _holm(probabilities: Sequence[float]) -> FloatArray:
    """Probabilities adjusted for their number, monotone in their order."""
    order = np.argsort(probabilities)
    stepped = np.array(probabilities)[order] * np.arange(len(order), 0, -1)
    adjusted = np.empty(len(order))
    adjusted[order] = np.minimum(np.maximum.accumulate(stepped), 1.0)
    return adjusted
