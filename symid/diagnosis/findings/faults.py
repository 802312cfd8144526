"""Faults of the recording, which are checked before physical effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symid.arrays import FloatArray
from symid.data import Log
from symid.data.stuck import inspect_spans
from symid.diagnosis.effects import Placed, force_at
from symid.diagnosis.findings.cut_force import cut_force
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted
from symid.diagnosis.fitting.state import first_state
from symid.identification.recording import channel_fault, held_fault

_LOST = 0.05
_REPEATED = 0.4
"""Share of lost and of repeated samples above which a log shows its recorder rather than its machine. Coarse encoders
and slow controllers repeat values by nature; a channel that is updated at every second sample repeats half of them."""
_WHOLE_SAMPLE = 0.15
_OPPOSITE = -0.5
"""Correlation of the measured with the predicted force below which a sign may be wrong."""
_MIRRORED = 0.3
"""Error with the opposite force relative to that with the recorded one, mean squares, below which the sign is wrong."""
_BOTH_SIGNS = 0.2
"""Least share of samples with each sign in a predicted force for a record of one sign to be suspicious."""

_COASTS = 0.1
"""Share of the samples of a motion in which the force is exactly 0: the drive is off, and no sign is lost."""


@dataclass(frozen=True)
class Damage:
    """Faults of a recording."""

    fatal: tuple[str, ...] = ()  # sentences on faults that make the log useless
    noted: tuple[str, ...] = ()  # sentences on minor faults
    silent: bool = False  # whether the log says nothing of the machine, not even that a model is right

    def led_by(self, text: str, *, silent: bool = False) -> Damage:
        """The damage with a further fatal sentence in front, unless it is empty."""
        return replace(self, fatal=(text, *self.fatal), silent=silent or self.silent) if text else self

    @property
    def texts(self) -> tuple[str, ...]:
        """All sentences, fatal ones first."""
        return (*self.fatal, *self.noted)


NO_DAMAGE = Damage()


def damage(logs: Sequence[Log], begun: Fit, found: Fit) -> Damage:
    """Damage of logs by their recorder or by a wrong sign.

    `begun` is the axis with its initial values, `found` the axis fitted to the logs.
    """
    record = begun.state.prediction.record
    names = (*record.forces, *record.signals)
    positions = [name for name in record.signals if record.dynamics.sensors[name][1] == 0]
    faults = [
        _fault_of_channel(log[name], name, is_force=name in record.forces) for log in logs for name in names
    ]
    held = [
        held_fault(log[name], name, log[positions[0]]) for log in logs for name in record.forces if positions
    ]
    notes = [inspect_spans(log.time, {name: log[name] for name in names}, positions) for log in logs]
    signs = [_wrong_sign(begun, found, drive) for drive in range(record.n_drives)]
    cut = [cut_force(found, drive) for drive in range(record.n_drives)]
    fatal = tuple(dict.fromkeys(text for text in (*signs, *faults, *held, *cut) if text))
    return Damage(fatal, tuple(dict.fromkeys(text for note in notes for text in note)))


def _fault_of_channel(x: FloatArray, name: str, *, is_force: bool) -> str:
    """Fault that makes a channel useless, in words; empty if there is none."""
    found = channel_fault(x, name, _LOST, is_force=is_force)
    return channel_fault(x, name, _REPEATED, is_force=is_force) if "repeats" in found else found


def _wrong_sign(begun: Fit, found: Fit, drive: int) -> str:
    """Sentence if the force of a drive is opposite to the predicted one, or is its absolute value; otherwise empty."""
    state, weighting = begun.state, begun.weighting
    record = state.prediction.record
    force = record.forces[drive]
    both = weighting.rows(np.stack([record.measured, state.prediction.outputs]))
    measured, predicted = both[:, drive, weighting.kept]
    opposite = float(np.corrcoef(measured, predicted)[0, 1]) < _OPPOSITE
    if opposite and _fits_mirrored(begun, found, force):
        return f"{force} is opposite to what the motion asks for: its sign or that of a position is wrong"
    logged = record.log[force]
    seen, asked = (
        record.rows(spectrum * record.taper)[weighting.kept]
        for spectrum in (record.measured[drive], state.prediction.outputs[drive])
    )
    sides = min(float(np.mean(asked > 0)), float(np.mean(asked < 0)))
    one_sided = logged.min() >= 0 or logged.max() <= 0
    at = np.rint(record.row_time[weighting.kept] / record.log.sampling_period).astype(int)
    coasts = np.mean(logged[np.minimum(at, logged.size - 1)] == 0.0) > _COASTS
    if sides > _BOTH_SIGNS and one_sided and not coasts and _is_absolute(seen, asked):
        return (
            f"{force} never changes its sign, though the motion asks for both: an absolute value was recorded"
        )
    return ""


def _fits_mirrored(begun: Fit, found: Fit, force: str) -> bool:
    """Whether the axis fits the force of opposite sign far better than the recorded one."""
    record = begun.state.prediction.record
    log = replace(record.log, signals={**record.log.signals, force: -record.log[force]})
    other = replace(record, log=log)
    fit = fitted(*first_state(other, begun.parameters, begun.weighting.allowed))
    return fit.mean_square < _MIRRORED * found.mean_square


def _is_absolute(seen: FloatArray, asked: FloatArray) -> bool:
    """Whether a record follows the absolute value of the predicted force rather than the force, each plus a constant.

    A weight that is not in the model can keep a force on one side, too.
    """

    def left(course: FloatArray) -> float:
        base = np.stack([np.ones(asked.size), course], axis=1)
        return float(np.linalg.norm(seen - base @ np.linalg.lstsq(base, seen)[0]))

    return left(np.abs(asked)) < left(asked)


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
