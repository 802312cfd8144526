"""The logs of a diagnosis: how they were recorded, which serve which purpose, and their spectra."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, NamedTuple, TypeAlias

import numpy as np

from symid.arrays import BoolArray
from symid.axis import Axis
from symid.data import Log
from symid.diagnosis.prediction.driven_positions import signals_of
from symid.diagnosis.prediction.joined_logs import JoinedLogs, joined, ways, with_common_zeros
from symid.diagnosis.prediction.record import Record, record_of
from symid.simulation import Cascade, forward_dynamics

Controllers: TypeAlias = Cascade | Sequence[Cascade] | None
"""Controller of the machine, or one for each drive; None if it is not known."""
_PARTS: Final = 12
_FEWER_PARTS: Final = 6
"""Parts of a motion of few rows; the window removes some rows of each part."""
_EVERY: Final = 3
_FEW_ROWS: Final = 100
_MOSTLY_MOVES: Final = 0.5
"""Share of moving time above which the parts divide the time of the log, not the time of motion."""


@dataclass(frozen=True)
class Recording:
    """How signals were recorded: their delays, holds of the force, the controller, and the decimation of the logs."""

    late: Mapping[str, float]  # time by which signals were recorded late, s
    held: bool | None  # whether the force is held from sample to sample; None if it is not known
    controller: Controllers = None
    decimation: int = 1  # recorded samples for each sample of the logs, see `repaired`

    def delays(self, axis: Axis) -> dict[str, float]:
        """Time by which signals of a log were recorded late, s: as given, else as declared; apart from holds."""
        return {sensor.signal: sensor.delay for sensor in axis.sensors if sensor.delay} | dict(self.late)

    def later(
        self, axis: Axis, further: Mapping[str, float], found: Mapping[str, float] | None = None
    ) -> dict[str, float]:
        """Delays of readings that are `further` late beyond those declared, given and `found` before, s."""
        delays = {s.signal: s.delay for s in axis.sensors} | dict(self.late) | dict(found or {})
        return {signal: delays[signal] + time for signal, time in further.items()}

    def with_late(self, delays: Mapping[str, float]) -> Recording:
        """The recording with these delays of signals in place of its own, s."""
        return replace(self, late={**self.late, **delays})

    def holds(self, axis: Axis, sampling_period: float) -> dict[str, float]:
        """Time for which each force that is held from sample to sample is held, s."""
        held = (d.signal for d in axis.drives if (d.held if self.held is None else self.held))
        return dict.fromkeys(held, sampling_period / self.decimation)

    def may_be_held(self, axis: Axis) -> bool:
        """Whether a hold of the forces is neither known nor excluded."""
        return self.held is None and not any(d.held or d.signal in self.late for d in axis.drives)


class LogsByPurpose(NamedTuple):
    """Logs by their purpose."""

    identification: JoinedLogs
    validation: JoinedLogs | None  # None if parts of the former are held out for it

    @property
    def every(self) -> list[Log]:
        """All logs as they were recorded, those for the validation last."""
        return [log for run in self if run is not None for log in run.parts]


def one_run(axis: Axis, logs: Sequence[Log]) -> JoinedLogs:
    """Join logs; where the axis leaves the zeros of encoders open, the logs get a common zero."""
    if axis.log_parameters and len(logs) > 1:
        signals, n_drives = signals_of(forward_dynamics(axis), logs[0]), len(axis.drives)
        orders = {sensor.signal: sensor.derivative for sensor in axis.sensors}
        others = [name for name in signals[n_drives:] if orders[name] == 0]
        logs = with_common_zeros(logs, signals[:n_drives], others)
    return joined(logs, _common_signals(axis, logs))


def logs_by_purpose(axis: Axis, logs: Sequence[Log], n_validation: int | None) -> LogsByPurpose:
    """Divide logs: the last `n_validation` validate, or by default the last of several.

    If only the last log moves in one of the directions, all logs serve both purposes by default. Logs of one direction
    each show neither a dependence on the direction nor a constant force beside friction.
    """
    n = min(1, len(logs) - 1) if n_validation is None else n_validation
    first, last = logs[: len(logs) - n], logs[len(logs) - n :]
    if n_validation is None and n and goes_elsewhere(axis, first, last):
        first, last = logs, []
    return LogsByPurpose(one_run(axis, first), one_run(axis, last) if last else None)


def goes_elsewhere(axis: Axis, logs: Sequence[Log], others: Sequence[Log]) -> bool:
    """Whether a position moves in a direction in `others` in which it does not move in `logs`."""
    orders = {sensor.signal: sensor.derivative for sensor in axis.sensors}
    positions = [name for name in _common_signals(axis, [*logs, *others]) if orders[name] == 0]
    known, new = (
        set[tuple[str, bool]]().union(*(ways(log, positions) for log in each)) for each in (logs, others)
    )
    return not new <= known


def _common_signals(axis: Axis, logs: Sequence[Log]) -> list[str]:
    """Signals of sensors that are in all of some logs."""
    return [s.signal for s in axis.sensors if all(s.signal in log.signals for log in logs)]


@dataclass(frozen=True, eq=False)
class Data:
    """The identification data, and the validation data, on which the gap is measured."""

    # record, validation: of the logs and of the validation logs; the same where there are none
    record: Record
    validation: Record
    # training, held_out: shape (n_fine,): points for either purpose, where these are not all
    training: BoolArray | None
    held_out: BoolArray | None


def data_of(axis: Axis, logs: LogsByPurpose, recording: Recording) -> Data:
    """Spectra of the logs for identification and validation."""
    dynamics = forward_dynamics(axis)
    run, validation = logs

    def spectra_of(log: Log, motion_hz: float | None) -> Record:
        holds = recording.holds(axis, log.sampling_period)
        return record_of(dynamics, log, motion_hz, recording.delays(axis), holds)

    record = spectra_of(run.log, None)
    inside = _within(record, run)
    if validation is None:
        training, held_out = training_and_held_out(record)
        return Data(record, record, training & inside, held_out & inside)
    other = spectra_of(validation.log, record.motion_hz)
    return Data(record, other, inside, _within(other, validation))


def training_and_held_out(record: Record) -> tuple[BoolArray, BoolArray]:
    """Points of the fine grid for identification and for validation: every third of twelve parts is held out.

    The parts divide the time of motion if the axis mostly rests or moves only briefly.
    """
    moving = record.moving
    seconds = float(np.sum(moving) * record.fine_time[1])
    few = 2 * record.band_hz * seconds < _FEW_ROWS
    rests = few or seconds < _MOSTLY_MOVES * record.duration
    gone = np.cumsum(moving) / np.sum(moving) if rests else record.fine_time / record.duration
    part = np.floor(gone * (_FEWER_PARTS if few else _PARTS))
    held_out = np.asarray(part % _EVERY == 1)
    return ~held_out, held_out


def _within(record: Record, run: JoinedLogs) -> BoolArray:
    """Points of the fine grid that belong to a log."""
    at = np.rint(record.fine_time / run.log.sampling_period).astype(int)
    return np.asarray(run.recorded[np.minimum(at, run.recorded.size - 1)])
