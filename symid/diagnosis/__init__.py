"""Why a simulation and a machine differ: the gap, where it lies, which effect causes it, how far it shrinks."""

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
    "Alternative",
    "Diagnosis",
    "EffectParameter",
    "FoundEffect",
    "Gap",
    "Level",
    "Location",
    "MapCell",
    "ParameterChange",
    "Signals",
    "Spectrum",
]
