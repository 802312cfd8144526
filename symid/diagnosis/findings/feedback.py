"""Detection of logs in which friction would be negative: a feedback law, or a wrong sign.

While the reference stands still, the force of a controller depends on position and speed only: u = c - Kp q - Kd v. A
model with friction and a spring of opposite sign has the same form and explains the log whatever the machine is. If no
such law explains the force and the friction of the axis as a whole is negative, the sign of the force or of a position
is wrong. In slow motion only the friction shows this, not the inertia.
"""

import numpy as np

from symid.axis import CoulombFriction, ViscousFriction
from symid.diagnosis.effects.declared_friction import places_of
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.prediction.prediction import Prediction

_AS_GOOD = 1.2
"""Largest error of the feedback law, relative to that of the model, at which the model may be this law."""
_OF_FORCE = 0.3
"""Largest error of the feedback law, relative to the force: a controller alone would leave none."""
_SURELY = 3.0
"""Standard deviations of a negative power of friction from which on it is not doubted."""
_OF_POWER = 0.2
"""Least negative power of friction, relative to the mean absolute power of the drive."""


def feedback_law(fit: Fit) -> str:
    """Sentence if a log shows its controller, that is, if the fitted model is a feedback law; otherwise empty."""
    record = fit.state.prediction.record
    dampings = record.dynamics.parameters_of("damping")
    if record.n_drives > 1 or not any(fit.parameters[name] < 0 for name in dampings):
        return ""
    motion, constant = record.motions[0], np.zeros(record.n_bins, dtype=complex)
    constant[0] = record.n_extended
    spectra = np.zeros((4, *record.measured.shape), dtype=complex)
    spectra[:, 0] = constant, motion, 1j * record.omega * motion, record.measured[0]
    rows = np.concatenate([fit.weighting.rows(spectra), fit.state.rows[None]])
    known = fit.weighting.projected(rows, fit.state.beginning).reshape(len(rows), len(record.measured), -1)
    *law, force, error = known[:, 0]
    gains = np.linalg.lstsq(np.transpose(law), force)[0]
    left = float(np.linalg.norm(force - gains @ law))
    share = left / float(np.linalg.norm(force))
    as_good = left < _AS_GOOD * float(np.linalg.norm(error)) and share < _OF_FORCE
    if not (gains[1] < 0 and gains[2] < 0 and as_good):
        return ""
    name, position = record.forces[0], record.driven[0]
    return (
        f"{name} follows from {position} and its speed alone, {gains[0]:.3g} - {-gains[1]:.3g} {position} - "
        f"{-gains[2]:.3g} d{position}/dt, but for {100 * share:.2g} % of it: the log shows its "
        "controller, not the machine; change the reference more often, or add a test signal to the force"
    )


def negative_friction(fit: Fit, plain: Fit) -> str:
    """Sentence if friction as a whole comes out negative, as with a force of the wrong sign; otherwise empty.

    It states the values of the model without effects, `plain`, as no effect is concluded then.
    """
    prediction = fit.state.prediction
    record = prediction.record
    if record.n_drives > 1:
        return ""
    # Mean power that friction takes for a unit of each parameter, and with the values found
    powers = _powers_of_friction(prediction)
    units = np.array([powers.get(name, 0.0) for name in fit.parameters])
    power = float(units @ list(fit.parameters.values()))
    covariance = fit.blocks.covariance[: units.size, : units.size]
    deviation = float(np.sqrt(units @ covariance @ units))
    inside = record.in_log
    driven = prediction.along(prediction.response.plant.drive)  # so that F v is a power
    supplied = (record.fine(record.measured[0]) * driven.v)[inside]
    least = max(_SURELY * deviation, _OF_POWER * float(np.mean(np.abs(supplied))))
    # a model that lacks much may seem to supply energy: then the drive does not absorb it
    if not power < -least or not np.mean(supplied) < 0:
        return ""
    values = plain.parameters if any(plain.parameters[name] < 0 for name in powers) else fit.parameters
    negative = ", ".join(f"{name} {values[name]:.3g}" for name in powers if values[name] < 0)
    return (
        f"{record.forces[0]} takes energy out of the motion, as if friction were negative ({negative}): the sign of "
        f"{record.forces[0]} or of a position is wrong, or something else drives the axis"
    )


def _powers_of_friction(prediction: Prediction) -> dict[str, float]:
    """Mean power that a unit of each unknown coefficient of friction takes out of the motion."""
    inside = prediction.record.in_log
    powers: dict[str, float] = {}
    for law in prediction.axis.laws:
        places = places_of(prediction, law)
        if not places or not isinstance(law, CoulombFriction | ViscousFriction):
            continue
        place, ratio = next(iter(places.items()))
        speed = np.abs(ratio * prediction.joints[place].v[inside])
        own = float(np.mean(speed if isinstance(law, CoulombFriction) else speed**2))
        for term in law.terms():
            powers[term.parameter] = powers.get(term.parameter, 0.0) + own
    return {name: power for name, power in powers.items() if name in prediction.parameters}
