"""Preparation of logs for a diagnosis: repaired, in physical units, with positions, and divided by purpose.

Parameters that the logs do not determine, such as a constant force in motion of one direction, become known.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symid.axis import Axis
from symid.data import Log
from symid.diagnosis.prediction.data import LogsByPurpose, logs_by_purpose
from symid.diagnosis.prediction.integrated_speed import with_positions
from symid.diagnosis.prediction.one_way import indistinct_constant_forces
from symid.diagnosis.prediction.recorder import repaired
from symid.diagnosis.prediction.scaled_sensors import with_quantities
from symid.identification import Preparation


@dataclass(frozen=True, eq=False)
class PreparedLogs:
    """Logs that the diagnosis can use, and the axis in terms of their signals."""

    logs: LogsByPurpose
    axis: Axis
    declared: Axis  # with its own sensors, and the parameters that became known
    decimation: int  # recorded samples for each sample of the logs
    faults: tuple[str, ...]  # sentences on repaired faults of the recorder
    notes: tuple[str, ...]  # sentences on the conversions


def prepared(
    axis: Axis,
    logs: Sequence[Log],
    n_validation: int | None,
    nominal: Mapping[str, float] | None,
    preparation: Preparation,
) -> PreparedLogs:
    """Prepare logs, of which the last `n_validation` validate; by default the last of several."""
    whole = repaired(axis, logs)
    plain = with_quantities(axis, whole.logs, nominal, preparation)
    moving, every, notes = with_positions(plain.axis, plain.logs)
    constants, indistinct = indistinct_constant_forces(moving, every, nominal)
    moving = moving.with_known(constants)
    return PreparedLogs(
        logs_by_purpose(moving, every, n_validation),
        moving,
        plain.declared.with_known(constants),
        whole.decimation,
        whole.notes,
        (*plain.notes, *notes, *indistinct),
    )
