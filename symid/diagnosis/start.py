"""Parameter values to begin with where none are given."""

from __future__ import annotations

import numpy as np

from symid.axis import Axis
from symid.codegen import load_generated
from symid.diagnosis.record import Record
from symid.errors import SettingError, SymidError
from symid.identification import identify


def starting_parameters(axis: Axis, record: Record) -> dict[str, float]:
    """Physical parameters by weighted least squares on the minimal regressor.

    Raises
    ------
    SettingError
        If they do not follow from the log.
    """
    try:
        found = identify(load_generated(axis, record.signals), record.log, examine=False).physical_parameters
    except SymidError as error:
        raise SettingError(
            f"no values to begin with can be identified ({error}): give --nominal P.json"
        ) from error
    lacking = [name for name in axis.physical_parameters if not np.isfinite(found.get(name, np.nan))]
    if lacking:
        raise SettingError(
            f"no values to begin with follow from the log for {', '.join(lacking)}: give --nominal P.json"
        )
    return {name: float(found[name]) for name in axis.physical_parameters}
