"""symid: declare a machine axis, derive its regressors, identify it, and learn why simulation and machine differ."""

from typing import TYPE_CHECKING, Any

from symid.errors import SymidError

if TYPE_CHECKING:
    from symid.axis import (
        GROUND,
        Axis,
        Between,
        Body,
        Damper,
        Drive,
        Geared,
        PendulumWeight,
        Spring,
        Weight,
        axis_source,
        chain,
        drive_imperfections,
        imperfections,
        laws,
        load_axis,
        sensors,
        write_axis,
    )
    from symid.axis.drive_imperfections import *  # noqa: F403
    from symid.axis.imperfections import *  # noqa: F403
    from symid.axis.laws.along_stroke import *  # noqa: F403
    from symid.axis.laws.constant import *  # noqa: F403
    from symid.axis.laws.friction import *  # noqa: F403
    from symid.axis.laws.law import *  # noqa: F403
    from symid.axis.laws.spring import *  # noqa: F403
    from symid.axis.sensors import *  # noqa: F403
    from symid.codegen import compiled, load_generated
    from symid.codegen.generate import generate
    from symid.data import Log, read_log
    from symid.diagnosis import Diagnosis, diagnose
    from symid.fleet import Batch, BatchSettings, identify_batch
    from symid.identification import Identification, Preparation, predict, read_axis_log
    from symid.simulation import simulate
    from symid.symbolic import DerivedModel, derive
    from symid.tuning import Tuning, tune
    from symid.verbs.identify_any import identify

    __all__ = [
        "GROUND",
        "Axis",
        "Batch",
        "BatchSettings",
        "Between",
        "Body",
        "Damper",
        "DerivedModel",
        "Diagnosis",
        "Drive",
        "Geared",
        "Identification",
        "Log",
        "PendulumWeight",
        "Preparation",
        "Spring",
        "SymidError",
        "Tuning",
        "Weight",
        "axis_source",
        "chain",
        "compiled",
        "derive",
        "diagnose",
        "generate",
        "identify",
        "identify_batch",
        "load_axis",
        "load_generated",
        "predict",
        "read_axis_log",
        "read_log",
        "simulate",
        "tune",
        "write_axis",
    ]
    __all__ += drive_imperfections.__all__
    __all__ += imperfections.__all__
    __all__ += laws.__all__
    __all__ += sensors.__all__

__version__ = "0.1.0"

_LAZY = {
    "symid.axis": (
        "GROUND",
        "Axis",
        "Between",
        "Body",
        "Damper",
        "Drive",
        "Geared",
        "PendulumWeight",
        "Spring",
        "Weight",
        "axis_source",
        "chain",
        "load_axis",
        "write_axis",
    ),
    "symid.codegen": ("compiled", "load_generated"),
    "symid.codegen.generate": ("generate",),
    "symid.data": ("Log", "read_log"),
    "symid.diagnosis": ("Diagnosis", "diagnose"),
    "symid.fleet": ("Batch", "BatchSettings", "identify_batch"),
    "symid.identification": ("Identification", "Preparation", "predict", "read_axis_log"),
    "symid.simulation": ("simulate",),
    "symid.symbolic": ("DerivedModel", "derive"),
    "symid.tuning": ("Tuning", "tune"),
    "symid.verbs.identify_any": ("identify",),
}
"""Modules that are imported when a name is used: declaring an axis needs neither sympy nor scipy, and an interrupt in
the first moments of a command meets nothing that loads."""


def __getattr__(name: str) -> Any:
    from importlib import import_module

    for module, names in _LAZY.items():
        if name in names:
            return getattr(import_module(module), name)
    if name in ("__path__", "__wrapped__"):  # asked by the import system and by inspect
        raise AttributeError(name)
    axis = import_module("symid.axis")
    parts = {
        part: getattr(axis, part) for part in ("drive_imperfections", "imperfections", "laws", "sensors")
    }
    laws = [law for part in parts.values() for law in part.__all__]
    if name == "__all__":
        return ["SymidError", *(each for names in _LAZY.values() for each in names), *laws]
    if name == "axis":
        return axis
    if name in parts or name in laws:
        return getattr(axis, name)
    raise AttributeError(f"module 'symid' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*__getattr__("__all__"), *(name for name in globals() if name.startswith("__"))})
