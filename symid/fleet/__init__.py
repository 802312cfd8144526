"""Many logs at once: each identified and diagnosed alone, on all cores or a cluster, into one table."""

from symid.fleet.batch import Batch, Interrupted, identify_batch
from symid.fleet.journal import journal_file, read_journal
from symid.fleet.settings import BatchSettings
from symid.fleet.summary import summary_of
from symid.fleet.table import UNITS, read_rows

__all__ = [
    "UNITS",
    "Batch",
    "BatchSettings",
    "Interrupted",
    "identify_batch",
    "journal_file",
    "read_journal",
    "read_rows",
    "summary_of",
]
