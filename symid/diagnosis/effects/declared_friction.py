"""Friction that an axis declares: its level in a joint, and the joints in which it shows as one."""

import numpy as np

from symid.axis import Law, ViscousFriction
from symid.diagnosis.prediction.prediction import Prediction
from symid.simulation.plants import direction_of


def places_of(prediction: Prediction, law: Law) -> dict[str, float]:
    """Bodies in whose joint a law acts, also by a gear, with the displacement in the law's joint per theirs."""
    own, found = direction_of(law.at, prediction.response.plant.bodies), dict[str, float]()
    for place, joint in prediction.joints.items():
        ratio = float(own @ joint.direction / (joint.direction @ joint.direction))
        if ratio and np.allclose(own, ratio * joint.direction, rtol=1e-9, atol=0.0):
            found[place] = ratio
    return found


def declared_level(prediction: Prediction, place: str, kind: type[Law]) -> float:
    """Coefficient of the declared friction of a kind in a joint; 0 if none is declared."""
    values, level = prediction.axis.with_known_values(prediction.parameters), 0.0
    power = 2 if issubclass(kind, ViscousFriction) else 1  # a gear acts on the velocity and on the force
    for law in prediction.axis.laws:
        if isinstance(law, kind) and (ratio := places_of(prediction, law).get(place)):
            level += sum(abs(values[term.parameter]) for term in law.terms()) * abs(ratio) ** power
    return level


_TOGETHER = 0.99
"""Correlation of the velocities of joints that move in proportion."""


def moving_along(prediction: Prediction, place: str) -> dict[str, float]:
    """Joints that move in proportion to one, including itself, with the factor of their friction there.

    For a motor and its load, whose motions differ by vibrations only, a log shows the sum of their dry frictions.
    """
    own, inside = prediction.joints[place], prediction.record.in_log
    return {
        name: joint.top_speed / own.top_speed
        for name, joint in prediction.joints.items()
        if joint is own or abs(np.corrcoef(joint.v[inside], own.v[inside])[0, 1]) > _TOGETHER
    }
