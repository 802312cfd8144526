"""Why a simulation and a machine differ: the gap, where it lies, which effect causes it, how far it shrinks.

Read `diagnose.py` first, which calls the packages in this order. `prediction` evaluates the axis on a log. `effects` is
the library of effects that a model may lack. `fitting` estimates parameters and effects by least squares. `selection`
chooses effects by forward selection. `findings` concludes the result. `in_motion` simulates the model found under the
controller. `experiment` designs the next experiment. All thresholds are in `thresholds`.
"""

from symid.diagnosis.against import diagnose_against
from symid.diagnosis.diagnose import diagnose
from symid.diagnosis.effects import LIBRARY, Effect
from symid.diagnosis.experiment.design import limits_seen, next_experiment_of
from symid.diagnosis.findings.diagnosis_result import (
    Diagnosis,
    Signals,
    SimulatedEffect,
    SimulatedParameter,
    Simulator,
    Spectrum,
)
from symid.diagnosis.findings.found_effects import Alternative, EffectParameter, FoundEffect, ParameterChange
from symid.diagnosis.findings.gap import (
    Gap,
    Level,
    Location,
    MapCell,
    MotionError,
    Removed,
    Reversal,
    SimulatedMotion,
)
from symid.diagnosis.findings.planned_experiment import Experiment
from symid.diagnosis.in_motion.declared import ExplainedAxis, explained_axis

__all__ = [
    "LIBRARY",
    "Alternative",
    "Diagnosis",
    "Effect",
    "EffectParameter",
    "Experiment",
    "ExplainedAxis",
    "FoundEffect",
    "Gap",
    "Level",
    "Location",
    "MapCell",
    "MotionError",
    "ParameterChange",
    "Removed",
    "Reversal",
    "Signals",
    "SimulatedEffect",
    "SimulatedMotion",
    "SimulatedParameter",
    "Simulator",
    "Spectrum",
    "diagnose",
    "diagnose_against",
    "explained_axis",
    "limits_seen",
    "next_experiment_of",
]
