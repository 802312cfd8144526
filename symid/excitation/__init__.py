"""Design of the reference for an identification: the motion within limits that best determines the parameters."""

from symid.excitation.best_reference import FINAL_RUNS, LEAST_RUNS, Design, design
from symid.excitation.identification_trial import Expectation, IdentificationTrial
from symid.excitation.references import references

__all__ = ["FINAL_RUNS", "LEAST_RUNS", "Design", "Expectation", "IdentificationTrial", "design", "references"]
