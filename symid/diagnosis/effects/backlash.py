"""The effect of play in a spring."""

import math
from collections.abc import Iterable
from itertools import product

from symid.axis import Spring
from symid.diagnosis.effects.effect import Placed, Shape
from symid.diagnosis.effects.from_law import LawEffect
from symid.diagnosis.prediction.joint import RecordedJoint
from symid.diagnosis.prediction.places import place_of
from symid.diagnosis.prediction.prediction import Prediction
from symid.diagnosis.thresholds import THRESHOLDS

_NARROW, _RIGID = (0.003, 0.01, 0.03, 0.1), (1.0,)
"""Initial widths of a play that a spring passes at its reversals, relative to its largest deflection, and initial
losses of stiffness in the play, relative to that of the spring."""
_RATTLING, _SOFTER = (0.02, 0.05, 0.1, 0.3, 1.0), (0.1, 1.0)
"""The same of a play in which a body rattles."""


class BacklashEffect(LawEffect):
    """Play within which a spring is much softer."""

    def hidden_starts(
        self, spring: RecordedJoint, stiffness: float, *, rattles: bool
    ) -> Iterable[tuple[Shape, tuple[float, ...]]]:
        """Initial shapes and amplitudes of a play in a hidden spring of that stiffness, in which a body may rattle."""
        largest = max(map(abs, spring.range))
        trials = product(_RATTLING, _SOFTER) if rattles else product(_NARROW, _RIGID)
        return [((width * largest,), (loss * stiffness,)) for width, loss in trials]

    def is_possible(self, prediction: Prediction, placed: Placed) -> bool:
        axis = prediction.axis
        springs = (e for e in axis.elements if isinstance(e, Spring) and place_of(e) == placed.at)
        values = axis.with_known_values(prediction.parameters)
        stiffness = math.fsum(values[spring.named("stiffness")] for spring in springs)
        return placed.amplitudes[0] > THRESHOLDS.least_play * stiffness
