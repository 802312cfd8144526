"""TDMS files of LabVIEW and DIAdem."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from symid.arrays import FloatArray
from symid.data.formats.channels import Channel, field_text, short_names, table_of_channels
from symid.data.formats.extra import required
from symid.data.table import Table, parsing, require_memory

_UNITS = ("unit_string", "NI_UnitDescription", "Unit", "unit")


def open_tdms(path: Path, memory: int | None = None) -> Table:
    """Table in a TDMS file: its channels, and the times of those that have a waveform's increment.

    LogError if it is damaged, or npTDMS is not installed.
    """
    nptdms = required("nptdms", path)
    with parsing(path, "TDMS"), _silent(), path.open("rb") as stream, nptdms.TdmsFile.open(stream) as file:
        channels = [channel for group in file.groups() for channel in group.channels() if len(channel)]
        require_memory(sum(len(channel) for channel in channels), memory)
        names = short_names([(channel.group_name, channel.name) for channel in channels])
        read = [
            Channel(name, field_text(samples.properties, _UNITS), _times(samples), np.asarray(samples[:]))
            for name, samples in zip(names, channels, strict=True)
            if samples.dtype.kind in "biufM"
        ]
    return table_of_channels(read)


@contextmanager
def _silent() -> Iterator[None]:
    """Suppress the warnings that the library writes to standard error."""
    before = logging.root.manager.disable
    logging.disable(logging.WARNING)
    try:
        yield
    finally:
        logging.disable(before)


def _times(channel: Any) -> FloatArray:
    step = channel.properties.get("wf_increment")
    if not isinstance(step, (int, float)) or not step > 0:
        return np.empty(0)
    start = channel.properties.get("wf_start_offset", 0.0)
    return np.asarray(float(start) + float(step) * np.arange(len(channel)))


READERS = {".tdms": open_tdms}
