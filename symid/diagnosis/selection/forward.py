"""Which effects explain what the re-identified model leaves: screened, confirmed, accepted one after the other."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from symid.arrays import FloatArray
from symid.diagnosis.effects import Effect, LawEffect, Placed
from symid.diagnosis.fitting.blocks import certainty, deviation, log_likelihood
from symid.diagnosis.fitting.deviations import standard_deviations
from symid.diagnosis.fitting.fit import Fit, fitted, refitted, settled
from symid.diagnosis.fitting.hidden_starts import Start, can_integrate, from_other_places, of_grid
from symid.diagnosis.prediction.prediction import Prediction
from symid.diagnosis.prediction.weighting import Weighting
from symid.diagnosis.selection.credibility import is_credible
from symid.diagnosis.selection.priors import prior, temperature
from symid.diagnosis.selection.screening import Candidate, screened
from symid.diagnosis.thresholds import THRESHOLDS
from symid.errors import SettingError

_INTEGRATED = 2
_OTHER_PLACES = 3
_COULOMB, _COGGING, _PERIODIC = "coulomb_friction", "cogging", "periodic_disturbance"
LATE_FORCES = ("delay", "actuator_lag")
"""Nearly the same: beside each other they tell nothing."""
LATE_READING = "sensor_delay"
_DIRECT = (4, 4, 3)
_INTEGRATION = (4, 8, 8)
"""Iterations at most: before a hopeless fit is given up, after that, and with the weights of the values found."""


@dataclass(frozen=True, eq=False)
class Confirmed:
    """A candidate fitted with all parameters free.

    Parameters
    ----------
    fit : Fit
        The model with it.
    gain : float
        Of the logarithm of the likelihood over the model without it, on blocks left out.
    certainty : float
        Probability that it predicts such blocks better than the model without it.
    squares : array of shape (n_outputs, n_blocks)
        Sums of squares of its errors of each of these blocks.
    spoils : bool
        Whether it makes the error of another output grow by much.
    """

    fit: Fit
    gain: float
    certainty: float
    squares: FloatArray
    spoils: bool = False

    @property
    def penalised_gain(self) -> float:
        """The gain, less what its free values would gain in noise."""
        return self.gain - THRESHOLDS.penalty * self.placed.n_free

    @property
    def placed(self) -> Placed:
        """What was added, with its place and values."""
        return self.fit.state.placed[-1]

    @property
    def effect(self) -> Effect:
        """What was added."""
        return self.placed.effect

    @property
    def key(self) -> tuple[str, str]:
        """Names of effect and place."""
        return self.placed.key


@dataclass(frozen=True, eq=False)
class SelectionStep:
    """One step of the search.

    Parameters
    ----------
    before : Fit
        The model without the effect of this step.
    confirmed : tuple of Confirmed
        Candidates that were fitted, the largest gain first.
    screened : tuple of Candidate
        All candidates.
    refused : frozenset of (str, str)
        Effects and places that were fitted and that no machine can have with the values found.
    """

    before: Fit
    confirmed: tuple[Confirmed, ...]
    screened: tuple[Candidate, ...]
    refused: frozenset[tuple[str, str]] = frozenset()

    @property
    def accepts(self) -> bool:
        """Whether the best candidate is worth its acceptance."""
        return bool(self.confirmed) and self._accepts(self.confirmed[0])

    def _accepts(self, own: Confirmed) -> bool:
        closed = _taken(self.before, own.fit, self.before)
        gains = own.penalised_gain > THRESHOLDS.least_penalised_gain and closed > THRESHOLDS.least_share
        return gains and own.certainty > THRESHOLDS.least_certainty

    def with_acceptable(self) -> SelectionStep:
        """The same, where the best candidate is not accepted with the next one first that is, if it gains enough.

        An effect that a few blocks show, such as a mass that changes once, is certain when the others are dealt with.
        """
        if self.accepts or not self.confirmed:
            return self
        least = THRESHOLDS.beside_best * self.confirmed[0].penalised_gain
        found = [own for own in self.confirmed if own.penalised_gain > least and self._accepts(own)]
        if not found:
            return self
        others = (own for own in self.confirmed if own is not found[0])
        return replace(self, confirmed=(found[0], *others))

    def other_timing(self) -> tuple[SelectionStep, ...]:
        """The same with the lag accepted in place of the delay, or the other way round, if it explains as much or less.

        Which of the two it is shows at high frequencies, where what is not yet modelled may decide wrongly: a lag
        makes more of a ripple of the encoder than a delay does.
        """
        if not self.accepts or self.confirmed[0].effect.name not in LATE_FORCES:
            return ()
        least = THRESHOLDS.other_timing * self.confirmed[0].penalised_gain
        others = [own for own in self.confirmed[1:] if own.effect.name in LATE_FORCES]
        return tuple(
            replace(self, confirmed=(own, *(c for c in self.confirmed if c is not own)))
            for own in others
            if own.penalised_gain > least and self._accepts(own)
        )

    def justifies_another(self, first: Fit) -> bool:
        """Whether the best candidate is worth being accepted besides others, where `first` was to be explained."""
        if not self.accepts:
            return False
        return takes(self.before, self.confirmed[0].fit, first)


def takes(before: Fit, after: Fit, first: Fit) -> bool:
    """Whether an effect beside others takes away what counts, where `first` was to be explained."""
    most = float(np.max(before.squares - after.squares)) / before.squares.size
    return most > THRESHOLDS.least_power and _taken(before, after, first) > THRESHOLDS.least_of_first


def _taken(before: Fit, after: Fit, first: Fit) -> float:
    """Share of what a first model leaves that an effect takes away: in the mean of the outputs, or of their shares.

    Errors of one output may be thousands of times those of another in multiples of the noise, and hide what is taken.
    """
    taken = before.squares - after.squares
    return float(max(np.mean(taken / first.squares), np.mean(taken) / first.mean_square))


def forward_selection(
    fit: Fit, library: Sequence[Effect], nominal: Fit | None = None
) -> tuple[SelectionStep, ...]:
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
    fit = replace(fit, state=fit.state.with_least(1 / THRESHOLDS.least_inertia, fit.nominal))
    nominal = nominal and replace(nominal, state=replace(nominal.state, bounds=fit.state.bounds))
    first = _selection_step(fit, library, nominal).with_acceptable()
    branches = [_continued(fit, begun, library) for begun in (first, *first.other_timing())]
    return max(branches, key=lambda steps: _predicts(steps, fit.weighting))


def _continued(fit: Fit, first: SelectionStep, library: Sequence[Effect]) -> tuple[SelectionStep, ...]:
    """A first step and those that accept their best candidate after it."""
    steps, last = [first], first
    while last.accepts and len(steps) < THRESHOLDS.most_effects:
        current = refitted(settled(last.confirmed[0].fit)).after(fit)
        if (
            current.mean_square
            - max(THRESHOLDS.least_power, THRESHOLDS.least_of_first * float(fit.squares.min()))
            < THRESHOLDS.noise
        ):
            break
        if current.state.placed[-1].effect.name in LATE_FORCES:
            library = [effect for effect in library if effect.name not in LATE_FORCES]
        last = _selection_step(current, library, None)
        if not last.justifies_another(fit):
            break
        steps.append(last)
    return tuple(steps)


def _predicts(steps: Sequence[SelectionStep], weighting: Weighting) -> float:
    """Logarithm of the likelihood with which the last model predicts blocks left out, less the penalties."""
    if not steps[-1].confirmed:
        return -math.inf
    state = steps[-1].confirmed[0].fit.state
    added = state.placed[len(steps[0].before.state.placed) :]
    return Fit(state.weighted(weighting), weighting).predicted - THRESHOLDS.penalty * sum(
        item.n_free for item in added
    )


def _selection_step(fit: Fit, library: Sequence[Effect], nominal: Fit | None) -> SelectionStep:
    """Confirm the best candidates; as long as none explains the error, more of them, at more cost."""
    found = screened(fit, library)
    confirmed: dict[tuple[str, str], Confirmed] = {}
    tried: dict[tuple[str, str], Placed] = {}
    for stage in _stages(fit, found, library, nominal, confirmed):
        tried |= _confirm(fit, stage, confirmed)
        best = max(confirmed.values(), key=lambda c: c.penalised_gain, default=None)
        if best is not None and best.fit.mean_square < THRESHOLDS.explained:
            break
    simpler = [c.placed for c in found if _is_simpler(c.placed.key, tried)]
    tried |= _confirm(fit, [Start.of(fit, placed) for placed in simpler], confirmed)
    refused = frozenset(tried.keys() - confirmed.keys())
    prefer_coulomb(confirmed)
    return SelectionStep(fit, tuple(ranked(confirmed.values(), fit)), tuple(found), refused)


def ranked(confirmed: Iterable[Confirmed], before: Fit) -> list[Confirmed]:
    """Candidates, the best first: one whose values the log does not determine is none.

    What spoils another output goes last. Timing goes before what it looks like, and where places cannot be told apart,
    the driven body goes first.
    """
    candidates = list(confirmed)
    driven = getattr(before.state.prediction.axis.only_drive.at, "name", None)
    most = max((c.penalised_gain for c in candidates), default=0.0)

    def order(own: Confirmed) -> tuple[bool, bool, float]:
        timing = own.key[0] == LATE_READING and own.penalised_gain > THRESHOLDS.timing_first * most
        return own.spoils, not timing, -own.penalised_gain - THRESHOLDS.tie * (own.key[1] == driven)

    found = sorted(candidates, key=order)
    while found and not _is_certain(found[0].fit):
        found.pop(0)
    return sorted(found, key=lambda own: not _likelier(own, found[0], before))


def _likelier(own: Confirmed, best: Confirmed, before: Fit) -> bool:
    """Whether what may stand for the best candidate and explains as much is likelier than it by what else is known."""
    of_position = (best.key, own.key) == ((_PERIODIC, best.key[1]), (_COGGING, best.key[1]))
    if not (own.placed.contains(best.key) or of_position):
        return False
    doubt = temperature(best.penalised_gain) + THRESHOLDS.doubt * deviation(
        best.squares, own.squares, before.n_rows
    )
    odds = prior(own.fit.state, before.nominal) - prior(best.fit.state, before.nominal)
    return odds + (own.penalised_gain - best.penalised_gain) / doubt > 0


def _is_certain(fit: Fit) -> bool:
    """Whether each shape of the last effect exceeds its deviation, by whichever route this is larger."""
    item = fit.state.placed[-1]
    shapes = range(-len(item.shape), 0)
    deviations = standard_deviations(fit)
    names = item.effect.shape_names
    return all(deviations[i] < abs(item.shape[i]) for i in shapes if names[i] not in item.effect.moments)


def _confirm(
    fit: Fit, starts: Iterable[Start], confirmed: dict[tuple[str, str], Confirmed]
) -> dict[tuple[str, str], Placed]:
    """Fit candidates, which are returned; each keeps the best of its fits."""
    tried = {}
    for start in starts:
        tried[start.placed.key] = start.placed
        own = confirmed_from(fit, start, THRESHOLDS.hopeless * _least_left(confirmed))
        if own is not None and (own.key not in confirmed or own.gain > confirmed[own.key].gain):
            confirmed[own.key] = own
    return tried


def _is_simpler(key: tuple[str, str], tried: Mapping[tuple[str, str], Placed]) -> bool:
    """Whether a candidate is a simpler effect than one of those tried, which may imitate it."""
    return key not in tried and any(placed.contains(key) for placed in tried.values())


def prefer_coulomb(confirmed: dict[tuple[str, str], Confirmed]) -> None:
    """Drop what explains hardly more than the Coulomb friction that it contains: the next step finds the rest."""
    for name, place in list(confirmed):
        plain, more = confirmed.get((_COULOMB, place)), confirmed[name, place]
        if plain is None or not more.placed.contains(plain.key):
            continue
        doubt = deviation(plain.squares, more.squares, plain.fit.n_rows)
        clearly = more.penalised_gain - plain.penalised_gain > max(
            THRESHOLDS.hardly_more * plain.penalised_gain, doubt
        )
        clearly = clearly and more.fit.mean_square < plain.fit.mean_square
        if not clearly or _is_nearly_constant(more.fit.state.prediction, more.placed):
            del confirmed[name, place]


def _is_nearly_constant(prediction: Prediction, item: Placed) -> bool:
    """Whether a friction level that varies along the stroke varies by less than some tens of percent."""
    effect = item.effect
    if not (isinstance(effect, LawEffect) and effect.varies_along_stroke):
        return False
    level = effect.level(prediction.joints[item.at], item.shape, item.amplitudes)
    course = level[prediction.record.in_log]
    return bool(np.ptp(course) / 2 < THRESHOLDS.varies * abs(course.mean()))


def _stages(
    fit: Fit,
    found: list[Candidate],
    library: Sequence[Effect],
    nominal: Fit | None,
    confirmed: Mapping[tuple[str, str], Confirmed],
) -> Iterator[Iterable[Start]]:
    """Starts of fits, the cheapest first."""
    best_gain = max((max(c.penalised_gain, c.white_penalised_gain) for c in found), default=0.0)
    least = max(THRESHOLDS.least_penalised_gain / 2, THRESHOLDS.promising * best_gain)
    promising = [c for c in found if max(c.penalised_gain, c.white_penalised_gain) > least]
    white = sorted(promising, key=lambda c: -c.white_penalised_gain)
    timing = [c for c in found if c.placed.effect.name == LATE_READING]
    yield [Start.of(fit, c.placed) for c in promising[:3]]
    yield [Start.of(fit, c.placed) for c in _distinct([*promising[3:6], *white[:3], *timing], promising[:3])]
    if nominal is None or _least_left(confirmed) < THRESHOLDS.hardly * fit.mean_square:
        return
    other = [Start.of(nominal, c.placed) for c in screened(nominal, library)]
    yield [*other[:4], *(s for s in other[4:] if s.placed.effect.name == LATE_READING)]
    if _least_left(confirmed) < THRESHOLDS.hardly * fit.mean_square:
        return
    hidden = [replace(s, placed=replace(s.placed, integrated=True)) for s in other]
    yield [s for s in hidden if can_integrate(nominal.state.prediction, s.placed)][:_INTEGRATED]
    best = sorted(confirmed.values(), key=lambda c: -c.penalised_gain)
    yield islice(from_other_places(fit, [c.fit for c in best]), _OTHER_PLACES)
    if _least_left(confirmed) > THRESHOLDS.hardly * fit.mean_square:
        yield of_grid(fit, nominal, library)


def _least_left(confirmed: Mapping[tuple[str, str], Confirmed]) -> float:
    """Mean square that the best of those confirmed leaves."""
    return min((c.fit.mean_square for c in confirmed.values()), default=math.inf)


def _distinct(candidates: list[Candidate], others: list[Candidate]) -> list[Candidate]:
    kept: list[Candidate] = []
    for candidate in candidates:
        if not any(candidate is c for c in (*others, *kept)):
            kept.append(candidate)
    return kept


def confirmed_from(fit: Fit, start: Start, most: float = math.inf) -> Confirmed | None:
    """A candidate fitted from a start, and its gain over the model without it.

    Parameters
    ----------
    fit : Fit
        The model without it.
    start : Start
        Its values to begin with.
    most : float
        Mean square from which on it is not fitted any better, as others leave much less.
    """
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            state = start.best_state()
            if state is None:
                return None
            first, further, then = _INTEGRATION if start.placed.integrated else _DIRECT
            found = fitted(state, start.weighting, first)
            if found.mean_square < most:
                found = refitted(fitted(found.state, start.weighting, further), then)
            return _judged(fit, found)
    except (SettingError, np.linalg.LinAlgError, OverflowError):
        return None


def _judged(fit: Fit, found: Fit) -> Confirmed | None:
    """The gain of a model over that without its last effect, on blocks that are left out."""
    if not (np.isfinite(found.mean_square) and np.isfinite(found.columns).all()):
        return None
    blocks = found.blocks
    if not is_credible(fit, found, blocks):
        return None
    n = found.n_rows
    own, before = blocks.squares, fit.blocks.squares
    grown = (own.sum(axis=1) > THRESHOLDS.spoiled * before.sum(axis=1)) & (found.squares > THRESHOLDS.spoiled)
    gain = log_likelihood(own, n) - log_likelihood(before, n)
    return Confirmed(found.released(), gain, certainty(before, own, n), own, spoils=bool(grown.any()))
