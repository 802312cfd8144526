"""A case: an incomplete model, logs of the machine, and published facts about it."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import symid
from symid import Axis, Log
from symid.diagnosis import Diagnosis, diagnose

from .plain import Plain, Script, plain
from .recordings import Recording

Values = dict[str, float]
Key = tuple[str, str]
"""Name and place of an effect."""


@dataclass(frozen=True, kw_only=True)
class Case:
    name: str  # short name for the command line
    model: str  # what the model holds
    published: str  # what is known of the machine, and where from
    # published effects with their places, one of which must come first; empty where nothing is published
    right: tuple[Key, ...] = ()
    # effects that are not published but that a plain script confirms on the held-out log
    confirmed: tuple[Key, ...] = ()
    axis: Axis  # the model
    training: tuple[Recording, ...]  # for identification
    held_out: Recording  # for the gap
    nominal: Mapping[str, float] | None = (
        None  # values of the simulation; those of the first log if not given
    )
    script: Script  # what the plain script fits
    band_hz: float  # band in which the logs show the effect, for the plain script alone

    def __post_init__(self) -> None:
        if self.nominal is None:
            object.__setattr__(self, "nominal", identified(self.axis, self.training[0]))

    @cached_property
    def logs(self) -> tuple[Log, ...]:
        """For identification, with the signals of the axis."""
        return tuple(log_of(self.axis, run) for run in self.training)

    @cached_property
    def validation(self) -> Log:
        """For the gap."""
        return log_of(self.axis, self.held_out)

    def found(self) -> Diagnosis:
        return diagnose(self.axis, self.logs, validation=self.validation, nominal=self.nominal)

    def plain(self, band_hz: float | None = None) -> Plain:
        """Result of the plain script on the same logs, in the band of the case or another one."""
        return plain(self.script, self.training, self.held_out, band_hz or self.band_hz)


def log_of(axis: Axis, recording: Recording) -> Log:
    """Log of those signals of a recording that an axis declares."""
    names = (axis.drive.signal, *(sensor.signal for sensor in axis.sensors))
    signals = {name: recording[name] for name in names}
    return Log.from_arrays(
        signals, sampling_period=recording.period, start=recording.start, source=recording.source
    )


def identified(axis: Axis, recording: Recording) -> Values:
    """Values of a model by weighted least squares on a log: a simulation as well adjusted as its structure allows."""
    log = log_of(axis, recording)
    measured = tuple(sensor.signal for sensor in axis.sensors)
    return symid.identify(symid.derive(axis, measured), log, examine=False).physical_parameters
