"""Parameters to begin an iterative estimation with, where no good ones are known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from symid.codegen import GeneratedModel
from symid.data import Log, LowPass, derivatives
from symid.output_error.estimate import natural_frequencies
from symid.simulation import ForwardDynamics

_MODES = (0.01, 0.03, 0.1, 0.3)
"""Frequencies of the highest mode to begin with, as shares of the sampling frequency."""
_LOSS = 0.02


def spread(
    dynamics: ForwardDynamics, known: Mapping[str, float], sampling_frequency: float
) -> list[dict[str, float]]:
    """Known parameters as they are, and with springs that bring the highest mode to several frequencies.

    Parameters
    ----------
    dynamics : ForwardDynamics
        The axis.
    known : mapping of str to float
        Physical parameters, masses and stiffnesses positive.
    sampling_frequency : float
        Of the log, Hz.
    """
    springs = dynamics.parameters_of("stiffness")
    highest = max(natural_frequencies(dynamics, known), default=0.0)
    if not springs or highest == 0.0:
        return [dict(known)]
    scales = [(share * sampling_frequency / highest) ** 2 for share in _MODES]
    return [dict(known), *({**known, **{name: k * known[name] for name in springs}} for k in scales)]


def rigid_start(model: GeneratedModel, dynamics: ForwardDynamics, logs: Sequence[Log]) -> dict[str, float]:
    """Parameters of an axis of which only the rigid motion is known: one mass for each body, and friction.

    Parameters
    ----------
    model : GeneratedModel
        Names of the parameters.
    dynamics : ForwardDynamics
        The axis.
    logs : sequence of Log
        Runs; the first one is looked at.
    """
    log = logs[0]
    signal = next(name for name, (_, order) in dynamics.sensors.items() if order == 0 and name in log.signals)
    lowpass = LowPass(0.02 * log.sampling_frequency)
    force = lowpass.apply(log[dynamics.axis.drive.signal], log.sampling_frequency)
    v, a = derivatives(lowpass.apply(log[signal], log.sampling_frequency), log.sampling_period, 2)
    mass, viscous, coulomb, _ = np.linalg.lstsq(
        np.stack([a, v, np.sign(v), np.ones_like(v)], axis=1), force, rcond=None
    )[0]
    mass = max(abs(float(mass)), 1e-12)
    values = dict.fromkeys(model.physical_units, 0.0)
    masses, springs = dynamics.parameters_of("mass"), dynamics.parameters_of("stiffness")
    stiffness = mass * (2 * np.pi * 0.1 * log.sampling_frequency) ** 2
    for name in values:
        if name in masses:
            values[name] = mass
        elif name in springs:
            values[name] = stiffness
        elif name in dynamics.parameters_of("damping"):
            values[name] = _LOSS * float(np.sqrt(mass * stiffness)) if springs else abs(float(viscous))
    for _, terms in dynamics.laws:
        for term in terms:
            for name in dynamics.names(term.parameter):
                values[name] = abs(float(coulomb))
    return values
