"""Tuning on the total error from a log alone: its noise, its motion, and parameters identified from it."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import scipy

from symid.axis import Axis, Spring
from symid.codegen import GeneratedModel
from symid.data import Log
from symid.errors import SettingError
from symid.identification import Preparation, identify_by_least_squares
from symid.identification.rows import coherent_band, completed, noise_deviations
from symid.signal_processing import LowPass
from symid.simulation import Replay, Trajectory, plant_of, tuned_cascades
from symid.tuning.bound import Track
from symid.tuning.exact_run import ExactRun, exact_run
from symid.tuning.total import TotalTuning, tune_total

_LEAST_RATE = 8000.0
"""Lowest rate of the simulated controller, Hz."""
_BEYOND_COHERENCE = 1.5  # times the band in which force and motion are coherent
_HIGHEST_SHARE = 0.4  # of the sampling frequency
_LEAST_FRICTION = 1e-9  # SI: a negative estimate cannot be simulated
_BANDWIDTHS = (10.0, 20.0, 40.0)  # Hz, of cascades that keep the axis to the log
_DRAWS = (3, 12)  # of the noise in each round


def run_of_log(
    axis: Axis,
    model: GeneratedModel,
    parameters: Mapping[str, float],
    log: Log,
    late: Mapping[str, float] | None = None,
    bandwidth_hz: float = 20.0,
) -> ExactRun:
    """Simulate an axis without noise so that it moves as in a log.

    The log holds force and controlled position of each drive. The recorded forces drive it, and a slow cascade for each
    drive keeps it to the recorded position. Nothing need be known of the controller of the log, and the motion is
    excited at the frequencies at which it was. All signals are low-passed at 1.5 times the band in which they are
    coherent, so that their noise does not move the axis. `late` is as in `Preparation`; SettingError if the simulated
    axis is unstable.
    """
    rate = log.sampling_frequency
    low_pass = LowPass(min(_BEYOND_COHERENCE * coherent_band(log, model), _HIGHEST_SHARE * rate))
    finer = math.ceil(_LEAST_RATE / rate)
    period, samples = log.sampling_period / finer, log.sampling_period * np.arange(log.n_samples)
    time = period * np.arange((log.n_samples - 1) * finer + 1)
    delays = late or {}
    references, controllers = [], []
    for drive, cascade in zip(
        axis.drives,
        tuned_cascades(plant_of(axis, parameters), axis.controlled_signals, bandwidth_hz),
        strict=True,
    ):
        position, force = (
            scipy.interpolate.CubicSpline(samples, low_pass.apply(log[name], rate))
            for name in (cascade.signal, drive.signal)
        )
        at = time + delays.get(cascade.signal, 0.0)
        moved = position(at) - position(at[0])
        references.append(Trajectory(moved, position(at, 1), position(at, 2), period, log.source, log.start))
        # A force that is held acts as at the middle of its hold.
        controllers.append(Replay(force(time + delays.get(drive.signal, 0.0) + 0.5 * period), cascade))
    return exact_run(axis, parameters, references, controllers)


def identified_and_tuned(
    axis: Axis,
    model: GeneratedModel,
    log: Log,
    *,
    nominal: Mapping[str, float] | None = None,
    noise: Mapping[str, float] | None = None,
    preparation: Preparation | None = None,
    track: Track = iter,
) -> TotalTuning:
    """Tune on the total error with parameters identified from the log itself.

    The parameters come from the automatic settings first, then from the tuned ones: a setting that is best for
    parameters 15 % off can be far from the best of the machine.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    model : GeneratedModel
        Its model for the sensors of the log.
    log : Log
        A run of the axis.
    nominal : mapping of str to float, optional
        A priori values, SI: they choose among several solutions, and replace values that the log does not identify.
    noise : mapping of str to float, optional
        Standard deviation of the noise of signals where it is known, SI; of the others it is read from the log.
    preparation : Preparation, optional
        Settings other than cutoff and decimation.
    track : callable, optional
        Is given the cutoffs of each round and passes them on, to show progress.

    Raises
    ------
    SettingError
        If no cutoff gives parameters that an axis can have and no nominal values are given.
    """
    base = preparation or Preparation()
    levels = {**noise_deviations(model, log), **(noise or {})}
    settings, tuned = base, None
    late = base.with_hold(model, log.sampling_period)
    for draws in _DRAWS:
        parameters = plausible_parameters(axis, model, log, settings, nominal)
        runs = [run_of_log(axis, model, parameters, log, late, bandwidth) for bandwidth in _BANDWIDTHS]
        tuned = tune_total(
            axis,
            model,
            parameters,
            runs,
            log.sampling_frequency,
            levels,
            preparation=base,
            draws=draws,
            track=track,
        )
        settings = tuned.preparation
    assert tuned is not None
    return tuned


def plausible_parameters(
    axis: Axis,
    model: GeneratedModel,
    log: Log,
    settings: Preparation,
    nominal: Mapping[str, float] | None = None,
) -> dict[str, float]:
    """Physical parameters of a log, from the settings or else from nearby cutoffs, none negative that must not be.

    Masses and springs must be positive. Of what the log does not determine, as its deviation exceeds its value, the
    nominal value is taken, or a small one for a negative friction. Where no cutoff gives positive masses and springs,
    all values are nominal.
    """
    springs = [element.named("stiffness") for element in axis.elements if isinstance(element, Spring)]
    inertias = [body.inertial for body in axis.bodies]
    positive = [name for name in (*inertias, *springs) if name in axis.physical_parameters]
    first = completed(settings, log, model).cutoff_hz
    assert first is not None
    # A cutoff that admits noise, or removes a resonance, makes masses and springs negative: nearby ones are tried.
    for factor in (1.0, 0.7, 1.4, 0.5, 2.0, 0.3, 3.0):
        cutoff = min(first * factor, 0.4 * log.sampling_frequency)
        decimation = settings.decimation if factor == 1.0 else None
        chosen = replace(settings, cutoff_hz=cutoff, decimation=decimation)
        found = identify_by_least_squares(model, log, preparation=chosen, nominal=nominal)
        parameters = found.physical_parameters
        if parameters and all(parameters[name] > 0.0 for name in positive):
            deviations = dict(zip(parameters, found.physical_deviations, strict=True))
            vague = [
                name
                for name in parameters
                if name not in model.signed and not deviations[name] < parameters[name]
            ]
            known = {name: nominal[name] for name in vague if nominal and name in nominal}
            return {
                name: value if name in model.signed else max(value, _LEAST_FRICTION)
                for name, value in (parameters | known).items()
            }
    if nominal:
        return dict(nominal)
    raise SettingError(
        f"{log.source}: no cutoff gives positive masses and springs for axis {axis.name!r}: "
        "give nominal values of its parameters"
    )
