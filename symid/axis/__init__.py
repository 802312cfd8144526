"""Declaring an axis: elements, force laws, sensors, the nM-kS family, axis files. Needs neither sympy nor numpy."""

from symid.axis.axis import Axis, Element, length_unit
from symid.axis.chain import chain
from symid.axis.elements import (
    GROUND,
    STANDARD_GRAVITY,
    Acceleration,
    Between,
    Body,
    Damper,
    Drive,
    Geared,
    Ground,
    Joint,
    PendulumWeight,
    Position,
    Sensor,
    Spring,
    Velocity,
    Weight,
    derivative_order,
)
from symid.axis.laws import AsymmetricFriction, CoulombFriction, Law, OffsetForce, Term, ViscousFriction
from symid.axis.loading import axis_file, axis_names, load_axis, shipped_folder

__all__ = [
    "GROUND",
    "STANDARD_GRAVITY",
    "Acceleration",
    "AsymmetricFriction",
    "Axis",
    "Between",
    "Body",
    "CoulombFriction",
    "Damper",
    "Drive",
    "Element",
    "Geared",
    "Ground",
    "Joint",
    "Law",
    "OffsetForce",
    "PendulumWeight",
    "Position",
    "Sensor",
    "Spring",
    "Term",
    "Velocity",
    "ViscousFriction",
    "Weight",
    "axis_file",
    "axis_names",
    "chain",
    "derivative_order",
    "length_unit",
    "load_axis",
    "shipped_folder",
]
