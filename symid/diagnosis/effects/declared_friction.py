"""Friction that an axis declares: its level in a joint, and the joints in which it shows as one."""

from __future__ import annotations

import numpy as np

from symid.axis import Law
from symid.diagnosis.prediction.prediction import Prediction


def declared_level(prediction: Prediction, place: str, kind: type[Law]) -> float:
    """Coefficient of the declared friction of a kind in a joint; 0 if none is declared."""
    laws = (
        law
        for law in prediction.axis.laws
        if isinstance(law, kind) and getattr(law.at, "name", None) == place
    )
    values = prediction.axis.with_known_values(prediction.parameters)
    return sum(abs(values[term.parameter]) for law in laws for term in law.terms())


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
