"""Logs of machines: reading, checking, resampling and writing them.

`text_files` and `formats` make tables of files, `quality` checks clock and channels, `reading` makes a `Log` of a
table.
"""

from symid.data.columns import REFERENCE, references_of
from symid.data.formats import open_table
from symid.data.frames import Frame
from symid.data.log import Log, require_times_within
from symid.data.long_log import AnyLog, LongLog, first_block, in_memory, spans
from symid.data.opening import MEMORY, ForeignColumns, columns_in, open_log, read_log
from symid.data.quality.stuck import cut_in_motion
from symid.data.table import Table
from symid.data.text_files.foreign import ForeignColumn, foreign_columns
from symid.data.text_files.layout import Layout, guessed_layout
from symid.data.writing import write_frame, write_log

__all__ = [
    "MEMORY",
    "REFERENCE",
    "AnyLog",
    "ForeignColumn",
    "ForeignColumns",
    "Frame",
    "Layout",
    "Log",
    "LongLog",
    "Table",
    "columns_in",
    "cut_in_motion",
    "first_block",
    "foreign_columns",
    "guessed_layout",
    "in_memory",
    "open_log",
    "open_table",
    "read_log",
    "references_of",
    "require_times_within",
    "spans",
    "write_frame",
    "write_log",
]
