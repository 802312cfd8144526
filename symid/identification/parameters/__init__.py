"""Physical from minimal parameters, with what is known of them beforehand."""

from symid.identification.parameters.constraints import Bounds, Priors
from symid.identification.parameters.physical import jacobian, negative_parameters, open_by_structure

__all__ = [
    "Bounds",
    "Priors",
    "jacobian",
    "negative_parameters",
    "open_by_structure",
]
