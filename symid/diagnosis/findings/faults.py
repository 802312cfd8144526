"""Faults of the recording, which are examined before physical effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import FloatArray
from symid.data import Log
from symid.data.quality import dropped, inspect_spans, is_switched
from symid.diagnosis.effects import Placed, force_at
from symid.diagnosis.findings.fit_faults import cut_force
from symid.diagnosis.findings.force_sign import wrong_sign
from symid.diagnosis.fitting.fit import Fit
from symid.identification.faults import channel_fault, held_fault, uneven_averaging

_LOST = 0.05
_REPEATED = 0.4
"""Share of lost and of repeated samples above which a log shows its recorder rather than its machine. Coarse encoders
and slow controllers repeat values by nature; a channel that is updated at every second sample repeats half of them."""
_WHOLE_SAMPLE = 0.15
_AVERAGED = 0.1
"""Loss at the end of the motion band by a mean of one signal and not of the others, above which effects are images of
it: a tenth rounds off reversals of friction as presliding does."""


@dataclass(frozen=True)
class RecordingFaults:
    """Faults of a recording, in sentences."""

    fatal: tuple[str, ...] = ()  # from which no effect can be concluded
    noted: tuple[str, ...] = ()  # minor ones
    uninformative: bool = False  # whether the log does not even show that a model is right

    def led_by(self, text: str, *, uninformative: bool = False) -> RecordingFaults:
        """The faults with a further fatal one first, unless the sentence is empty."""
        if not text:
            return self
        uninformative = uninformative or self.uninformative
        return replace(self, fatal=(text, *self.fatal), uninformative=uninformative)

    @property
    def texts(self) -> tuple[str, ...]:
        """All sentences, fatal ones first."""
        return (*self.fatal, *self.noted)


NO_FAULTS = RecordingFaults()


def recording_faults(logs: Sequence[Log], initial: Fit, reidentified: Fit, last: Fit) -> RecordingFaults:
    """Faults of logs by their recorder or by a wrong sign, from the axis at three stages; `last` has all effects."""
    record = initial.state.prediction.record
    names = (*record.forces, *record.signals)
    positions = [name for name in record.signals if record.dynamics.sensors[name][1] == 0]
    faults = [
        _fault_of_channel(log[name], name, is_force=name in record.forces) for log in logs for name in names
    ]
    held = [
        held_fault(log[name], name, log[positions[0]]) for log in logs for name in record.forces if positions
    ]
    notes = [inspect_spans(log.time, {name: log[name] for name in names}, positions) for log in logs]
    cycles = record.motion_hz * record.log.sampling_period
    means = [
        uneven_averaging({name: log[name] for name in names}, cycles, "end of the motion", _AVERAGED)
        for log in logs
    ]
    signs = [wrong_sign(initial, reidentified, last, drive) for drive in range(record.n_drives)]
    cut = [cut_force(reidentified, drive) for drive in range(record.n_drives)]
    fatal = tuple(dict.fromkeys(text for text in (*signs, *faults, *held, *means, *cut) if text))
    # Samples filled with 0 scale the force, and all values with it: the gap is then not one of the model.
    forces = [log[name] for log in logs for name in record.forces]
    uninformative = any(np.mean(dropped(x)) >= _LOST for x in forces if not is_switched(x))
    return RecordingFaults(
        fatal, tuple(dict.fromkeys(text for note in notes for text in note)), uninformative
    )


def _fault_of_channel(x: FloatArray, name: str, *, is_force: bool) -> str:
    """Sentence on the fault of a channel; empty if there is none."""
    found = channel_fault(x, name, _LOST, is_force=is_force)
    return channel_fault(x, name, _REPEATED, is_force=is_force) if "repeats" in found else found


def shifted_channels(log: Log, forces: Sequence[str], effects: Sequence[Placed]) -> tuple[str, ...]:
    """Sentences on delays that were found, which may be shifts of channels, and on filters of a recorded force."""
    found = []
    for item in effects:
        if item.effect.name == "delay":
            samples = item.shape[0] / log.sampling_period
            whole = abs(samples - round(samples)) < _WHOLE_SAMPLE and round(samples) != 0
            force = force_at(forces, item.at)
            side = "after" if samples > 0 else "before"
            text = f"{force} acts {abs(samples):.2f} samples {side} its record"
            found.append(text + (": a whole number, so channels may be shifted." if whole else "."))
        if item.effect.name == "actuator_lag" and item.shape:
            force = force_at(forces, item.at)
            found.append(
                f"{force} is recorded through a first-order filter of {-1e3 * item.shape[0]:.3g} ms."
            )
    return tuple(found)
