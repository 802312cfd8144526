"""The effect of play in a spring."""

import math

from symid.axis import Spring
from symid.diagnosis.effects.effect import Placed
from symid.diagnosis.effects.from_law import LawEffect
from symid.diagnosis.prediction.places import place_of
from symid.diagnosis.prediction.prediction import Prediction
from symid.diagnosis.thresholds import THRESHOLDS


class BacklashEffect(LawEffect):
    """Play within which a spring is much softer."""

    def is_possible(self, prediction: Prediction, placed: Placed) -> bool:
        axis = prediction.axis
        springs = (e for e in axis.elements if isinstance(e, Spring) and place_of(e) == placed.at)
        values = axis.with_known_values(prediction.parameters)
        stiffness = math.fsum(values[spring.named("stiffness")] for spring in springs)
        return placed.amplitudes[0] > THRESHOLDS.least_play * stiffness
