"""Detection of logs that show the controller instead of the machine.

While the reference stands still, the force of a controller depends on position and speed only: u = c - Kp q - Kd v. A
model with friction and a spring of opposite sign has the same form and explains the log without error, whatever the
machine is. Such a model feeds energy into the motion, which no machine does.
"""

from __future__ import annotations

import numpy as np

from symid.diagnosis.fitting.fit import Fit

_AS_GOOD = 1.2
"""Largest error of the feedback law, relative to that of the model, at which the model may be this law."""


def feedback_law(fit: Fit) -> str:
    """Sentence if a log shows its controller, that is, if the fitted model is a feedback law; otherwise empty."""
    record = fit.state.prediction.record
    if record.n_drives > 1 or not _has_negative_damping(fit):
        return ""
    motion, constant = record.motions[0], np.zeros(record.n_bins, dtype=complex)
    constant[0] = record.n_extended
    spectra = np.zeros((4, *record.measured.shape), dtype=complex)
    spectra[:, 0] = constant, motion, 1j * record.omega * motion, record.measured[0]
    rows = np.concatenate([fit.weighting.rows(spectra), fit.state.rows[None]])
    known = fit.weighting.known(rows, fit.state.beginning).reshape(len(rows), len(record.measured), -1)
    *law, force, error = known[:, 0]
    gains = np.linalg.lstsq(np.transpose(law), force)[0]
    left = float(np.linalg.norm(force - gains @ law))
    if not (gains[1] < 0 and gains[2] < 0 and left < _AS_GOOD * float(np.linalg.norm(error))):
        return ""
    share = left / float(np.linalg.norm(force))
    name, position = record.forces[0], record.driven[0]
    return (
        f"{name} follows from {position} and its speed alone, {gains[0]:.3g} - {-gains[1]:.3g} {position} - "
        f"{-gains[2]:.3g} d{position}/dt, but for {100 * share:.2g} % of it: the log shows its "
        "controller, not the machine; change the reference more often, or add a test signal to the force"
    )


def _has_negative_damping(fit: Fit) -> bool:
    """Whether a damping of the model is negative."""
    dampings = fit.state.prediction.record.dynamics.parameters_of("damping")
    return any(fit.parameters[name] < 0 for name in dampings)
