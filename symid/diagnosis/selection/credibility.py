"""Credibility of a fitted effect: whether a machine can have its values, and whether the log determines them."""

import math
from collections.abc import Sequence

import numpy as np

from symid.arrays import FloatArray
from symid.axis import CoulombFriction, ViscousFriction
from symid.diagnosis.effects import DriveEffect, JointEffect, LawEffect, LinearEffect, Placed
from symid.diagnosis.effects.declared_friction import declared_level, moving_along
from symid.diagnosis.effects.friction_drift import FrictionDriftEffect
from symid.diagnosis.effects.from_law import joints_with
from symid.diagnosis.effects.periodic_disturbance import PeriodicDisturbanceEffect, is_mode
from symid.diagnosis.fitting.cross_validation import Blocks, least_fall
from symid.diagnosis.fitting.fit import Fit, stiffnesses
from symid.diagnosis.fitting.gauss_newton import keeps_inertia
from symid.diagnosis.fitting.state import State
from symid.diagnosis.prediction.drive_force import drive_force_of
from symid.diagnosis.selection.screening import is_in_proportion
from symid.diagnosis.selection.step import is_clear
from symid.diagnosis.thresholds import THRESHOLDS

_OF_MASSES = ("flexible_mode", "payload_change")
_DIFFERS = ("asymmetric_friction", "position_dependent_friction")
"""Friction that exceeds its mean at some points of the motion and falls below it at others."""
_CHANGES = (*_DIFFERS, "friction_drift")
"""Friction that may be negative for a part of the motion."""
_OF_DIRECTION = ("offset_force", "asymmetric_friction")
"""Laws that cancel a Coulomb friction only where a joint moves one way."""
_DRY = ("coulomb_friction", "presliding_friction")
_FRICTIONS = (*_DIFFERS, "coulomb_friction", "viscous_friction", "stribeck_friction", "quadratic_drag")


def is_credible(fit: Fit, found: Fit, blocks: Blocks, beside: Sequence[Placed] = ()) -> bool:
    """Whether a machine can have the values of a model with one more effect, and the log determines them.

    `blocks` belong to the model with the effect. Effects `beside` are known to be present but in neither model yet.
    """
    item, prediction = found.state.placed[-1], found.state.prediction
    explains = _explains_all(fit, found)
    if not item.effect.is_possible(prediction, item) or _makes_impossible(fit, found):
        return False
    if not ((explains and is_clear(fit)) or item.effect.is_plausible(prediction, item)):
        return False
    if item.effect.name not in _OF_MASSES and not _same_inertia(fit, found, blocks, explains):
        return False
    if not explains and _is_far_heavier(fit, found):
        return False
    if isinstance(item.effect, LawEffect) and not explains and _makes_friction_negative(fit, found, blocks):
        return False
    if item.effect.name in _CHANGES and friction_drives(found.state, item.at, beside):
        return False
    if _is_a_gain(found) or _is_coulomb_friction(found.state, beside) or _is_ringing(fit, found, blocks):
        return False
    if _springs_ran_away(fit, found) or force_share(found) > THRESHOLDS.largest_force:
        return False
    return is_determined(item, blocks) and (explains or acting_share(found) > THRESHOLDS.least_acting)


def _explains_all(fit: Fit, found: Fit) -> bool:
    """Whether an effect removes nearly all of the excess error."""
    # By the noise of the model before: a heavier axis passes more noise on and would seem to leave less.
    left = float(np.mean(found.squares_as_weighted_by(fit)))
    before = fit.mean_square
    return before > THRESHOLDS.fit_of_noise and left - 1 < THRESHOLDS.explains_all * (before - 1)


def _makes_impossible(fit: Fit, found: Fit) -> bool:
    """Whether an effect found earlier takes values that no machine has, such as a mode heavier than its body."""
    before, after = fit.state, found.state
    possible = {i.key for i in before.placed if i.effect.is_possible(before.prediction, i)}
    return any(i.key in possible and not i.effect.is_possible(after.prediction, i) for i in after.placed)


def _makes_friction_negative(fit: Fit, found: Fit, blocks: Blocks) -> bool:
    """Whether the last effect makes a Coulomb friction clearly more negative, so that the two cancel.

    In motion of one direction a constant force does so, or a Stribeck friction that falls over all of the speeds. In
    motion of both directions a constant force cannot: the friction is then negative because a drag is missing too.
    """
    item, prediction = found.state.placed[-1], found.state.prediction
    if item.effect.name in _OF_DIRECTION and prediction.joints[item.at].moves_both_ways:
        return False
    laws = [law for law in fit.state.prediction.axis.laws if isinstance(law, CoulombFriction)]
    spread = dict(zip(fit.parameters, np.sqrt(np.diag(blocks.covariance)), strict=False))
    names = {term.parameter for law in laws for term in law.terms()} & spread.keys()
    most = {n: found.parameters[n] + THRESHOLDS.deviations * spread[n] for n in names}
    return any(most[n] < min(fit.parameters[n], 0.0) for n in names)


def _springs_ran_away(fit: Fit, found: Fit) -> bool:
    """Whether a stiffness grew far beyond its value without the effect."""
    names = stiffnesses(fit.state.prediction.axis)
    return any(
        abs(found.parameters[n]) > THRESHOLDS.spring_ran_away * abs(fit.parameters[n]) > 0 for n in names
    )


def force_share(fit: Fit) -> float:
    """Force of the last effect in a joint, at the drive, relative to its largest force; 0 for other effects."""
    prediction, item = fit.state.prediction, fit.state.placed[-1]
    if not isinstance(item.effect, JointEffect) or isinstance(item.effect, LinearEffect):
        return 0.0
    joint = item.effect.joint(prediction, item.at)
    force = np.tensordot(item.amplitudes, item.effect.forces_at(prediction, joint, item.shape), 1)
    inside = prediction.record.in_log
    rms = float(np.sqrt(np.mean(prediction.record.fine(force)[inside] ** 2)))
    largest = float(np.abs(prediction.record.whole_forces[prediction.drive_of(joint)]).max())
    return rms * drive_force_of(prediction, joint) / largest


def friction_drives(state: State, at: str, beside: Sequence[Placed] = ()) -> bool:
    """Whether dry and viscous friction of a joint, as declared and found, would push it along for a part of its way.

    Such friction imitates a constant force or a weight. Dry friction that is declared in a joint
    that moves along counts as friction of this one.
    """
    joint = state.prediction.joints[at]
    q, v = joint.q[joint.moving], joint.v[joint.moving]
    along = moving_along(state.prediction, at)
    level = sum(declared_level(state.prediction, j, CoulombFriction) * share for j, share in along.items())
    force = level * np.sign(v) + declared_level(state.prediction, at, ViscousFriction) * v
    for item in (*state.placed, *beside):
        if item.at == at and item.effect.name in _FRICTIONS and isinstance(item.effect, LawEffect):
            force = force + item.effect.force_at(q, v, item.shape, item.amplitudes)
        elif item.at in along and item.effect.name in _DRY:
            force = force + item.amplitudes[0] * along[item.at] * np.sign(v)
        elif item.at == at and isinstance(item.effect, FrictionDriftEffect):
            force = force + item.effect.force_over_time(state.prediction, item)[joint.moving]
    pushing = force * np.sign(v) < -THRESHOLDS.pushes * np.sqrt(np.mean(force**2))
    return bool(np.mean(pushing) > THRESHOLDS.pushed)


def _is_ringing(fit: Fit, found: Fit, blocks: Blocks) -> bool:
    """Whether the last effect is a disturbance at a mode of the axis and does not lower the error of all blocks alike.

    A mode that is excited again and again has another phase each time; a disturbance keeps its phase.
    """
    item = found.state.placed[-1]
    if not isinstance(item.effect, PeriodicDisturbanceEffect):
        return False
    rings = least_fall(fit.blocks.squares, blocks.squares) < THRESHOLDS.steady_fall
    return rings and is_mode(found.state.prediction, item.shape[0])


def _is_coulomb_friction(state: State, beside: Sequence[Placed]) -> bool:
    """Whether Stribeck friction hardly falls with speed and thus replaces missing Coulomb friction of its joint."""
    *others, item = state.placed
    if item.effect.name != "stribeck_friction":
        return False
    joint, along = state.prediction.joints[item.at], moving_along(state.prediction, item.at)
    dry = joints_with(state.prediction, CoulombFriction)
    dry |= {other.at for other in (*others, *beside) if other.effect.name in _DRY}
    return dry.isdisjoint(along) and item.shape[0] > THRESHOLDS.hardly_falls * joint.top_speed


def _same_inertia(fit: Fit, found: Fit, blocks: Blocks, explains: bool) -> bool:
    """Whether the drive moves about the inertia of the model without the effect, or the initial one.

    An error many times the force of inertia leaves the inertia undetermined. It may grow within the deviation that it
    has without the effect; if the log does not determine it at all, the check passes. If the effect explains all, any
    larger inertia passes: in a slow swing, inertia takes over most of a weight or spring with the opposite sign.
    """
    plain = _inertias_before(fit)
    before, after = (
        THRESHOLDS.deviations * _deviation_of_mass(own, of)
        for own, of in ((fit, fit.blocks), (found, blocks))
    )
    tolerance = min(after / max(plain), 1.0)
    most = max(fit.state.inertia + before, found.state.inertia if explains else 0.0)
    return before > max(plain) or keeps_inertia(found.state, *plain, most, tolerance=tolerance)


def _is_far_heavier(fit: Fit, found: Fit) -> bool:
    """Whether the inertia is many times that of the model without the effect and far beyond its deviation."""
    most = fit.state.inertia + THRESHOLDS.deviations * _deviation_of_mass(fit, fit.blocks)
    return found.state.inertia > max(THRESHOLDS.heavier * max(_inertias_before(fit)), most)


def _inertias_before(fit: Fit) -> list[float]:
    """Inertia of the model without the effect, and the initial one where it is known."""
    return [fit.state.inertia, *([fit.initial_inertia] if math.isfinite(fit.initial_inertia) else [])]


def _deviation_of_mass(fit: Fit, blocks: Blocks) -> float:
    """Least standard deviation of a free mass or inertia; 0 if there is none."""
    masses = fit.state.prediction.record.dynamics.parameters_of("mass")
    spread = np.sqrt(np.diag(blocks.covariance))[: len(fit.parameters)]
    return min(
        (float(s) for name, s in zip(fit.parameters, spread, strict=True) if name in masses), default=0.0
    )


def is_determined(item: Placed, blocks: Blocks) -> bool:
    """Whether the log distinguishes the last effect from the others, and its values exceed their deviations."""
    if not item.n_free:
        return True
    if blocks.least_independent_part(item.n_free) < THRESHOLDS.least_independent:
        return False
    return exceeds_deviations(item, blocks.covariance[-item.n_free :, -item.n_free :])


def exceeds_deviations(item: Placed, covariance: FloatArray) -> bool:
    """Whether amplitudes and shapes of an effect exceed their deviations, of the covariance of its free values."""
    n = item.n_free - len(item.shape)
    amplitudes, shape = np.array(item.amplitudes[:n]), np.array(item.shape)
    matters = np.array(
        [name not in item.effect.may_be_undetermined for name in item.effect.shape_names], dtype=bool
    )
    if np.any((np.sqrt(np.diag(covariance)[n:]) > np.abs(shape)) & matters):
        return False
    if not n:
        return True
    strength = amplitudes @ np.linalg.pinv(covariance[:n, :n], hermitian=True) @ amplitudes
    return bool(strength > THRESHOLDS.deviations**2)


def _is_a_gain(found: Fit) -> bool:
    """Whether the last effect changes the drive force in proportion to it, as scaled parameters do.

    With a force that a relay switches between two values, every limit and every nonlinear gain is such a change.
    """
    prediction, item = found.state.prediction, found.state.placed[-1]
    if not item.effect.is_of_command:
        return False
    kept, n_drives = found.weighting.kept, prediction.record.n_drives
    pair = np.stack([item.change(prediction), prediction.record.measured])
    change, force = found.weighting.rows(pair)[:, :n_drives, kept].reshape(2, -1)
    return is_in_proportion(change, force)


def acting_share(fit: Fit) -> float:
    """Share of the logged force, in rms, that acts on the axis after the effects of the drive.

    With several drives, the smallest share.
    """
    prediction = fit.state.prediction
    changes = [item.change(prediction) for item in fit.state.placed if isinstance(item.effect, DriveEffect)]
    if not changes:
        return 1.0
    logged = np.stack([prediction.record.measured, prediction.record.measured - np.sum(changes, axis=0)])
    rows = fit.weighting.rows(logged)[:, : prediction.record.n_drives, fit.weighting.kept]
    whole, acting = np.linalg.norm(rows, axis=2)
    return float((acting / whole).min())
