"""The library of effects: everything that a diagnosis considers."""

from symid.diagnosis.effects.base import ACTUATOR, Effect, JointEffect, LinearEffect, Placed, Pull, Shape
from symid.diagnosis.effects.forces import (
    Backlash,
    Cogging,
    FlexibleMode,
    OffsetForce,
    PayloadChange,
    PeriodicDisturbance,
    PositionStiffness,
    StiffnessNonlinearity,
)
from symid.diagnosis.effects.friction import (
    AsymmetricFriction,
    CoulombAsymmetry,
    CoulombFriction,
    FrictionDrift,
    LoadDependentFriction,
    PreslidingFriction,
    QuadraticDrag,
    SlopedFriction,
    SlopedViscousFriction,
    StribeckFriction,
    ViscousFriction,
    WavyFriction,
)
from symid.diagnosis.effects.signals import (
    ActuatorLag,
    Delay,
    DriveEffect,
    EncoderRipple,
    GainAsymmetry,
    GainNonlinearity,
    Saturation,
)

LIBRARY: tuple[Effect, ...] = (
    ViscousFriction(),
    CoulombFriction(),
    StribeckFriction(),
    AsymmetricFriction(),
    CoulombAsymmetry(),
    PreslidingFriction(),
    LoadDependentFriction(),
    SlopedFriction(level=False),
    SlopedFriction(level=True),
    SlopedViscousFriction(coulomb=False),
    SlopedViscousFriction(coulomb=True),
    WavyFriction(level=False),
    WavyFriction(level=True),
    FrictionDrift(coulomb=True, viscous=False),
    FrictionDrift(coulomb=False, viscous=True),
    FrictionDrift(coulomb=True, viscous=True),
    QuadraticDrag(),
    OffsetForce(),
    PositionStiffness(),
    Cogging(),
    PeriodicDisturbance(),
    PayloadChange(),
    Backlash(),
    StiffnessNonlinearity(),
    FlexibleMode(),
    Delay(),
    ActuatorLag(),
    Saturation(),
    GainNonlinearity(2),
    GainNonlinearity(3),
    GainAsymmetry(),
    EncoderRipple(),
)
"""Everything that a diagnosis considers, unless told otherwise."""

__all__ = [
    "ACTUATOR",
    "LIBRARY",
    "DriveEffect",
    "Effect",
    "JointEffect",
    "LinearEffect",
    "Placed",
    "Pull",
    "Shape",
]
