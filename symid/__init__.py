"""symid: declare a machine axis, derive its regressors, identify it, and learn why simulation and machine differ."""

from symid.axis import (
    GROUND,
    Acceleration,
    AsymmetricFriction,
    Axis,
    Between,
    Body,
    CoulombFriction,
    Damper,
    Drive,
    Geared,
    Law,
    OffsetForce,
    PendulumWeight,
    Position,
    Spring,
    Term,
    UnknownZero,
    Velocity,
    ViscousFriction,
    Weight,
    chain,
    load_axis,
)

__version__ = "0.1.0"
