"""An axis at given parameter values: forward dynamics, laws and imperfections, state of rest, frequency response."""

from symid.simulation.plants.dynamics_terms import LawTerm
from symid.simulation.plants.equilibrium import equilibrium
from symid.simulation.plants.frequency_response import (
    COHERENT,
    FrequencyResponse,
    ResponseBand,
    degrees_of,
    has_response,
    identified_response,
    response_band,
    response_of,
)
from symid.simulation.plants.imperfect_plant import misreading
from symid.simulation.plants.law_code import (
    array_function,
    dry_level,
    has_jumps,
    law_code,
    level_code,
    not_below_zero,
)
from symid.simulation.plants.plant import JUST_MOVING, JointLaw, ScaledLaw, condensed, direction_of
from symid.simulation.plants.postfix import Program, program

__all__ = [
    "COHERENT",
    "JUST_MOVING",
    "FrequencyResponse",
    "JointLaw",
    "LawTerm",
    "Program",
    "ResponseBand",
    "ScaledLaw",
    "array_function",
    "condensed",
    "degrees_of",
    "direction_of",
    "dry_level",
    "equilibrium",
    "has_jumps",
    "has_response",
    "identified_response",
    "law_code",
    "level_code",
    "misreading",
    "not_below_zero",
    "program",
    "response_band",
    "response_of",
]
