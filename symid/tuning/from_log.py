"""Tuning on the total error from a log alone: its noise, its reference, and parameters identified from it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from symid.axis import Axis, Spring
from symid.codegen import GeneratedModel
from symid.data import REFERENCE, Log, LowPass
from symid.errors import SettingError
from symid.identification import Preparation, identify
from symid.identification.settings import completed
from symid.simulation import Trajectory, plant_of, tuned_cascade
from symid.tuning.exact_run import ExactRun, exact_run
from symid.tuning.noise import noise_levels
from symid.tuning.total import TotalTuning, tune_total

_LEAST_RATE = 8000.0
"""Rate of the simulated controller at least, Hz."""
_REFERENCE_SHARE = 0.05
"""Cutoff of the low-pass of a measured position that serves as reference, as a share of the sampling frequency."""
_LEAST_FRICTION = 1e-9


def run_of_log(axis: Axis, parameters: Mapping[str, float], log: Log, bandwidth_hz: float = 20.0) -> ExactRun:
    """Simulate an axis without noise along the reference of a log, or along its low-passed position if it has none.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    parameters : mapping of str to float
        Values of its physical parameters, SI.
    log : Log
        Holds ``reference``, or the first position sensor of the axis.
    bandwidth_hz : float
        Bandwidth of the velocity loop that stands for the controller of the log, which is not known.

    Raises
    ------
    SettingError, LogError
        If the axis runs away, or the log holds neither signal.
    """
    plant = plant_of(axis, parameters)
    signal = next((name for name, (_, order) in plant.sensors.items() if order == 0), axis.sensors[0].signal)
    if REFERENCE in log.signals:
        position = log[REFERENCE]
    else:
        low_pass = LowPass(_REFERENCE_SHARE * log.sampling_frequency)
        position = low_pass.apply(log[signal], log.sampling_frequency)
    finer = math.ceil(_LEAST_RATE / log.sampling_frequency)
    period = log.sampling_period / finer
    spline = CubicSpline(log.sampling_period * np.arange(log.n_samples), position - position[0])
    time = period * np.arange((log.n_samples - 1) * finer + 1)
    trajectory = Trajectory(
        spline(time), spline(time, 1), spline(time, 2), period, f"reference of {log.source}", log.start
    )
    return exact_run(axis, parameters, trajectory, tuned_cascade(plant, signal, bandwidth_hz))


def identified_and_tuned(
    axis: Axis,
    model: GeneratedModel,
    log: Log,
    *,
    preparation: Preparation | None = None,
    rounds: int = 2,
    draws: int = 12,
) -> TotalTuning:
    """Tune on the total error with parameters identified from the log itself.

    The parameters come from the automatic settings first, then from the tuned ones.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    model : GeneratedModel
        Its model for the sensors of the log.
    log : Log
        A run of the axis.
    preparation : Preparation, optional
        Settings other than cutoff and decimation.
    rounds : int
        How often parameters are identified and the settings tuned.
    draws : int
        Draws of noise.

    Raises
    ------
    SettingError
        If no cutoff gives parameters that an axis can have.
    """
    base = preparation or Preparation()
    noise = noise_levels(log, model.force, model.measured)
    settings, tuned = base, None
    for _ in range(rounds):
        parameters = plausible_parameters(axis, model, log, settings)
        run = run_of_log(axis, parameters, log)
        tuned = tune_total(
            axis, model, parameters, run, log.sampling_frequency, noise, preparation=base, draws=draws
        )
        settings = tuned.preparation
    assert tuned is not None
    return tuned


def plausible_parameters(
    axis: Axis, model: GeneratedModel, log: Log, settings: Preparation
) -> dict[str, float]:
    """Physical parameters of a log, from the settings or else from nearby cutoffs, none negative that must not be.

    Frictions and dampings that come out negative are taken as small; masses and springs must be positive.
    """
    first = completed(settings, log, model).cutoff_hz
    assert first is not None
    for factor in (1.0, 0.7, 1.4, 0.5, 2.0, 0.3, 3.0):
        cutoff = min(first * factor, 0.4 * log.sampling_frequency)
        found = identify(model, log, preparation=replace(settings, cutoff_hz=cutoff, decimation=None))
        parameters = found.physical_parameters
        if parameters and all(parameters[name] > 0.0 for name in _inertias_and_springs(axis)):
            return {
                name: value if name in model.signed else max(value, _LEAST_FRICTION)
                for name, value in parameters.items()
            }
    raise SettingError(
        f"{log.source}: no cutoff gives positive masses and springs for axis {axis.name!r}: give --parameters"
    )


def _inertias_and_springs(axis: Axis) -> list[str]:
    springs = [element.stiffness for element in axis.elements if isinstance(element, Spring)]
    return [body.mass or body.inertia or "" for body in axis.bodies] + springs
