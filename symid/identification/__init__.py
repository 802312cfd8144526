"""Identification: observation of logs, estimation, physical parameters."""

from symid.identification.identify import Identification, identify
from symid.identification.logs import measured_signals, read_axis_log
from symid.identification.observation import Observation, observe
from symid.identification.physical import PhysicalEstimate, physical_estimates
from symid.identification.prediction import Prediction, predict
from symid.identification.residuals import EquationResidual
from symid.identification.settings import Preparation

__all__ = [
    "EquationResidual",
    "Identification",
    "Observation",
    "PhysicalEstimate",
    "Prediction",
    "Preparation",
    "identify",
    "measured_signals",
    "observe",
    "physical_estimates",
    "predict",
    "read_axis_log",
]
