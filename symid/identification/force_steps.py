"""Steps of a held force that an accelerometer misses.

A held force jumps at each sample, and so does an acceleration. An accelerometer with the clock of the drive reads the
value just before the jump, that is under the force of the sample before, while motion from positions follows the held
force half a sample late on average. What the reading lacks is D (F(t - T/2) - F[k-1]), D being the acceleration that a
unit of force makes at once. D depends on the parameters: it is found with them, by iteration.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, Protocol

import numpy as np

from symid.arrays import FloatArray
from symid.axis import Axis
from symid.codegen import GeneratedModel
from symid.data import AnyLog, Log
from symid.data.resampling import QuinticSpline
from symid.errors import SettingError
from symid.identification.identification_result import Identification
from symid.identification.settings import Preparation

Feedthrough = Callable[[Mapping[str, float]], Mapping[str, FloatArray]]
"""For physical parameters the acceleration that each accelerometer reads at once per unit of each drive's force."""

_MOST_ROUNDS: Final = 8  # of identification and completion
_SETTLED: Final = 1e-6  # relative change of the accelerations per force at which the iteration ends
_WHOLE: Final = 1e-9  # of a sample


class Identify(Protocol):
    """`symid.identification.identify` of one model, with all its settings but these."""

    def __call__(
        self, logs: Sequence[AnyLog], *, preparation: Preparation | None, examine: Any
    ) -> Identification:
        """The identification of some logs."""


def misses_steps(axis: Axis, model: GeneratedModel, preparation: Preparation | None) -> bool:
    """Whether a model uses an accelerometer under a held force.

    Parameters
    ----------
    axis : Axis
        The declared axis.
    model : GeneratedModel
        Its model, whose sensors count.
    preparation : Preparation, optional
        Settings that may state the hold; that of the model by default.
    """
    held = (preparation or Preparation()).held
    is_used = any(sensor.derivative == 2 and sensor.signal in model.measured for sensor in axis.sensors)
    return is_used and (model.held if held is None else held)


def with_force_steps(
    logs: Sequence[AnyLog],
    identify: Identify,
    feedthrough: Feedthrough,
    *,
    preparation: Preparation | None = None,
    examine: Any = True,
) -> Identification:
    """Identify logs of accelerometers under a held force; what they miss of its steps is added if that fits better.

    Parameters
    ----------
    logs : sequence of logs
        Runs of the axis; a long log, which is read in blocks, is identified as it is.
    identify : callable
        Identifies logs by one model.
    feedthrough : callable
        Acceleration at once per unit force.
    preparation, examine
        As in `symid.identify`.

    Returns
    -------
    Identification
        A note says which sensors were completed.
    """
    found = identify(logs, preparation=preparation, examine=examine)
    runs = [log for log in logs if isinstance(log, Log)]
    if len(runs) < len(logs) or not _known(found, feedthrough):
        return found
    fixed = found.observations[0].preparation  # the same rows for all that is compared
    plain = trial = identify(runs, preparation=fixed, examine=False)
    completed, last = runs, dict[str, FloatArray]()
    for _ in range(_MOST_ROUNDS):
        at_once = _known(trial, feedthrough)
        if not at_once:
            return found
        completed = [_completed(log, at_once, found.model.forces, fixed.late) for log in runs]
        trial = identify(completed, preparation=fixed, examine=False)
        if last and all(np.allclose(d, last[name], rtol=_SETTLED) for name, d in at_once.items()):
            break
        last = dict(at_once)
    if not _negative_log_likelihood(trial) < _negative_log_likelihood(plain):
        return found
    better = identify(completed, preparation=preparation, examine=examine)
    note = (
        f"{', '.join(last)}: what each step of the held force makes at once was added, as the reading is taken just "
        "before it"
    )
    return replace(better, notes=(*better.notes, note))


def _known(found: Identification, feedthrough: Feedthrough) -> Mapping[str, FloatArray]:
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
    log: Log, at_once: Mapping[str, FloatArray], forces: Sequence[str], late: Mapping[str, float]
) -> Log:
    """The log with the missing parts of its accelerations."""
    k = np.arange(log.n_samples)
    signals = dict(log.signals)
    for name, accelerations in at_once.items():
        for force, acceleration in zip(forces, accelerations, strict=True):
            # Lateness of the reading and of the force, in samples; that of the force holds the half one of its hold.
            middle = (late.get(name, 0.0) - late.get(force, 0.0)) / log.sampling_period
            acting = k - 1 - math.floor(middle - 0.5 + _WHOLE)
            smooth = QuinticSpline(log[force]).earlier(-middle)
            signals[name] = signals[name] + acceleration * (smooth - log[force][np.clip(acting, 0, k[-1])])
    return replace(log, signals=signals)


def _negative_log_likelihood(found: Identification) -> float:
    """Logarithm of the likelihood of all equations, each with its own noise, but for sign and a constant."""
    rows, rms = np.array(found.fit.rows), found.fit.residual_norm / np.sqrt(found.fit.rows)
    return float(rows @ np.log(rms))
