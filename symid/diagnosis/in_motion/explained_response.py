"""The frequency response of a diagnosed axis with the effects found."""

from __future__ import annotations

import numpy as np

from symid.arrays import ComplexArray
from symid.diagnosis.findings.diagnosis_result import Diagnosis
from symid.diagnosis.in_motion.declared import explained_axis
from symid.errors import SettingError
from symid.simulation.frequency_response import FrequencyResponse, has_response, identified_response


def explained_response(found: Diagnosis, of: FrequencyResponse) -> ComplexArray | None:
    """Response with the linear effects among those found; None if it cannot be computed."""
    try:
        with_effects = explained_axis(found)
        axis, values = with_effects.axis, with_effects.values
    except SettingError:  # no effect is an element of the axis
        axis, values = found.axis, {change.name: change.explained for change in found.parameters}
    if not has_response(axis, values):
        return None
    drive = np.ones(of.frequency.size, dtype=complex)
    for effect in found.effects:
        if effect.effect in ("delay", "actuator_lag"):
            turned = 2j * np.pi * of.frequency * effect.parameters["T"].value
            if effect.effect == "delay":
                drive *= np.exp(-turned)
            else:  # a negative time means that the record lags, not the force
                drive *= 1 / (1 + turned) if effect.parameters["T"].value > 0 else 1 - turned
    return np.asarray(drive * identified_response(axis, values, of.signal, of.frequency, of.order))
