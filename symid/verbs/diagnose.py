"""`diagnose` of any axis from any log."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from typing import Any

from symid.axis import Axis
from symid.codegen import model_of
from symid.data import Log
from symid.diagnosis import LIBRARY, Diagnosis, Effect
from symid.diagnosis import diagnose as diagnose_axis
from symid.errors import SymidError
from symid.simulation import Cascade
from symid.verbs.axes import AnyAxis, axis_of
from symid.verbs.logs import Recorded, log_of


def diagnose(
    axis: AnyAxis,
    log: Recorded,
    *,
    validation: Recorded | None = None,
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
    log : Log, path-like, data frame or mapping
        A log of the machine, from which everything is identified.
    validation : the same, optional
        Another log, on which the gap is measured; every third part of `log` by default.
    nominal : mapping of str to float, optional
        Parameter values of the simulation, SI.
    measured : sequence of str, optional
        Sensors to read from files and frames; all that they hold by default.
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
    machine = log_of(declared, log, measured, **columns)
    first, other = machine.window(0, machine.n_samples), None
    if validation is not None:
        unseen = log_of(declared, validation, measured, **columns)
        other = unseen.window(0, unseen.n_samples)
    require_model(declared, first)
    return diagnose_axis(
        declared,
        first,
        validation=other,
        nominal=nominal,
        late=late,
        held=held,
        library=library,
        controller=controller,
    )


def require_model(axis: Axis, log: Log) -> None:
    """Derive the model from which a diagnosis gets the values it begins with, where it was not generated."""
    signals = [sensor.signal for sensor in axis.sensors if sensor.signal in log.signals]
    with contextlib.suppress(SymidError):  # reported by the diagnosis, which may be given nominal values
        model_of(axis, signals)
