"""Agreement of the logs of a joint estimate: the parameters of each log alone are those of all logs together.

A joint estimate is a mean, weighted by what each log knows. A log of another machine, or with another gain, moves it
without a trace in the residual where that log knows most. Estimates from one log and from all are compared as those of
J. A. Hausman (Econometrica 46, 1978).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray
from symid.identification.criteria import CRITERIA, Criteria


@dataclass(frozen=True, eq=False)
class LogEstimate:
    """Parameters of some logs, and their standard deviations as printed."""

    log: str
    values: Mapping[str, float]
    deviations: FloatArray

    def difference(self, alone: LogEstimate, criteria: Criteria = CRITERIA) -> tuple[float, str]:
        """Largest difference of one log's own parameters, in deviations, and its statement; 0 for small ones."""
        found = (0.0, "")
        for name, std in zip(alone.values, alone.deviations, strict=True):
            joint, own = self.values.get(name, np.nan), alone.values[name]
            # the variance of the difference is that of the log alone less that of all, which the difference widens
            certain = abs(own - joint) / std if std else np.inf
            if certain > found[0] and abs(own - joint) > criteria.log_change * abs(joint):
                found = float(certain), f"{name} is {own:.4g} in {alone.log}, {joint:.4g} in all logs"
        return found


def disagreement_between(
    joint: LogEstimate, alone: Sequence[LogEstimate], criteria: Criteria = CRITERIA
) -> str:
    """Statement on the log whose own parameters differ most from those of all logs; empty where all agree."""
    certain, statement = max((joint.difference(one, criteria) for one in alone), default=(0.0, ""))
    # the largest of many differences is large by chance: its square grows with twice the logarithm of their number
    if certain**2 < criteria.log_certain**2 + 2 * np.log(max(len(alone), 1)):
        return ""
    return f"{statement}: gain, payload or machine differ between the logs, or one is damaged; identify each alone"
