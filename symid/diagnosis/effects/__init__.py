"""The library of effects: everything that a diagnosis considers."""

from symid.axis import Cogging
from symid.diagnosis.effects.declared_imperfections import (
    declared_effects,
    effects_of_element,
    imperfection_of,
)
from symid.diagnosis.effects.effect import (
    ACTUATOR,
    Effect,
    JointEffect,
    Key,
    LinearEffect,
    MatchedFilter,
    Placed,
    Shape,
)
from symid.diagnosis.effects.forces import CoggingEffect, FlexibleMode, PayloadChange, PeriodicDisturbance
from symid.diagnosis.effects.friction_effects import (
    FrictionDrift,
    LoadDependentFriction,
    PreslidingFriction,
    SteadyFrictionDrift,
    is_part,
    with_parts,
)
from symid.diagnosis.effects.from_law import LawEffect, effects_of, library_of_laws
from symid.diagnosis.effects.signals import (
    LATE_FORCES,
    ActuatorLag,
    Delay,
    DriveEffect,
    EncoderRipple,
    GainAsymmetry,
    GainNonlinearity,
    RecordedLag,
    Saturation,
    SensorDelay,
    TransferEffect,
    force_at,
    with_alike,
)

LIBRARY: tuple[Effect, ...] = (
    *library_of_laws({Cogging: CoggingEffect}),
    PreslidingFriction(),
    LoadDependentFriction(),
    FrictionDrift(coulomb=True, viscous=False),
    FrictionDrift(coulomb=False, viscous=True),
    FrictionDrift(coulomb=True, viscous=True),
    SteadyFrictionDrift(coulomb=True, viscous=False),
    SteadyFrictionDrift(coulomb=False, viscous=True),
    PeriodicDisturbance(),
    PayloadChange(),
    FlexibleMode(),
    Delay(),
    ActuatorLag(),
    RecordedLag(),
    Saturation(),
    GainNonlinearity(2),
    GainNonlinearity(3),
    GainAsymmetry(),
    EncoderRipple(),
    SensorDelay(),
)
"""All effects that a diagnosis considers by default."""

__all__ = [
    "ACTUATOR",
    "LATE_FORCES",
    "LIBRARY",
    "ActuatorLag",
    "Delay",
    "DriveEffect",
    "Effect",
    "EncoderRipple",
    "FrictionDrift",
    "GainAsymmetry",
    "GainNonlinearity",
    "JointEffect",
    "Key",
    "LawEffect",
    "LinearEffect",
    "LoadDependentFriction",
    "MatchedFilter",
    "PayloadChange",
    "PeriodicDisturbance",
    "Placed",
    "Saturation",
    "Shape",
    "TransferEffect",
    "declared_effects",
    "effects_of",
    "effects_of_element",
    "force_at",
    "imperfection_of",
    "is_part",
    "with_alike",
    "with_parts",
]
