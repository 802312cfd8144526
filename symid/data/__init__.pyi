"""Names of `symid.data`."""

from symid.data.columns import (
    REFERENCE as REFERENCE,
    references_of as references_of,
    split_unit as split_unit,
)
from symid.data.formats import open_table as open_table
from symid.data.frames import Frame as Frame
from symid.data.log import SHORT_LOG as SHORT_LOG, Log as Log, require_times_within as require_times_within
from symid.data.long_log import (
    AnyLog as AnyLog,
    LongLog as LongLog,
    first_block as first_block,
    in_memory as in_memory,
    spans as spans,
)
from symid.data.opening import (
    MEMORY as MEMORY,
    ForeignColumns as ForeignColumns,
    columns_in as columns_in,
    open_log as open_log,
    read_log as read_log,
)
from symid.data.polars_tables import POLARS_FAILURES as POLARS_FAILURES, source_of as source_of
from symid.data.quality.stuck import cut_in_motion as cut_in_motion
from symid.data.resampling import Rate as Rate
from symid.data.table import Table as Table, require_memory as require_memory, whole_memory as whole_memory
from symid.data.text_files.foreign import foreign_columns as foreign_columns
from symid.data.text_files.foreign_column import ForeignColumn as ForeignColumn
from symid.data.text_files.layout import Layout as Layout, guessed_layout as guessed_layout
from symid.data.writing import (
    WRITTEN_SUFFIXES as WRITTEN_SUFFIXES,
    write_frame as write_frame,
    write_log as write_log,
)
