"""Effects as imperfections of an axis, and declared imperfections as effects."""

from collections.abc import Iterable

from symid.axis import (
    ActuatorDelay,
    ActuatorLag,
    Axis,
    DriveImperfection,
    EncoderRipple,
    ForceConstantRipple,
    ForceLimit,
    FrictionDrift,
    FrictionTrend,
    GainAsymmetry,
    GainNonlinearity,
    Imperfection,
    JointImperfection,
    LoadDependentFriction,
    PayloadChange,
    PeriodicForce,
    PreslidingFriction,
)
from symid.diagnosis.effects.effect import ACTUATOR, Effect, Placed, Shape
from symid.diagnosis.effects.friction_drift import FrictionDriftEffect, SteadyFrictionDriftEffect
from symid.diagnosis.effects.load_dependent_friction import LoadDependentFrictionEffect
from symid.diagnosis.effects.payload_change import PayloadChangeEffect
from symid.diagnosis.effects.periodic_disturbance import PeriodicDisturbanceEffect
from symid.diagnosis.effects.presliding_friction import PreslidingFrictionEffect
from symid.diagnosis.effects.repeating import EncoderRippleEffect, ForceConstantRippleEffect
from symid.diagnosis.effects.signals import (
    ActuatorLagEffect,
    DelayEffect,
    GainAsymmetryEffect,
    GainNonlinearityEffect,
    SaturationEffect,
)
from symid.diagnosis.prediction.places import place_named
from symid.diagnosis.prediction.prediction import Prediction


def imperfection_of(axis: Axis, item: Placed) -> Imperfection | None:
    """An effect in the drive, in a reading or in time as an element; None if it is none, or acts before its cause."""
    effect, shape, amplitudes = item.effect, item.shape, item.amplitudes
    drive = None if item.at == ACTUATOR else item.at
    match effect:
        case DelayEffect():
            return ActuatorDelay(shape[0], drive=drive) if shape[0] > 0 else None
        case ActuatorLagEffect():
            return ActuatorLag(amplitudes[0], drive=drive)
        case SaturationEffect():
            return ForceLimit(shape[0], drive=drive)
        case GainNonlinearityEffect():
            return GainNonlinearity(amplitudes[0], power=effect.power, drive=drive)
        case GainAsymmetryEffect():
            return GainAsymmetry(amplitudes[0], drive=drive)
        case ForceConstantRippleEffect():
            return ForceConstantRipple(*amplitudes, *shape, drive=drive)
        case EncoderRippleEffect():
            return EncoderRipple(item.at, *amplitudes, *shape)
        case PeriodicDisturbanceEffect():
            return PeriodicForce(place_named(axis, item.at), *amplitudes, *shape)
        case PayloadChangeEffect():
            change, moment = shape
            body = next(b for b in axis.bodies if b.name == item.at)
            return PayloadChange(body, amplitudes[0] * change, time=moment)
        case FrictionDriftEffect():
            coulomb, viscous = amplitudes[0] * effect.coulomb, amplitudes[-1] * effect.viscous
            place = place_named(axis, item.at)
            if not shape:
                return FrictionTrend(place, coulomb, viscous)
            return FrictionDrift(place, coulomb, viscous, time_constant=shape[0])
        case LoadDependentFrictionEffect():
            return LoadDependentFriction(place_named(axis, item.at), amplitudes[0])
    return None


def declared_effects(prediction: Prediction) -> tuple[Placed, ...]:
    """Imperfections of the axis with their numbers, those that the log can show."""
    elements = prediction.axis.imperfections
    return tuple(item for element in elements for item in effects_of_element(prediction, element))


def effects_of_element(prediction: Prediction, element: Imperfection) -> tuple[Placed, ...]:
    """An imperfection at its place, one of the drive at each of several; empty if the log cannot show it."""
    known = _as_effect(element)
    if known is None:
        return ()
    effect, shape, amplitudes = known
    possible = effect.places(prediction)
    match element:
        case EncoderRipple():
            places: Iterable[str] = (element.signal,)
        case PayloadChange():
            places = (element.body.name,)
        case DriveImperfection(drive=str(signal)) if len(prediction.axis.drives) > 1:
            places = (signal,)
        case JointImperfection():
            named = prediction.joints
            places = [name for name in named if place_named(prediction.axis, name) == element.at]
        case _:
            places = possible
    return tuple(Placed(effect, at, shape, amplitudes) for at in places if at in possible)


def _as_effect(element: Imperfection) -> tuple[Effect, Shape, tuple[float, ...]] | None:
    """Effect, shape and amplitudes, of which a fixed one is 1; None where no effect stands for the element."""
    match element:
        case ActuatorDelay():
            return DelayEffect(), (element.seconds,), (1.0,)
        case ActuatorLag():
            return ActuatorLagEffect(), (), (element.seconds,)
        case ForceLimit():
            return SaturationEffect(), (element.force,), (1.0,)
        case GainNonlinearity():
            return GainNonlinearityEffect(element.power), (), (element.bend,)
        case GainAsymmetry():
            return GainAsymmetryEffect(), (), (element.difference,)
        case EncoderRipple():
            return EncoderRippleEffect(), (element.pitch,), (element.sine, element.cosine)
        case ForceConstantRipple():
            return ForceConstantRippleEffect(), (element.pitch,), (element.sine, element.cosine)
        case PeriodicForce():
            return PeriodicDisturbanceEffect(), (element.frequency,), (element.sine, element.cosine)
        case PayloadChange():
            return PayloadChangeEffect(), (element.change, element.time), (1.0,)
        case PreslidingFriction():
            return PreslidingFrictionEffect(), (element.reach,), (element.level,)
        case LoadDependentFriction():
            return LoadDependentFrictionEffect(), (), (element.coefficient,)
        case FrictionDrift() | FrictionTrend() if element.coulomb or element.viscous:
            levels = element.coulomb, element.viscous
            has_course = isinstance(element, FrictionDrift)
            drifts = FrictionDriftEffect if has_course else SteadyFrictionDriftEffect
            effect = drifts(coulomb=levels[0] != 0, viscous=levels[1] != 0)
            shape = (element.time_constant,) if isinstance(element, FrictionDrift) else ()
            return effect, shape, tuple(level for level in levels if level)
    return None
