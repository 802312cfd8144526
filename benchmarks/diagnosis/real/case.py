"""A case: a model that lacks something, logs of the machine, and what is known of it."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass, field

import symid
from symid import Axis, Log
from symid.diagnosis import Diagnosis, diagnose

from .recordings import Recording

Values = dict[str, float]
Key = tuple[str, str]
"""Name and place of an effect."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """A diagnosis of a real log.

    Parameters
    ----------
    name : str
        Short name for the command line.
    model : str
        What the model holds.
    published : str
        What is known of the machine, and where from.
    right : tuple of (str, str)
        Effects and places of which one must come first; none where "unexplained" is the honest answer.
    tied : tuple of (str, str)
        Those that the logs cannot tell from these, which count if the answer names a right one beside them.
    axis : Axis
        The model.
    logs : tuple of Log
        For identification.
    validation : Log
        For the gap.
    nominal : mapping of str to float
        Values of the simulation.
    """

    name: str
    model: str
    published: str
    axis: Axis
    logs: tuple[Log, ...]
    validation: Log
    nominal: Mapping[str, float]
    right: tuple[Key, ...] = ()
    tied: tuple[Key, ...] = field(default=())

    def found(self) -> Diagnosis:
        """The diagnosis."""
        logs = self.logs if _TAKES_SEVERAL else self.logs[0]
        return diagnose(self.axis, logs, validation=self.validation, nominal=self.nominal)  # type: ignore[arg-type]


_TAKES_SEVERAL = "logs" in inspect.signature(diagnose).parameters


def log_of(recording: Recording, *names: str) -> Log:
    """Log of some signals of a recording, or of all."""
    signals = {name: recording[name] for name in names or recording.signals}
    return Log.from_arrays(
        signals, sampling_period=recording.period, start=recording.start, source=recording.source
    )


def identified(axis: Axis, log: Log, *measured: str) -> Values:
    """Values of a model by weighted least squares on the log: a simulation as well adjusted as its structure allows."""
    return symid.identify(symid.derive(axis, measured or None), log, examine=False).physical_parameters
