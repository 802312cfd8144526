"""The diagnosis from a log to its verdict: the table of contents of this room."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from threadpoolctl import threadpool_limits

from symid.arrays import BoolArray
from symid.axis import Axis
from symid.data import Log
from symid.diagnosis.comparison import compared
from symid.diagnosis.conclusion import concluded
from symid.diagnosis.effects import LIBRARY, Effect
from symid.diagnosis.fit import Fit, unfitted
from symid.diagnosis.record import Record, record_of
from symid.diagnosis.rejudging import judged_together
from symid.diagnosis.result import Diagnosis
from symid.diagnosis.search import Turn, search
from symid.diagnosis.start import NOISE_ALONE, fitted_axis, starting_parameters
from symid.diagnosis.state import first_state
from symid.identification.settings import with_hold
from symid.simulation.forward_dynamics import forward_dynamics

_HELD_OUT = 3
_BLOCKS = 12
Recorded: TypeAlias = tuple[Mapping[str, float] | None, bool | None]
"""How signals were recorded: what `diagnose` takes as `late` and as `held`."""
_ONLY_IN_VALIDATION = (
    "The model fits the log: the effect shows in the validation log alone. It was identified from two thirds of that, "
    "and the gap measured on the rest."
)


def diagnose(
    axis: Axis,
    log: Log,
    *,
    validation: Log | None = None,
    nominal: Mapping[str, float] | None = None,
    late: Mapping[str, float] | None = None,
    held: bool | None = None,
    library: Sequence[Effect] = LIBRARY,
) -> Diagnosis:
    """Why simulation and machine differ.

    Parameters
    ----------
    axis : Axis
        The declared axis: the simulation.
    log : Log
        A log of the machine, from which everything is identified.
    validation : Log, optional
        Another log, on which the gap is measured; every third part of `log` by default, which then takes no part in
        the identification.
    nominal : mapping of str to float, optional
        Parameter values of the simulation, SI.
    late : mapping of str to float, optional
        Time by which signals were recorded late, s; negative for a force that acts later than recorded.
    held : bool, optional
        Whether the force is held from sample to sample, so that it acts half a sample later than it is recorded; as
        the axis declares it if not given.
    library : sequence of Effect
        Effects that are considered.

    Raises
    ------
    LogError
        If a log is too short or holds no position.
    SettingError
        If there are no nominal values and none can be identified to begin with.

    Examples
    --------
    >>> from symid.axis import OffsetForce, load_axis
    >>> from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade
    >>> axis, values = load_axis("rigid_1m"), {"M": 100.0, "Fv": 120.0, "Fs": 30.0}
    >>> noisy = axis.with_signal("q", noise=1e-7).with_signal("F", noise=1.0)
    >>> hung, pulled = noisy.with_effect(OffsetForce(axis.bodies[0], "F0")), values | {"F0": 20.0}
    >>> reference = trapezoids(0.1, [0.1, 0.2, 0.3], acceleration=3.0, jerk=60.0, dwell=0.1, sampling_period=1e-3)
    >>> log = simulate(hung, pulled, reference, tuned_cascade(plant_of(axis, values), "q")).log
    >>> found = diagnose(axis, log, nominal=values, held=True)
    >>> found.verdict, found.effects[0].effect
    ('effect', 'offset_force')
    """
    with threadpool_limits(1):  # matrices are small: threads of the linear algebra would wait for each other
        return _either_way(axis, (log, validation), nominal, (late, held), library)


def _either_way(
    axis: Axis,
    logs: tuple[Log, Log | None],
    nominal: Mapping[str, float] | None,
    recorded: Recorded,
    library: Sequence[Effect],
) -> Diagnosis:
    """Identified from the log, or from the validation log where that alone shows the effect."""
    log, validation = logs
    found = _diagnosed(axis, logs, nominal, recorded, library)
    if validation is None or found.verdict != "unexplained" or not _fits_its_log(found):
        return found
    other = _diagnosed(axis, (validation, None), nominal, recorded, library)
    if other.verdict not in ("effect", "partly"):
        return found
    return replace(other, assumptions=(_ONLY_IN_VALIDATION, *other.assumptions))


def _fits_its_log(found: Diagnosis) -> bool:
    """Whether the re-identified model leaves no more than noise of the log that it was identified from."""
    return bool(found.search) and found.search[0].before.mean_square < NOISE_ALONE


def _diagnosed(
    axis: Axis,
    logs: tuple[Log, Log | None],
    nominal: Mapping[str, float] | None,
    recorded: Recorded,
    library: Sequence[Effect],
) -> Diagnosis:
    data = data_of(axis, *logs, recorded)
    start = dict(nominal) if nominal else starting_parameters(axis, data.record)
    state, weighting = first_state(data.record, start, data.training)
    base = fitted_axis(state, weighting)
    before = unfitted(state, weighting) if len(data.record.dynamics.bodies) > 1 else None
    turns = judged_together(search(base, library, before))
    fits = fits_of(base, turns)
    comparison = compared(data.validation, state if nominal else None, fits, data.held_out)
    return concluded(comparison, turns, fits, nominal, logs)


def fits_of(base: Fit, turns: Sequence[Turn]) -> list[Fit]:
    """The re-identified model, and those with effects accepted one by one."""
    return [base, *(turn.confirmed[0].fit for turn in turns if turn.accepts)]


@dataclass(frozen=True, eq=False)
class Data:
    """What is identified from, and what the gap is measured on.

    Parameters
    ----------
    record, validation : Record
        Of the log and of the validation log; the same where there is none.
    training, held_out : bool array of shape (n_fine,) or None
        Parts of the log for either purpose, where one log serves both.
    """

    record: Record
    validation: Record
    training: BoolArray | None
    held_out: BoolArray | None


def data_of(axis: Axis, log: Log, validation: Log | None, recorded: Recorded = (None, None)) -> Data:
    """Logs in the frequency domain, see `diagnose`."""
    dynamics = forward_dynamics(axis)
    record = record_of(dynamics, log, None, late_in(axis, log, recorded))
    if validation is None:
        return Data(record, record, *_parts(record))
    other = record_of(dynamics, validation, record.motion_hz, late_in(axis, validation, recorded))
    return Data(record, other, None, None)


def late_in(axis: Axis, log: Log, recorded: Recorded) -> dict[str, float]:
    """Time by which signals of a log were recorded late, a hold of the force included."""
    late, held = recorded
    held = axis.drive.held if held is None else held
    return with_hold(late or {}, axis.drive.signal, held=held, sampling_period=log.sampling_period)


def _parts(record: Record) -> tuple[BoolArray, BoolArray]:
    """Points of the fine grid for identification and for validation: every third of twelve parts is held out."""
    part = np.floor(record.fine_time / record.duration * _BLOCKS)
    held_out = np.asarray(part % _HELD_OUT == 1)
    return ~held_out, held_out
