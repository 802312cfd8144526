"""Detection of logs whose force is constant while the axis moves: friction alone explains them."""

from __future__ import annotations

import numpy as np

from symid.axis import CoulombFriction
from symid.diagnosis.effects.declared_friction import places_of
from symid.diagnosis.fitting.fit import Fit
from symid.identification.faults.constant_force import CONSTANT, is_constant

_FAST = 0.1
"""Share of the top speed above which the direction of a motion is certain."""


def steady_force(fit: Fit) -> str:
    """Sentence if the force of an axis with free friction and inertia hardly changes in motion; otherwise empty."""
    prediction = fit.state.prediction
    record, free = prediction.record, prediction.parameters
    if record.n_drives > 1 or not record.dynamics.parameters_of("mass") & free.keys():
        return ""
    (name,), at = record.forces, np.rint(record.fine_time / record.log.sampling_period).astype(int)
    force = record.log[name][np.minimum(at, record.log.n_samples - 1)]
    for law in prediction.axis.laws:
        is_free = isinstance(law, CoulombFriction) and any(term.parameter in free for term in law.terms())
        for place in places_of(prediction, law) if is_free else ():
            joint = prediction.joints[place]
            fast = record.in_log & (np.abs(joint.v) > _FAST * joint.top_speed)
            if is_constant(force[fast], np.sign(joint.v[fast])[None]):
                return CONSTANT.format(name)
    return ""
