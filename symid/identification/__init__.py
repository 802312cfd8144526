"""Identification: observation of logs, estimation, physical parameters."""

from symid.identification.identify import EquationResidual, Identification, identify, predict
from symid.identification.observation import Observation, observe
from symid.identification.physical import PhysicalEstimate, physical_estimates
from symid.identification.settings import Preparation

__all__ = [
    "EquationResidual",
    "Identification",
    "Observation",
    "PhysicalEstimate",
    "Preparation",
    "identify",
    "observe",
    "physical_estimates",
    "predict",
]
