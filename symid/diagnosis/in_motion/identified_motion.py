"""An identified axis simulated along a log: its positions beside the measured ones."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from symid.axis import ActuatorDelay, Axis
from symid.data import Log
from symid.diagnosis.findings.gap import SimulatedMotion
from symid.diagnosis.in_motion.declared import ExplainedAxis, impossible_values
from symid.diagnosis.in_motion.motion import errors_of_axis, motion_next_to
from symid.diagnosis.in_motion.replayed import Part, driver_of
from symid.diagnosis.prediction.driven_positions import signals_of
from symid.diagnosis.prediction.record import record_of
from symid.diagnosis.prediction.response import axis_response
from symid.errors import SymidError
from symid.simulation import forward_dynamics, without_noise

_MOST_SAMPLES = 200_000  # that are simulated


@dataclass(frozen=True)
class IdentifiedMotion:
    """Simulated motion of an identified axis along a log."""

    log: str  # its source
    # at the position next to each drive; none where the axis could not be simulated
    motions: tuple[SimulatedMotion, ...] = ()
    message: str = ""  # reason of a failure, or the part of the log that was simulated


def identified_motion(
    axis: Axis, values: Mapping[str, float], log: Log, late: Mapping[str, float] | None = None
) -> IdentifiedMotion:
    """Simulate an identified axis from the measured force, under the controller that the log shows or an observer.

    `values` are empty if the log determines none. Of a long log the beginning is simulated. `late` are the times by
    which signals were recorded late, s, declared delays included. The message states a failure.
    """
    if not values:
        return IdentifiedMotion(log.source, message="the log determines no physical parameters")
    values = axis.with_known_values(values)
    if unreal := impossible_values(axis, dict(values)):
        return IdentifiedMotion(log.source, message="; ".join(unreal))
    if not any(sensor.derivative == 0 and sensor.signal in log.signals for sensor in axis.sensors):
        return IdentifiedMotion(log.source, message="none of its signals is a position")
    run = log if log.n_samples <= _MOST_SAMPLES else log.window(0, _MOST_SAMPLES)
    try:
        with np.errstate(all="ignore"):
            motions = _motions(axis, values, run, dict(late or {}))
    except (SymidError, np.linalg.LinAlgError, ArithmeticError, ValueError) as error:
        return IdentifiedMotion(log.source, message=str(error))
    failed = "; ".join(dict.fromkeys(m.explained.message for m in motions if m.explained.status == "failed"))
    if failed:
        return IdentifiedMotion(log.source, message=failed)
    part = f"the first {run.n_samples} samples" if run is not log else ""
    return IdentifiedMotion(log.source, motions, part)


def _motions(
    axis: Axis, values: Mapping[str, float], log: Log, late: dict[str, float]
) -> tuple[SimulatedMotion, ...]:
    """Motion next to each drive."""
    axis = _on_time(axis)
    dynamics = forward_dynamics(axis)
    # Each drive is simulated in the time of the position beside it: only how late one is against the other counts.
    pairs = zip(axis.drives, signals_of(dynamics, log), strict=False)
    forces = {drive.signal: late.get(drive.signal, 0.0) - late.get(name, 0.0) for drive, name in pairs}
    record = record_of(dynamics, log, None, forces)
    whole = np.ones(log.n_samples, dtype=bool)
    parts = [Part(log, whole, record, drive) for drive in range(record.n_drives)]
    inertia = axis_response(record, values).inertia
    drivers = [driver_of(record, [part], None, inertia) for part in parts]
    simulated = ExplainedAxis(axis, dict(values), ())
    errors = errors_of_axis(lambda: simulated, [parts], drivers)
    return tuple(
        motion_next_to(driver, [part], [None, error])
        for driver, part, error in zip(drivers, parts, errors, strict=True)
    )


def _on_time(axis: Axis) -> Axis:
    """The axis without noise, and without the delays that are taken off its signals."""
    axis = without_noise(axis.without(*(one for one in axis.imperfections if isinstance(one, ActuatorDelay))))
    return replace(axis, sensors=tuple(replace(sensor, delay=0.0) for sensor in axis.sensors))
