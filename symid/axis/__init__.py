"""Declaring an axis: elements, force laws, sensors, the nM-kS family, axis files. Needs neither sympy nor numpy."""

from symid.axis import drive_imperfections, elements, imperfections, laws, sensors
from symid.axis.axis import Axis, Element
from symid.axis.carriers import carrier_of
from symid.axis.drive_imperfections import *
from symid.axis.drive_imperfections import imperfections_in_order, ripples_of
from symid.axis.elements import *
from symid.axis.elements import Parameter, joint_label
from symid.axis.imperfections import *
from symid.axis.laws.along_stroke import *
from symid.axis.laws.constant import *
from symid.axis.laws.friction import *
from symid.axis.laws.law import *
from symid.axis.laws.law import LAW_FUNCTIONS
from symid.axis.laws.spring import *
from symid.axis.loading import (
    AnyAxis,
    axis_file,
    axis_names,
    axis_of,
    installed_folder,
    load_axis,
    of_any_axis,
    shipped_folder,
)
from symid.axis.quantities import force_unit, length_unit
from symid.axis.sensors import *
from symid.axis.sensors import controlled_of
from symid.axis.sketch import chain, sketch, sketch_source
from symid.axis.source import axis_path, axis_source, declared_lines, write_axis

__all__ = [
    "LAW_FUNCTIONS",
    "AnyAxis",
    "Axis",
    "Element",
    "Parameter",
    "axis_file",
    "axis_names",
    "axis_of",
    "axis_path",
    "axis_source",
    "carrier_of",
    "chain",
    "controlled_of",
    "declared_lines",
    "force_unit",
    "imperfections_in_order",
    "installed_folder",
    "joint_label",
    "length_unit",
    "load_axis",
    "of_any_axis",
    "ripples_of",
    "shipped_folder",
    "sketch",
    "sketch_source",
    "write_axis",
]
__all__ += elements.__all__
__all__ += drive_imperfections.__all__
__all__ += imperfections.__all__
__all__ += laws.__all__
__all__ += sensors.__all__
