"""`diagnose` of any axis from any log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from symid.axis import AnyAxis, axis_of
from symid.diagnosis import LIBRARY, Diagnosis, Effect
from symid.diagnosis import diagnose as diagnose_axis
from symid.simulation import Cascade
from symid.verbs.logs import Recorded, logs_of


def diagnose(
    axis: AnyAxis,
    log: Recorded | Sequence[Recorded],
    *,
    validation: Recorded | Sequence[Recorded] | None = None,
    nominal: Mapping[str, float] | None = None,
    measured: Sequence[str] | None = None,
    late: Mapping[str, float] | None = None,
    held: bool | None = None,
    library: Sequence[Effect] = LIBRARY,
    controller: Cascade | Sequence[Cascade] | None = None,
    **columns: Any,
) -> Diagnosis:
    """Find out why simulation and machine differ.

    Parameters
    ----------
    axis : Axis, str, GeneratedModel or DerivedModel
        The simulation: a declaration, the name or path of its file, or a model of it.
    log : Log, path-like, data frame or mapping, or a list of them
        Logs of the machine, from which everything is identified.
    validation : the same, optional
        Other logs, on which the gap is measured; by default the last of several logs, or every third part of one.
    nominal : mapping of str to float, optional
        Parameter values of the simulation, SI.
    measured : sequence of str, optional
        Sensors to read from files and frames; all of them by default.
    late, held, library, controller
        As in `symid.diagnosis.diagnose`.
    **columns
        ``columns``, ``units``, ``gains``, ``layout`` and ``sampling_period`` of files and frames, as in
        `symid.read_axis_log`.

    Raises
    ------
    LogError, SettingError
        If a log cannot be used, or there are neither nominal nor identified values to begin with.
    """
    declared = axis_of(axis)
    logs = logs_of(declared, log, measured, **columns)
    others = logs_of(declared, () if validation is None else validation, measured, **columns)
    return diagnose_axis(
        declared,
        logs,
        validation=others,
        nominal=nominal,
        late=late,
        held=held,
        library=library,
        controller=controller,
    )
