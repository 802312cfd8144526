"""Logs of machines: reading, checking, resampling and writing them.

`text_files` and `formats` make tables of files, `quality` checks clock and channels, `reading` makes a `Log` of a
table.
"""

from symid.data.columns import REFERENCE, references_of, split_unit
from symid.data.formats import open_table
from symid.data.frames import Frame
from symid.data.log import SHORT_LOG, Log, require_times_within
from symid.data.long_log import AnyLog, LongLog, first_block, in_memory, spans
from symid.data.opening import MEMORY, ForeignColumns, columns_in, open_log, read_log
from symid.data.quality.stuck import cut_in_motion
from symid.data.resampling import Rate
from symid.data.table import POLARS_FAILURES, Table, require_memory, source_of, whole_memory
from symid.data.text_files.foreign import foreign_columns
from symid.data.text_files.foreign_column import ForeignColumn
from symid.data.text_files.layout import Layout, guessed_layout
from symid.data.writing import WRITTEN_SUFFIXES, write_frame, write_log

__all__ = [
    "MEMORY",
    "POLARS_FAILURES",
    "REFERENCE",
    "SHORT_LOG",
    "WRITTEN_SUFFIXES",
    "AnyLog",
    "ForeignColumn",
    "ForeignColumns",
    "Frame",
    "Layout",
    "Log",
    "LongLog",
    "Rate",
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
    "require_memory",
    "require_times_within",
    "source_of",
    "spans",
    "split_unit",
    "whole_memory",
    "write_frame",
    "write_log",
]
