"""Why a simulation and a machine differ: the gap, where it lies, which effect causes it, how far it shrinks."""

from symid.diagnosis.diagnose import diagnose
from symid.diagnosis.effects import LIBRARY, Effect
from symid.diagnosis.result import (
    Alternative,
    Diagnosis,
    EffectParameter,
    FoundEffect,
    Gap,
    Level,
    Location,
    MapCell,
    ParameterChange,
    Signals,
    Spectrum,
)

__all__ = [
    "LIBRARY",
    "Alternative",
    "Diagnosis",
    "Effect",
    "EffectParameter",
    "FoundEffect",
    "Gap",
    "Level",
    "Location",
    "MapCell",
    "ParameterChange",
    "Signals",
    "Spectrum",
    "diagnose",
]
