"""Steps of a held force that an accelerometer misses.

A held force jumps at each sample, and so does an acceleration. An accelerometer with the clock of the drive reads the
value just before the jump, that is under the force of the sample before, while motion from positions follows the held
force half a sample late on average. The reading lacks D (F(t - T/2) - F[k-1]), D being the acceleration that a
unit of force makes at once. D depends on the parameters: it is found with them, by iteration. Other simulators record
the value just after the jump, which lacks D (F(t - T/2) - F[k]).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Final

import numpy as np

from symid.arrays import FloatArray
from symid.axis import Axis
from symid.codegen import GeneratedModel
from symid.data import AnyLog, Log
from symid.errors import SettingError
from symid.identification.identify import identify_by_least_squares
from symid.identification.results.identification_result import Identification
from symid.identification.rows.settings import Preparation
from symid.signal_processing import QuinticSpline

Feedthrough = Callable[[Axis, Mapping[str, float]], Mapping[str, FloatArray]]
"""For physical parameters the acceleration that each accelerometer reads at once per unit of each drive's force."""

_MOMENTS: Final = {"before": 1, "after": 0}
"""When a reading may be taken beside a step of the force, and how many samples older the force is that then acts."""
_MOST_ROUNDS: Final = 8  # of identification and completion
_SETTLED: Final = 1e-6  # relative change of the accelerations per force at which the iteration ends
_WHOLE: Final = 1e-9  # of a sample


def identify_with_steps(
    axis: Axis | None,
    model: GeneratedModel,
    logs: Sequence[AnyLog],
    feedthrough: Feedthrough,
    *,
    preparation: Preparation | None = None,
    examine: Any = True,
    **settings: Any,
) -> Identification:
    """Identify logs; what accelerometers miss of the steps of a held force is added to them if that fits better.

    Parameters
    ----------
    axis : Axis, optional
        The declared axis; without it logs are identified as they are.
    model : GeneratedModel
        Its model, whose sensors count.
    logs : sequence of logs
        Runs of the axis; a long log, which is read in blocks, is identified as it is.
    feedthrough : callable
        Acceleration at once per unit force.
    preparation, examine, **settings
        As in `symid.identification.identify`.

    Returns
    -------
    Identification
        A note says which sensors were completed.
    """
    again: Callable[..., Identification] = partial(identify_by_least_squares, model, **settings)
    found = again(logs, preparation=preparation, examine=examine)
    completed, note = logs_with_steps(axis, found, logs, feedthrough, preparation=preparation, **settings)
    if not note:
        return found
    better = again(completed, preparation=preparation, examine=examine)
    return replace(better, notes=(*better.notes, note))


def logs_with_steps(
    axis: Axis | None,
    found: Identification,
    logs: Sequence[AnyLog],
    feedthrough: Feedthrough,
    *,
    preparation: Preparation | None = None,
    **settings: Any,
) -> tuple[Sequence[AnyLog], str]:
    """The logs with the steps that accelerometers miss added, if that fits better, and a note that says so.

    `found` is the identification of the logs as they are; everything else is as in `identify_with_steps`.
    """
    runs = [log for log in logs if isinstance(log, Log)]
    if axis is None or len(runs) < len(logs) or not _misses_steps(axis, found.model, preparation):
        return logs, ""
    known = partial(_known, partial(feedthrough, axis))
    if not known(found):
        return logs, ""
    fixed = found.observations[0].preparation  # the same rows for all that is compared
    again: Callable[..., Identification] = partial(
        identify_by_least_squares, found.model, preparation=fixed, examine=False, **settings
    )
    plain = again(runs)
    likeliest, best, note = _negative_log_likelihood(plain), runs, ""
    for moment, older in _MOMENTS.items():
        trial, last = plain, dict[str, FloatArray]()
        for _ in range(_MOST_ROUNDS):
            at_once = known(trial)
            if not at_once:
                break
            completed = [_completed(log, at_once, found.model.forces, fixed.late, older) for log in runs]
            trial = again(completed)
            if last and all(np.allclose(d, last[name], rtol=_SETTLED) for name, d in at_once.items()):
                break
            last = dict(at_once)
        if at_once and (cost := _negative_log_likelihood(trial)) < likeliest:
            likeliest, best = cost, completed
            note = (
                f"{', '.join(at_once)}: what each step of the held force makes at once was added, as the reading is "
                f"taken just {moment} it"
            )
    return (best, note) if note else (logs, "")


def _misses_steps(axis: Axis, model: GeneratedModel, preparation: Preparation | None) -> bool:
    """Whether a model uses an accelerometer under a held force."""
    is_used = any(sensor.derivative == 2 and sensor.signal in model.measured for sensor in axis.sensors)
    return is_used and (preparation or Preparation()).is_held(model)


def _known(
    feedthrough: Callable[[Mapping[str, float]], Mapping[str, FloatArray]], found: Identification
) -> Mapping[str, FloatArray]:
    """Accelerations per force of the measured accelerometers at the parameters found; none where these are open."""
    values = found.physical_parameters
    if not values or not all(map(math.isfinite, values.values())):
        return {}
    try:
        at_once = feedthrough(values)
    except SettingError:  # no machine has these masses, which the status says
        return {}
    return {name: d for name, d in at_once.items() if name in found.model.measured and np.any(d)}


def _completed(
    log: Log, at_once: Mapping[str, FloatArray], forces: Sequence[str], late: Mapping[str, float], older: int
) -> Log:
    """The log with the missing parts of its accelerations."""
    k = np.arange(log.n_samples)
    signals = dict(log.signals)
    for name, accelerations in at_once.items():
        for force, acceleration in zip(forces, accelerations, strict=True):
            # Lateness of the reading and of the force, in samples; that of the force holds the half one of its hold.
            middle = (late.get(name, 0.0) - late.get(force, 0.0)) / log.sampling_period
            acting = k - older - math.floor(middle - 0.5 + _WHOLE)
            smooth = QuinticSpline(log[force]).earlier(-middle)
            signals[name] = signals[name] + acceleration * (smooth - log[force][np.clip(acting, 0, k[-1])])
    return replace(log, signals=signals)


def _negative_log_likelihood(found: Identification) -> float:
    """Logarithm of the likelihood of all equations, each with its own noise, but for sign and a constant."""
    rows, rms = np.array(found.fit.rows), found.fit.residual_norm / np.sqrt(found.fit.rows)
    return float(rows @ np.log(rms))
