"""The gap in the motion: the axis with the effects found, simulated along the log.

`declared` makes effects elements of the axis, `replayed` simulates it under the controller of the log, `motion`
compares the motion, and `corrected` corrects values for the bias of the fit. `identified_motion` does the same for an
identified axis.
"""

from symid.diagnosis.in_motion.declared import explained_response
from symid.diagnosis.in_motion.identified_motion import IdentifiedMotion, identified_motion

__all__ = [
    "IdentifiedMotion",
    "explained_response",
    "identified_motion",
]
