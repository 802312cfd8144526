"""symid: declare a machine axis, derive its regressors, identify it, and learn why simulation and machine differ."""

from typing import TYPE_CHECKING, Any

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
from symid.errors import SymidError

if TYPE_CHECKING:
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

__version__ = "0.1.0"

_LAZY = {
    "Batch": "symid.fleet",
    "BatchSettings": "symid.fleet",
    "compiled": "symid.codegen",
    "derive": "symid.symbolic",
    "DerivedModel": "symid.symbolic",
    "diagnose": "symid.diagnosis",
    "Diagnosis": "symid.diagnosis",
    "generate": "symid.codegen.generate",
    "identify": "symid.verbs.identify_any",
    "identify_batch": "symid.fleet",
    "Identification": "symid.identification",
    "load_generated": "symid.codegen",
    "Log": "symid.data",
    "predict": "symid.identification",
    "Preparation": "symid.identification",
    "read_axis_log": "symid.identification",
    "read_log": "symid.data",
    "simulate": "symid.simulation",
    "tune": "symid.tuning",
    "Tuning": "symid.tuning",
}
"""Packages that load sympy or scipy, imported when a name is used: declaring an axis needs neither."""


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'symid' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_LAZY[name]), name)


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})


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
