"""Which effects explain what the re-identified model leaves: screened, confirmed, accepted one after the other."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from symid.arrays import FloatArray
from symid.diagnosis.blocks import Blocks, certainty, deviation, log_likelihood
from symid.diagnosis.deviations import standard_deviations
from symid.diagnosis.effects import DriveEffect, Effect, JointEffect, LawEffect, LinearEffect, Placed
from symid.diagnosis.fit import LEAST_INERTIA, Fit, fitted, keeps_inertia, refitted, settled
from symid.diagnosis.hidden_starts import Start, can_march, of_grid, twins
from symid.diagnosis.scene import Scene
from symid.diagnosis.screening import PRICE, Candidate, screened
from symid.errors import SettingError

LEAST_WORTH = 30.0
"""Gain of the logarithm of the likelihood, less its price, that an effect must bring: the best of all places and shapes
brings less in noise alone."""
LEAST_SHARE = 0.006
"""Share of the mean square that it must take away."""
LEAST_CERTAINTY = 0.95
_LEAST_POWER = 0.06
_LEAST_OF_FIRST = 0.006
"""Share of the mean square of the first model that a further effect must take away."""
_SEEN = 1e-8
"""Share of a column, squared, that others must leave of it."""
_DEVIATIONS = 2.0
"""A value within so many deviations of nothing is no finding."""
_EXPLAINED = 1.4
_MARCHED = 2
_TWINS = 3
_COULOMB = "coulomb_friction"
LATE_FORCES = ("delay", "actuator_lag")
"""Nearly the same: beside each other they tell nothing."""
_PROMISING = 0.15
"""Share of the best candidate's gain by projection from which on another is fitted."""
_HARDLY_MORE = 0.01
_VARIES = 0.4
_HARDLY = 0.1
"""With more of the mean square left, no candidate has explained it."""
_LARGEST_FORCE = 5.0
"""Rms of a missing force, relative to the largest force of the drive: a spring that holds it may carry more."""
_TIE = 2.0
_TIMING_FIRST = 0.6
"""Share of the best gain from which on a reading that is late goes first: readings that do not belong together look
like play, friction or compliance, and what there is of these is found after it."""
_LATE_READING = "sensor_delay"
_OF_MASSES = ("flexible_mode", "payload_change")
_LEAST_ACTING = 0.5
"""Share of the logged force that must act on the axis: with less, the drive has been explained away."""
_MOST_EFFECTS = 4
_DIRECT = (6, 3)
_MARCHING = (12, 8)
"""Iterations at most, with the first weights and with those that belong to the values found."""


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
    """

    fit: Fit
    gain: float
    certainty: float
    squares: FloatArray

    @property
    def worth(self) -> float:
        """The gain, less what its free values would gain in noise."""
        return self.gain - PRICE * self.fit.state.placed[-1].n_free

    @property
    def effect(self) -> Effect:
        """What was added."""
        return self.fit.state.placed[-1].effect

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
        return best.worth > LEAST_WORTH and closed > LEAST_SHARE and best.certainty > LEAST_CERTAINTY

    def is_worth_another(self, first: float) -> bool:
        """Whether the best candidate is worth being accepted besides others, where `first` was to be explained."""
        if not self.accepts:
            return False
        taken = self.before.mean_square - self.confirmed[0].fit.mean_square
        return taken > max(_LEAST_POWER, _LEAST_OF_FIRST * first)


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
    current = fit = replace(fit, state=fit.state.with_least(1 / LEAST_INERTIA))
    nominal = nominal and replace(nominal, state=replace(nominal.state, least=fit.state.least))
    for _ in range(_MOST_EFFECTS):
        turn = _turn(current, library, None if turns else nominal)
        if turns and not turn.is_worth_another(fit.mean_square):
            break
        turns.append(turn)
        if not turn.accepts:
            break
        current = replace(refitted(settled(turn.confirmed[0].fit)), begun=fit.begun)
        if current.state.placed[-1].effect.name in LATE_FORCES:
            library = [effect for effect in library if effect.name not in LATE_FORCES]
    return tuple(turns)


def _turn(fit: Fit, library: Sequence[Effect], nominal: Fit | None) -> Turn:
    """Confirm the best candidates; as long as none explains the error, more of them, at more cost."""
    found = screened(fit, library)
    confirmed: dict[tuple[str, str], Confirmed] = {}
    for stage in _stages(fit, found, library, nominal, confirmed):
        _confirm(fit, stage, confirmed)
        best = max(confirmed.values(), key=lambda c: c.worth, default=None)
        if best is not None and best.fit.mean_square < _EXPLAINED:
            break
    _confirm(fit, [Start.of(fit, c.placed) for c in found if _simpler(c.placed.key, confirmed)], confirmed)
    _prefer_coulomb(confirmed)
    driven = fit.state.scene.axis.drive.at

    most = max((c.worth for c in confirmed.values()), default=0.0)

    def order(own: Confirmed) -> tuple[bool, float]:
        timing = own.key[0] == _LATE_READING and own.worth > _TIMING_FIRST * most
        return not timing, -own.worth - _TIE * (own.key[1] == getattr(driven, "name", None))

    ranked = sorted(confirmed.values(), key=order)
    while ranked and not _is_certain(ranked[0].fit):
        ranked.pop(0)
    return Turn(fit, tuple(ranked), tuple(found))


def _is_certain(fit: Fit) -> bool:
    """Whether each shape of the last effect exceeds its deviation, by whichever route this is larger."""
    item = fit.state.placed[-1]
    shapes = range(-len(item.shape), 0)
    deviations = standard_deviations(fit)
    names = item.effect.shape_names
    return all(deviations[i] < abs(item.shape[i]) for i in shapes if names[i] not in item.effect.moments)


def _confirm(fit: Fit, starts: Iterable[Start], confirmed: dict[tuple[str, str], Confirmed]) -> None:
    """Fit candidates; each keeps the best of its fits."""
    for start in starts:
        own = confirmed_from(fit, start)
        if own is not None and (own.key not in confirmed or own.gain > confirmed[own.key].gain):
            confirmed[own.key] = own


def _simpler(key: tuple[str, str], confirmed: Mapping[tuple[str, str], Confirmed]) -> bool:
    """Whether a candidate is a simpler effect than one of those confirmed, which may imitate it."""
    name, place = key
    imitated = any(own.key[1] == place and name in own.effect.imitates for own in confirmed.values())
    return imitated and key not in confirmed


def _prefer_coulomb(confirmed: dict[tuple[str, str], Confirmed]) -> None:
    """Drop what explains hardly more than the Coulomb friction that it contains: the next turn finds the rest."""
    for name, place in list(confirmed):
        plain, more = confirmed.get((_COULOMB, place)), confirmed[name, place]
        if plain is None or _COULOMB not in more.effect.imitates:
            continue
        doubt = deviation(plain.squares, more.squares, plain.fit.n_rows)
        clearly = more.worth - plain.worth > max(_HARDLY_MORE * plain.worth, doubt)
        if not clearly or _is_nearly_constant(more.fit.state.scene, more.fit.state.placed[-1]):
            del confirmed[name, place]


def _is_nearly_constant(scene: Scene, item: Placed) -> bool:
    """Whether a friction level that varies along the stroke varies by less than some tens of percent."""
    effect = item.effect
    if not (isinstance(effect, LawEffect) and effect.varies_along_stroke):
        return False
    level = effect.level(scene.joints[item.at], item.shape, item.amplitudes)
    course = level[scene.record.in_log]
    return bool(np.ptp(course) / 2 < _VARIES * abs(course.mean()))


def _stages(
    fit: Fit,
    found: list[Candidate],
    library: Sequence[Effect],
    nominal: Fit | None,
    confirmed: Mapping[tuple[str, str], Confirmed],
) -> Iterator[Iterable[Start]]:
    """Starts of fits, the cheapest first."""
    best_worth = max((max(c.worth, c.white_worth) for c in found), default=0.0)
    least = max(LEAST_WORTH / 2, _PROMISING * best_worth)
    promising = [c for c in found if max(c.worth, c.white_worth) > least]
    white = sorted(promising, key=lambda c: -c.white_worth)
    timing = [c for c in found if c.placed.effect.name == _LATE_READING]
    yield [Start.of(fit, c.placed) for c in promising[:3]]
    yield [Start.of(fit, c.placed) for c in _distinct([*promising[3:6], *white[:3], *timing], promising[:3])]
    if nominal is None:
        return
    other = [Start.of(nominal, c.placed) for c in screened(nominal, library)]
    yield [*other[:4], *(s for s in other[4:] if s.placed.effect.name == _LATE_READING)]
    if _least_left(confirmed) < _HARDLY * fit.mean_square:
        return
    hidden = [replace(s, placed=replace(s.placed, marched=True)) for s in other]
    yield [s for s in hidden if can_march(nominal.state.scene, s.placed)][:_MARCHED]
    best = sorted(confirmed.values(), key=lambda c: -c.worth)
    yield islice(twins(fit, [c.fit for c in best]), _TWINS)
    if _least_left(confirmed) > _HARDLY * fit.mean_square:
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


def confirmed_from(fit: Fit, start: Start) -> Confirmed | None:
    """A candidate fitted from a start, and its gain over the model without it."""
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            state = start.placed_state()
            if not np.all(np.isfinite(state.rows)):
                return None
            first, then = _MARCHING if start.placed.marched else _DIRECT
            found = refitted(fitted(state, start.weighting, first), then)
    except (SettingError, np.linalg.LinAlgError, OverflowError):
        return None
    return _judged(fit, found)


def _judged(fit: Fit, found: Fit) -> Confirmed | None:
    """The gain of a model over that without its last effect, on blocks that are left out."""
    if not (np.isfinite(found.mean_square) and np.isfinite(found.columns).all()):
        return None
    blocks = found.blocks
    if not is_credible(fit, found, blocks):
        return None
    n = found.n_rows
    own, before = blocks.squares, fit.blocks.squares
    gain = log_likelihood(own, n) - log_likelihood(before, n)
    return Confirmed(found, gain, certainty(before, own, n), own)


def is_credible(fit: Fit, found: Fit, blocks: Blocks) -> bool:
    """Whether a machine can be as a model with one more effect says, and the log determines its values."""
    item, scene = found.state.placed[-1], found.state.scene
    if not item.effect.is_possible(scene, item.amplitudes) or not item.effect.is_plausible(scene, item):
        return False
    if item.effect.name not in _OF_MASSES and not _same_inertia(fit, found, blocks):
        return False
    if force_share(found) > _LARGEST_FORCE:
        return False
    return is_determined(item, blocks) and acting_share(found) > _LEAST_ACTING


def force_share(fit: Fit) -> float:
    """Force of the last effect in a joint, relative to the largest that the drive gives; 0 for other effects."""
    scene, item = fit.state.scene, fit.state.placed[-1]
    if not isinstance(item.effect, JointEffect) or isinstance(item.effect, LinearEffect):
        return 0.0
    joint = item.effect.joint(scene, item.at)
    force = np.tensordot(item.amplitudes, item.effect.forces(scene, joint, item.shape), 1)
    inside = scene.record.in_log
    rms = float(np.sqrt(np.mean(scene.record.fine(force)[inside] ** 2)))
    return rms / float(np.abs(scene.record.whole_force).max())


def _same_inertia(fit: Fit, found: Fit, blocks: Blocks) -> bool:
    """Whether the drive moves the inertia of the model without the effect, or the one that the axis was given."""
    plain = [fit.state.inertia, *([fit.begun] if math.isfinite(fit.begun) else [])]
    spread = np.sqrt(np.diag(blocks.covariance))[: len(found.parameters)]
    masses = found.state.scene.record.dynamics.parameters_of("mass")
    least = min(s for name, s in zip(found.parameters, spread, strict=True) if name in masses)
    return keeps_inertia(found.state, *plain, doubt=min(_DEVIATIONS * float(least) / max(plain), 1.0))


def is_determined(item: Placed, blocks: Blocks) -> bool:
    """Whether the log tells the last effect from the others, and its values exceed their deviations."""
    if not item.n_free:
        return True
    if blocks.least_seen(item.n_free) < _SEEN:
        return False
    covariance = blocks.covariance[-item.n_free :, -item.n_free :]
    n = item.n_free - len(item.shape)
    amplitudes, shape = np.array(item.amplitudes[:n]), np.array(item.shape)
    matters = np.array([name not in item.effect.moments for name in item.effect.shape_names], dtype=bool)
    if np.any((np.sqrt(np.diag(covariance)[n:]) > np.abs(shape)) & matters):
        return False
    if not n:
        return True
    strength = amplitudes @ np.linalg.pinv(covariance[:n, :n], hermitian=True) @ amplitudes
    return bool(strength > _DEVIATIONS**2)


def acting_share(fit: Fit) -> float:
    """Share of the logged force that acts on the axis if an effect of the drive keeps some of it back, in rms."""
    scene = fit.state.scene
    changes = [item.change(scene)[0] for item in fit.state.placed if isinstance(item.effect, DriveEffect)]
    if not changes:
        return 1.0
    logged = np.stack([scene.record.measured[0], scene.record.measured[0] - np.sum(changes, axis=0)])
    rows = fit.weighting.rows(logged[:, None])[:, 0, fit.weighting.kept]
    whole, acting = np.linalg.norm(rows, axis=1)
    return float(acting / whole)
