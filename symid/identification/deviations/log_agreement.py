"""Agreement of the logs of a joint estimate: the parameters of each log alone are those of the other logs.

A joint estimate is a mean, weighted by what each log knows. A log of another machine, or with another gain, moves it
without a trace in the residual where that log knows most. The estimate of each log is compared with the mean of the
others, weighted by the inverse of their variances.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray
from symid.identification.criteria import CRITERIA


@dataclass(frozen=True, eq=False)
class LogEstimate:
    """Physical parameters of a log alone, in the order of the model, and their standard deviations as printed."""

    log: str
    values: FloatArray
    deviations: FloatArray


def disagreement_between(names: Sequence[str], alone: Sequence[LogEstimate]) -> str:
    """Statement on the log whose own parameters differ most from those of the others; empty where all agree.

    >>> masses = {"a": 5.0, "b": 6.0, "c": 5.1}
    >>> logs = [LogEstimate(log, np.array([M]), np.array([0.1])) for log, M in masses.items()]
    >>> disagreement_between(["M"], logs)[:36]
    'M is 6 in b, 5.05 in the other logs:'
    >>> disagreement_between(["M"], logs[::2])
    ''
    """
    if len(alone) < 2:
        return ""
    own = np.array([one.values for one in alone])
    precision = np.array([one.deviations for one in alone]) ** -2.0
    precision = np.where(np.isfinite(own) & np.isfinite(precision), precision, 0.0)
    own = np.where(precision > 0.0, own, 0.0)
    rest = np.sum(precision, axis=0) - precision
    with np.errstate(invalid="ignore", divide="ignore"):
        others = (np.sum(precision * own, axis=0) - precision * own) / rest
        certain = np.abs(own - others) / np.sqrt(1 / precision + 1 / rest)
    large = np.abs(own - others) > CRITERIA.log_change * np.abs(others)
    certain = np.where(large, np.nan_to_num(certain), 0.0)
    k, i = divmod(int(np.argmax(certain)), certain.shape[1])
    # the largest of many differences is large by chance: its square grows with twice the logarithm of their number
    if certain[k, i] ** 2 < CRITERIA.log_certain**2 + 2 * np.log(len(alone)):
        return ""
    return (
        f"{names[i]} is {own[k, i]:.4g} in {alone[k].log}, {others[k, i]:.4g} in the other logs: "
        "gain, payload or machine differ between the logs, or one is damaged; identify each alone"
    )
