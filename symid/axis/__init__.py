"""Declaring an axis: elements, force laws, sensors, the nM-kS family, axis files. Needs neither sympy nor numpy."""

from symid.axis import imperfections
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
from symid.axis.imperfections import *  # noqa: F403
from symid.axis.laws import Hypothesis, Law, ShapeParameter, Term, along_stroke, constant, friction, spring
from symid.axis.laws.along_stroke import *  # noqa: F403
from symid.axis.laws.constant import *  # noqa: F403
from symid.axis.laws.friction import *  # noqa: F403
from symid.axis.laws.spring import *  # noqa: F403
from symid.axis.loading import axis_file, axis_names, load_axis, shipped_folder
from symid.axis.sketch import sketch, sketch_source
from symid.axis.source import axis_source, write_axis

__all__ = [
    "GROUND",
    "STANDARD_GRAVITY",
    "Acceleration",
    "Axis",
    "Between",
    "Body",
    "Damper",
    "Drive",
    "Element",
    "Geared",
    "Ground",
    "Hypothesis",
    "Joint",
    "Law",
    "PendulumWeight",
    "Position",
    "Sensor",
    "ShapeParameter",
    "Spring",
    "Term",
    "Velocity",
    "Weight",
    "axis_file",
    "axis_names",
    "axis_source",
    "chain",
    "derivative_order",
    "length_unit",
    "load_axis",
    "shipped_folder",
    "sketch",
    "sketch_source",
    "write_axis",
]
__all__ += along_stroke.__all__
__all__ += imperfections.__all__
__all__ += constant.__all__
__all__ += friction.__all__
__all__ += spring.__all__
