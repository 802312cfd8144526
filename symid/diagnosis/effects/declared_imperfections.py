"""Effects as imperfections of an axis, and declared imperfections as effects."""

from collections.abc import Iterable
from typing import Any, NamedTuple

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


class _Pair(NamedTuple):
    """An element, the effect that it is, and the fields that hold the values of the effect."""

    element: type[Imperfection]
    effect: type[Effect]
    shape: tuple[str, ...] = ()
    amplitudes: tuple[str, ...] = ()  # none for an effect whose amplitude is 1


_PAIRS = (
    _Pair(ActuatorDelay, DelayEffect, shape=("seconds",)),
    _Pair(ActuatorLag, ActuatorLagEffect, amplitudes=("seconds",)),
    _Pair(ForceLimit, SaturationEffect, shape=("force",)),
    _Pair(GainNonlinearity, GainNonlinearityEffect, amplitudes=("bend",)),
    _Pair(GainAsymmetry, GainAsymmetryEffect, amplitudes=("difference",)),
    _Pair(ForceConstantRipple, ForceConstantRippleEffect, ("pitch",), ("sine", "cosine")),
    _Pair(EncoderRipple, EncoderRippleEffect, ("pitch",), ("sine", "cosine")),
    _Pair(PeriodicForce, PeriodicDisturbanceEffect, ("frequency",), ("sine", "cosine")),
    _Pair(PayloadChange, PayloadChangeEffect, shape=("change", "time")),
    _Pair(PreslidingFriction, PreslidingFrictionEffect, ("reach",), ("level",)),
    _Pair(LoadDependentFriction, LoadDependentFrictionEffect, amplitudes=("coefficient",)),
    _Pair(FrictionTrend, SteadyFrictionDriftEffect, amplitudes=("coulomb", "viscous")),
    _Pair(FrictionDrift, FrictionDriftEffect, ("time_constant",), ("coulomb", "viscous")),
)


def imperfection_of(axis: Axis, item: Placed) -> Imperfection | None:
    """An effect in the drive, in a reading or in time as an element; None if it is none, or acts before its cause."""
    effect, amplitudes = item.effect, item.amplitudes
    pair = next((pair for pair in _PAIRS if isinstance(effect, pair.effect)), None)
    if pair is None or (isinstance(effect, DelayEffect) and not item.shape[0] > 0):
        return None
    values: dict[str, Any] = dict(zip(pair.shape, item.shape, strict=True))
    if isinstance(effect, FrictionDriftEffect):  # one of both amplitudes may be absent
        values |= {"coulomb": amplitudes[0] * effect.coulomb, "viscous": amplitudes[-1] * effect.viscous}
    else:
        values |= dict(zip(pair.amplitudes, amplitudes, strict=False))
    if isinstance(effect, GainNonlinearityEffect):
        values["power"] = effect.power
    if issubclass(pair.element, DriveImperfection):
        values["drive"] = None if item.at == ACTUATOR else item.at
    elif issubclass(pair.element, JointImperfection):
        values["at"] = place_named(axis, item.at)
    elif pair.element is PayloadChange:
        values["body"] = next(body for body in axis.bodies if body.name == item.at)
    else:
        values["signal"] = item.at
    return pair.element(**values)


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
    pair = next((pair for pair in _PAIRS if isinstance(element, pair.element)), None)
    if pair is None:
        return None
    shape = tuple(getattr(element, name) for name in pair.shape)
    amplitudes = tuple(getattr(element, name) for name in pair.amplitudes)
    if issubclass(pair.effect, FrictionDriftEffect):
        if not any(amplitudes):
            return None
        coulomb, viscous = amplitudes
        effect: Effect = pair.effect(coulomb=coulomb != 0, viscous=viscous != 0)
        return effect, shape, tuple(level for level in amplitudes if level)
    effect = GainNonlinearityEffect(element.power) if isinstance(element, GainNonlinearity) else pair.effect()
    return effect, shape, amplitudes or (1.0,)
