"""Which effects explain what the re-identified model leaves: screened, confirmed, accepted one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symid.diagnosis.effects import Effect
from symid.diagnosis.fit import Fit, fitted, refitted, with_effects
from symid.diagnosis.screening import PRICE, Candidate, screened
from symid.diagnosis.weighting import Weighting
from symid.errors import SettingError

LEAST_WORTH = 20.0
"""Gain of the logarithm of the likelihood, less its price, that an effect must bring: the best of all places and shapes
brings less in noise alone."""
LEAST_SHARE = 0.02
"""Share of the mean square that it must take away."""
_LEAST_POWER = 0.06
_CONFIRMED = 5
_CONFIRMED_WHITE = 3
_MOST_EFFECTS = 3
_ITERATIONS = 8


@dataclass(frozen=True, eq=False)
class Confirmed:
    """A candidate fitted with all parameters free.

    Parameters
    ----------
    fit : Fit
        The model with it.
    gain : float
        Of the logarithm of the likelihood over the model without it.
    """

    fit: Fit
    gain: float

    @property
    def worth(self) -> float:
        """The gain, less what its free values would gain in noise."""
        return self.gain - PRICE * self.fit.state.placed[-1].n_free

    @property
    def key(self) -> tuple[str, str]:
        """Names of effect and place."""
        return self.fit.state.placed[-1].key


@dataclass(frozen=True, eq=False)
class Turn:
    """One turn of the search.

    Parameters
    ----------
    before : Fit
        The model without the effect of this turn.
    confirmed : tuple of Confirmed
        Candidates that were fitted, the largest gain first.
    screened : tuple of Candidate
        All candidates.
    """

    before: Fit
    confirmed: tuple[Confirmed, ...]
    screened: tuple[Candidate, ...]

    @property
    def accepts(self) -> bool:
        """Whether the best candidate is worth its acceptance."""
        if not self.confirmed:
            return False
        best = self.confirmed[0]
        closed = 1 - best.fit.mean_square / self.before.mean_square
        return best.worth > LEAST_WORTH and closed > LEAST_SHARE

    @property
    def is_worth_another(self) -> bool:
        """Whether the best candidate is worth being accepted besides others."""
        if not self.accepts:
            return False
        return self.before.mean_square - self.confirmed[0].fit.mean_square > _LEAST_POWER


def search(fit: Fit, library: Sequence[Effect]) -> tuple[Turn, ...]:
    """Turns of the search: the first, and those that accept their best candidate after it.

    Parameters
    ----------
    fit : Fit
        The re-identified model.
    library : sequence of Effect
        What is considered.
    """
    turns: list[Turn] = []
    current = fit
    for _ in range(_MOST_EFFECTS):
        turn = _turn(current, library)
        if turns and not turn.is_worth_another:
            break
        turns.append(turn)
        if not turn.accepts:
            break
        current = turn.confirmed[0].fit
    return tuple(turns)


def _turn(fit: Fit, library: Sequence[Effect]) -> Turn:
    found = screened(fit, library)
    white = sorted(found, key=lambda c: -c.white_worth)[:_CONFIRMED_WHITE]
    chosen = [*found[:_CONFIRMED], *(c for c in white if c not in found[:_CONFIRMED])]
    confirmed = [c for c in (_confirmed(fit, candidate) for candidate in chosen) if c is not None]
    return Turn(fit, tuple(sorted(confirmed, key=lambda c: -c.worth)), tuple(found))


def _confirmed(fit: Fit, candidate: Candidate) -> Confirmed | None:
    try:
        state = with_effects(fit.state, fit.weighting, (*fit.state.placed, candidate.placed))
        found = refitted(fitted(state, fit.weighting, _ITERATIONS), 4)
    except (SettingError, np.linalg.LinAlgError):
        return None
    item = found.state.placed[-1]
    if not np.isfinite(found.log_likelihood) or (item.effect.positive and item.amplitudes[0] < 0):
        return None
    return Confirmed(found, found.log_likelihood - _same_rows(fit, found.weighting).log_likelihood)


def _same_rows(fit: Fit, weighting: Weighting) -> Fit:
    """A fit judged with the weights of another."""
    if fit.weighting is weighting:
        return fit
    return replace(
        fit, state=fit.state.weighted(weighting), weighting=weighting, columns=weighting.rows(fit.spectra)
    )
