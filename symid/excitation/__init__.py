"""Design of the reference for an identification: the motion within limits that best determines the parameters."""

from symid.excitation.best_reference import Design, design
from symid.excitation.identification_trial import Expectation, IdentificationTrial
from symid.excitation.references import references

__all__ = ["Design", "Expectation", "IdentificationTrial", "design", "references"]
