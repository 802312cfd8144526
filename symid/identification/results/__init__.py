"""Results: parameters with residuals, status and notes, and their application to other logs."""

from symid.identification.results.identification_result import EstimatedParameters, frame_of, headline_of
from symid.identification.results.status import Status, identification_status, not_by_structure

__all__ = [
    "EstimatedParameters",
    "Status",
    "frame_of",
    "headline_of",
    "identification_status",
    "not_by_structure",
]
