"""Probabilities of what was considered, and the verdict.

The gain of a candidate in the logarithm of the likelihood would be the logarithm of its odds if the model were exact
but for noise. It is not: the laws of a real axis, and of another simulator, differ a little from ours. Gains are
therefore tempered by a share of the largest one: candidates that explain nearly the same are nearly as probable.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symid.diagnosis.search import LEAST_WORTH, Turn

_TEMPERED_SHARE = 0.004
_DRIVEN_BONUS = 0.3
_PRIOR = {"asymmetric_friction": -1.0}
"""An asymmetry of the Coulomb level alone is a constant force while the axis moves; the simpler name goes first."""
_UNEXPLAINED_AT = 0.75
_UNEXPLAINED_WIDTH = 0.05
_NOISE_ALONE = 1.25
_NOMINAL_IS_GOOD = 1.1
INDISTINGUISHABLE = 0.15
"""Probability from which on a candidate counts as not told apart from the best."""

Key = tuple[str, str]


def odds(turn: Turn, driven: str) -> dict[Key, float]:
    """Probability of each candidate of a turn, if one of them is right.

    Parameters
    ----------
    turn : Turn
        Of the search.
    driven : str
        Body that the drive moves: where places cannot be told apart, it is a little more likely.
    """
    worth = {c.key: c.worth for c in turn.confirmed}
    for candidate in turn.screened:
        worth.setdefault(candidate.placed.key, min(candidate.worth, min(worth.values(), default=0.0)))
    if not worth:
        return {}
    best = max(worth.values())
    logits = {
        key: (value - best) / temperature(best) + _DRIVEN_BONUS * (key[1] == driven) + _PRIOR.get(key[0], 0.0)
        for key, value in worth.items()
    }
    total = math.fsum(math.exp(x) for x in logits.values())
    return dict(sorted(((k, math.exp(x) / total) for k, x in logits.items()), key=lambda item: -item[1]))


def temperature(best: float) -> float:
    """By what gains are divided where the best candidate gains so much."""
    return 1 + _TEMPERED_SHARE * max(best, 0.0)


def is_there(turn: Turn) -> float:
    """Probability that the best candidate of a turn is more than noise."""
    if not turn.confirmed:
        return 0.0
    return _logistic((turn.confirmed[0].worth - LEAST_WORTH) / 4)


@dataclass(frozen=True)
class Outcome:
    """Probabilities of the verdicts, adding up to 1.

    Parameters
    ----------
    no_gap, parameters, effect, unexplained : float
        Probabilities.
    """

    no_gap: float
    parameters: float
    effect: float
    unexplained: float

    @property
    def verdict(self) -> str:
        """The most probable."""
        found = self.as_mapping
        return max(found, key=lambda name: found[name])

    @property
    def as_mapping(self) -> Mapping[str, float]:
        """By name."""
        return {
            "no_gap": self.no_gap,
            "parameters": self.parameters,
            "effect": self.effect,
            "unexplained": self.unexplained,
        }


def outcome(
    turns: Sequence[Turn], upheld: int, nominal: float | None, reidentified: float, explained: float
) -> Outcome:
    """Probabilities of the verdicts.

    Parameters
    ----------
    turns : sequence of Turn
        Of the search.
    upheld : int
        How many of the effects accepted hold on the validation data.
    nominal, reidentified, explained : float
        Force errors on the validation data in multiples of the noise; nominal is None if no values are given.
    """
    if not np.isfinite([reidentified, explained]).all():
        return Outcome(0.0, 0.0, 0.0, 1.0)
    there = is_there(turns[0]) if turns else 0.0
    if not upheld:
        there = min(there, 0.1)
    left = _left_over(reidentified, explained)
    good = (
        1.0
        if nominal is None
        else _logistic((math.log(_NOMINAL_IS_GOOD) - math.log(nominal / min(reidentified, nominal))) / 0.03)
    )
    fits = _logistic((math.log(1.6) - math.log(max(reidentified, 1e-9))) / 0.08)
    plain = (1 - there) * fits
    return Outcome(
        no_gap=plain * good,
        parameters=plain * (1 - good),
        effect=there * (1 - left),
        unexplained=there * left + (1 - there) * (1 - fits),
    )


def _left_over(reidentified: float, explained: float) -> float:
    """Probability that what is left after the effects is more than a rough explanation of the same thing."""
    if explained <= _NOISE_ALONE or reidentified <= _NOISE_ALONE:
        return 0.02
    closed = (reidentified - explained) / (reidentified - 1)
    return 0.02 + 0.96 * _logistic((_UNEXPLAINED_AT - closed) / _UNEXPLAINED_WIDTH)


def _logistic(x: float) -> float:
    return float(1 / (1 + np.exp(-np.clip(x, -40, 40))))
