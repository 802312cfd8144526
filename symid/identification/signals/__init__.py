"""Signals of an axis among the columns of a log."""

from symid.identification.signals.axis_logs import (
    LogLike,
    axis_columns,
    each_of,
    log_of,
    logs_of,
    require_changing,
)
from symid.identification.signals.fitting_columns import UNITS_TO_GIVE, for_drive, for_sensor
from symid.identification.signals.mapping import require_known

__all__ = [
    "UNITS_TO_GIVE",
    "LogLike",
    "axis_columns",
    "each_of",
    "for_drive",
    "for_sensor",
    "log_of",
    "logs_of",
    "require_changing",
    "require_known",
]
