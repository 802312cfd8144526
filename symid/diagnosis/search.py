"""Which effects explain what the re-identified model leaves: screened, confirmed, accepted one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symid.diagnosis.effects import Effect
from symid.diagnosis.fit import Fit, fitted, refitted, with_effects
from symid.diagnosis.screening import PRICE, Candidate, screened
from symid.errors import SettingError

LEAST_WORTH = 20.0
"""Gain of the logarithm of the likelihood, less its price, that an effect must bring: the best of all places and shapes
brings less in noise alone."""
LEAST_SHARE = 0.006
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


def search(fit: Fit, library: Sequence[Effect], nominal: Fit | None = None) -> tuple[Turn, ...]:
    """Turns of the search: the first, and those that accept their best candidate after it.

    Parameters
    ----------
    fit : Fit
        The re-identified model.
    library : sequence of Effect
        What is considered.
    nominal : Fit, optional
        The model before re-identification, another start for effects that led the parameters astray.
    """
    turns: list[Turn] = []
    current = fit
    for _ in range(_MOST_EFFECTS):
        turn = _turn(current, library, [current] if turns or nominal is None else [current, nominal])
        if turns and not turn.is_worth_another:
            break
        turns.append(turn)
        if not turn.accepts:
            break
        current = turn.confirmed[0].fit
    return tuple(turns)


def _turn(fit: Fit, library: Sequence[Effect], starts: Sequence[Fit]) -> Turn:
    confirmed: dict[tuple[str, str], Confirmed] = {}
    found: dict[tuple[str, str], Candidate] = {}
    for start in starts:
        candidates = screened(start, library)
        white = sorted(candidates, key=lambda c: -c.white_worth)[:_CONFIRMED_WHITE]
        first = candidates[:_CONFIRMED]
        for candidate in [*first, *(c for c in white if c not in first)]:
            own = _confirmed(fit, start, candidate)
            if own is not None and (own.key not in confirmed or own.gain > confirmed[own.key].gain):
                confirmed[own.key] = own
        for candidate in candidates if start is fit else ():
            found[candidate.placed.key] = candidate
    return Turn(fit, tuple(sorted(confirmed.values(), key=lambda c: -c.worth)), tuple(found.values()))


def _confirmed(fit: Fit, start: Fit, candidate: Candidate) -> Confirmed | None:
    """A candidate fitted from a start, and its gain over the model without it."""
    try:
        state = with_effects(start.state, start.weighting, (*start.state.placed, candidate.placed))
        found = refitted(fitted(state, start.weighting, _ITERATIONS), 4)
    except (SettingError, np.linalg.LinAlgError):
        return None
    item = found.state.placed[-1]
    if not np.isfinite(found.mean_square) or (item.effect.positive and item.amplitudes[0] < 0):
        return None
    before = replace(found.weighting, density=fit.weighting.density)
    without = replace(
        fit, state=fit.state.weighted(before), weighting=before, columns=before.rows(fit.spectra)
    )
    allowed = np.maximum(found.weighting.density, before.density)
    return Confirmed(found, found.log_likelihood(allowed) - without.log_likelihood(before.density))
