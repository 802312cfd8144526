"""Results: parameters with residuals, status and notes, and their application to other logs."""

from symid.identification.results.identification_result import EstimatedParameters, frame_of, headline_of
from symid.identification.results.verdict import Status, not_by_structure, verdict

__all__ = [
    "EstimatedParameters",
    "Status",
    "frame_of",
    "headline_of",
    "not_by_structure",
    "verdict",
]
