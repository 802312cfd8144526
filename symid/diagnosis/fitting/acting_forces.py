"""The next prediction of a model: the forces of effects and laws on its motion.

A moderate force on hidden motion is evaluated at the motion of the prediction before (fixed-point iteration). A strong
one is integrated in time, and an equivalent impedance replaces it in the frequency response. Where the motion is
observed, the response stays linear.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from symid.arrays import ComplexArray, FloatArray, add_outer, norms_or_one
from symid.diagnosis.effects import JointEffect, LinearEffect, Placed, TransferEffect
from symid.diagnosis.prediction.hidden_motion import IntegratedEffects, Pointwise
from symid.diagnosis.prediction.joint import RecordedJoint
from symid.diagnosis.prediction.prediction import Prediction, prediction_of
from symid.diagnosis.prediction.response import ForcePath
from symid.simulation.plants import ScaledLaw, dry_level, not_below_zero


def changes_by_others(prediction: Prediction, placed: Sequence[Placed], *, integrates: bool) -> ComplexArray:
    """Change of the outputs by errors of the readings and changes of masses, of shape (n_outputs, n_bins).

    Motion that is integrated has the first mass that changes and errors of the driven position in it.
    """
    heavier = _heavier(prediction, placed) if integrates else None

    def adds(item: Placed) -> bool:
        if not changes_outputs(item) or item is heavier:
            return False
        return not integrates or item.effect.misreading(prediction, item) is None

    changes = (item.change(prediction) for item in placed if adds(item))
    return sum(changes, start=np.zeros_like(prediction.outputs))


def changes_outputs(item: Placed) -> bool:
    """Whether an effect changes the outputs directly, and not by a force in a joint or by the command of a drive."""
    return not (item.effect.is_of_command or isinstance(item.effect, JointEffect | TransferEffect))


def errors_of_positions(prediction: Prediction, placed: Iterable[Placed]) -> ComplexArray | None:
    """Errors of the driven positions, of shape (n_drives, n_bins); None without any."""
    found = [x for item in placed if (x := item.effect.misreading(prediction, item)) is not None]
    return np.asarray(np.sum(found, axis=0)) if found else None


def _heavier(prediction: Prediction, placed: Iterable[Placed]) -> Placed | None:
    """The first effect that changes the mass of a hidden body during the log."""
    return next((item for item in placed if item.effect.mass_change(prediction, item) is not None), None)


def next_prediction(
    before: Prediction, parameters: Mapping[str, float], placed: tuple[Placed, ...], *, nearby: bool
) -> Prediction:
    """The prediction with the forces that effects have at the motion of the prediction before.

    For `nearby` values the frequency response is kept.
    """
    # Three kinds of forces: of integrated laws, of linear effects as impedances, and all others as forces at the motion
    # before. In the frequency response an impedance stands for each integrated law, unless motion is observed.
    record, forces, hidden = before.record, np.zeros_like(before.forces), before.record.hidden_terms
    impedances, integrated, linear = [], [], nearby or before.follows
    for item in placed:
        if not isinstance(item.effect, JointEffect):
            continue
        joint = item.effect.joint(before, item.at)
        law = item.effect.pointwise(before, item.shape, item.amplitudes) if item.integrated else None
        if law is not None:
            integrated.append((joint.direction, law))
            if not linear:
                impedances.append((joint.direction, _equivalent(_force(before, item, joint), joint)))
        elif isinstance(item.effect, LinearEffect):
            stiffness = item.effect.impedance(record.omega, item)
            impedances.append((joint.direction, stiffness))
            if hidden or any(other.integrated for other in placed):  # an integration has no impedances
                add_outer(forces, stiffness * joint.spectrum, -joint.direction)
        else:
            add_outer(forces, _force(before, item, joint), -joint.direction)
    plant = record.dynamics.at(parameters) if nearby or hidden else before.response.plant
    for i, k in hidden:
        direction, term = plant.laws[i].direction, plant.laws[i].terms[k]
        integrated.append((direction, _integrand(term)))
        if not linear:
            joint = before.along(direction)
            impedances.append((direction, _equivalent(term.parameter * before.laws[i][1][k], joint)))
    like = replace(before, response=replace(before.response, plant=plant)) if nearby else None
    changes = None
    if before.follows or any(
        item.effect.implicit for item in placed
    ):  # the drive force acts on the hidden motion
        changes = changes_by_others(before, placed, integrates=bool(integrated))
    return prediction_of(
        record,
        parameters,
        before=before,
        like=like,
        forces=forces,
        impedances=impedances,
        integrated=_integrated_effects(before, placed, integrated, changes) if integrated else None,
        follows=before.follows,
        changes=changes,
        path=_path(before, placed),
    )


def _integrated_effects(
    prediction: Prediction,
    placed: Sequence[Placed],
    laws: Sequence[tuple[FloatArray, Pointwise]],
    changes: ComplexArray | None,
) -> IntegratedEffects:
    """Laws on hidden motion, with the effects that change this motion."""
    heavier, misread = _heavier(prediction, placed), errors_of_positions(prediction, placed)
    return IntegratedEffects(
        laws,
        mass_change=heavier.effect.mass_change(prediction, heavier) if heavier is not None else None,
        follows=prediction.follows,
        force_change=None if changes is None else changes[0],
        misread=None if misread is None else misread[0],
    )


def _path(prediction: Prediction, placed: Iterable[Placed]) -> ForcePath | None:
    """The path of the drives' forces with these effects; None without effects of drives and without late readings."""
    found = [i for i in placed if i.effect.is_of_command or isinstance(i.effect, TransferEffect)]
    if not found:
        return None
    response, withheld = (make(prediction.record.measured) for make in (np.ones_like, np.zeros_like))
    unit = response.copy()
    for item in found:
        if item.effect.is_of_command:
            withheld += item.change(prediction)
        elif (late := item.effect.passed_on(prediction, item, unit)) is not None:
            response += late
    return ForcePath(response, withheld)


def _integrand(term: ScaledLaw) -> Pointwise:
    """A declared law as it is integrated."""
    level = dry_level(term.code)
    force = f"parameter * ({level or term.code})"
    return Pointwise(
        not_below_zero(force) if level else force, {"parameter": term.parameter}, dry=level is not None
    )


def _force(prediction: Prediction, item: Placed, joint: RecordedJoint) -> ComplexArray:
    """Spectrum of the force of an effect at the motion of a prediction."""
    assert isinstance(item.effect, JointEffect)
    return np.tensordot(item.amplitudes, item.effect.forces_at(prediction, joint, item.shape), 1)


def law_to_integrate(prediction: Prediction, item: Placed, *, read: bool = False) -> Pointwise | None:
    """Law of an effect on hidden motion, or on any that is `read` too; None if it is none point by point."""
    effect, record = item.effect, prediction.record
    if not isinstance(effect, JointEffect):
        return None
    direction = effect.joint(prediction, item.at).direction
    if not (record.is_predicted(direction) if read else record.is_hidden(direction)):
        return None
    return effect.pointwise(prediction, item.shape, item.amplitudes)


def _equivalent(force: ComplexArray, joint: RecordedJoint) -> ComplexArray:
    """Dynamic stiffness k + j w c - w^2 m closest to a force; the rest of the force moves hidden joints far less."""
    if not np.isfinite(force).all():
        raise OverflowError(f"the force at {joint.name} grows without bound")
    s = 1j * joint.record.omega
    motion = np.stack([joint.modelled, s * joint.modelled, s**2 * joint.modelled])
    scale = norms_or_one(motion, axis=1)
    unit = motion / scale[:, None]
    share = np.linalg.lstsq((unit.conj() @ unit.T).real, (unit.conj() @ force).real, rcond=1e-10)[0]
    k, c, m = share / scale
    return np.asarray(k + c * s + m * s**2)
