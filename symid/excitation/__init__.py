"""Design of the reference for an identification: which motion within limits tells the parameters best."""

from symid.excitation.design import Design, design
from symid.excitation.expectation import Expectation, Experiment
from symid.excitation.references import references

__all__ = ["Design", "Expectation", "Experiment", "design", "references"]
