"""Prior odds: knowledge that favours one effect over another, besides the fit.

A constant force and an asymmetric friction are the same force while an axis moves. But friction that has grown in one
direction also has a higher mean level, so that the level relative to its nominal value distinguishes the two. In steady
rotation, a periodic force of the position, which every motor has, looks like a periodic force of time. Friction with
the load of a drive that is switched between two levels looks like Coulomb friction.
"""

import math
from collections.abc import Collection, Mapping

import numpy as np

from symid.axis import CoulombFriction
from symid.diagnosis.effects import Key, LawEffect, Placed
from symid.diagnosis.effects.declared_friction import moving_along, places_of
from symid.diagnosis.effects.from_law import joints_with
from symid.diagnosis.fitting.state import State
from symid.diagnosis.prediction.drive_force import denoised_force
from symid.diagnosis.prediction.prediction import Prediction
from symid.diagnosis.thresholds import THRESHOLDS

_USUAL = ("coulomb_friction", "viscous_friction", "offset_force", "weight", "delay")
"""Effects of most machines that first models omit."""
_ASYMMETRY, _DRIFT = "asymmetric_friction", "friction_drift"
_LEVELS = ("coulomb_friction", "stribeck_friction", "position_dependent_friction")


def temperature(best: float) -> float:
    """Temperature of the tempered likelihood: gains are divided by it. `best` is the gain of the best candidate.

    >>> temperature(1000.0)
    7.0
    """
    return 1 + THRESHOLDS.tempered_share * max(best, 0.0)


def least_gain(effect: str, n_rows: float) -> float:
    """Least penalised gain of an effect, by the independent rows of a log.

    >>> least_gain("coulomb_friction", 0.0), least_gain("coulomb_friction", 5000.0), least_gain("cogging", 0.0)
    (12.0, 30.0, 30.0)
    """
    if effect not in _USUAL:
        return THRESHOLDS.least_penalised_gain
    few = max(1 - n_rows / THRESHOLDS.many_rows, 0.0)
    return THRESHOLDS.least_penalised_gain - few * (
        THRESHOLDS.least_penalised_gain - THRESHOLDS.least_of_usual
    )


def prior(state: State, nominal: Mapping[str, float]) -> float:
    """Logarithm of the prior odds of the last effect of a model relative to effects that explain as much.

    `nominal` are the values that the user gave; empty if there are none.
    """
    item = state.placed[-1]
    if item.effect.name == _ASYMMETRY:
        return _log_odds_of_asymmetry(state, item, nominal)
    by_motion = (item.effect.name == "periodic_disturbance" and _moves_steadily(state, item.at)) or (
        item.effect.name == "load_dependent_friction" and _is_load_constant(state, item.at)
    )
    return THRESHOLDS.of_motion if by_motion else 0.0


def is_of_new_friction(prediction: Prediction, key: Key, others: Collection[Key]) -> bool:
    """Whether an effect is an asymmetry of a friction that the model lacks and that is among other effects."""
    name, place = key
    found = any((level, place) in others for level in _LEVELS)
    return name == _ASYMMETRY and found and place not in joints_with(prediction, CoulombFriction)


def _moves_steadily(state: State, at: str) -> bool:
    """Whether a joint moves so steadily that a function of time is a function of the position."""
    record, q = state.prediction.record, state.prediction.joints[at].q
    inside = record.in_log
    return bool(abs(np.corrcoef(q[inside], record.fine_time[inside])[0, 1]) > THRESHOLDS.steady)


def _is_load_constant(state: State, at: str) -> bool:
    """Whether the load of a friction hardly varies, as that of a drive that is switched: friction is then Coulomb's."""
    prediction = state.prediction
    level = np.abs(denoised_force(prediction, prediction.drive_of(prediction.joints[at])))
    low, usual, high = np.percentile(level, [25, 50, 75])
    return bool(high - low < THRESHOLDS.constant_load * usual)


def _log_odds_of_asymmetry(state: State, item: Placed, nominal: Mapping[str, float]) -> float:
    """Log-likelihood ratio of the friction level: grown in one direction against unchanged.

    Friction that drifts has no level to compare.
    """
    along = moving_along(state.prediction, item.at)
    if any(other.effect.name == _DRIFT and other.at in along for other in state.placed):
        return 0.0
    # Level of the friction in the joint, nominal and fitted: of the declared laws, and of effects found.
    frictions = [law for law in state.prediction.axis.laws if isinstance(law, CoulombFriction)]
    levels = {
        law.named("level"): max(
            (along.get(at, 0.0) * abs(ratio) for at, ratio in places_of(state.prediction, law).items()),
            default=0.0,
        )
        for law in frictions
    }
    before, after = (
        sum(values.get(name, 0.0) * share for name, share in levels.items())
        for values in (nominal, state.prediction.parameters)
    )
    after += sum(along.get(p.at, 0.0) * _level(state, p) for p in state.placed if p.effect.name in _LEVELS)
    # Friction that has grown in one direction has a higher level, by the amplitude; otherwise the level is as before.
    scale = THRESHOLDS.level_spread * max(abs(before), abs(after))
    if not scale or any(share and name not in nominal for name, share in levels.items()):
        return 0.0
    return _likelihood((after - before - abs(item.amplitudes[0])) / scale) - _likelihood(
        (after - before) / scale
    )


def _level(state: State, item: Placed) -> float:
    """Mean friction of an effect while its joint moves."""
    assert isinstance(item.effect, LawEffect)
    joint = state.prediction.joints[item.at]
    q, v = joint.q[joint.moving], joint.v[joint.moving]
    return float(np.mean(item.effect.force_at(q, v, item.shape, item.amplitudes) * np.sign(v)))


def _likelihood(deviations: float) -> float:
    """Log-likelihood of a level, bounded below: a level far off supports neither hypothesis."""
    return math.log(math.exp(-(deviations**2) / 2) + THRESHOLDS.level_elsewhere)
