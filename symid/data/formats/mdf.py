"""MDF files of measurement systems (ASAM, versions 3 and 4), read by asammdf in a separate process."""

from importlib import import_module
from pathlib import Path

import numpy as np

from symid.data.formats.channels import Channel, short_names, table_of_channels
from symid.data.formats.extra import require_installed
from symid.data.formats.separate import answer, channels_apart
from symid.data.table import Table, require_memory


def open_mdf(path: Path, memory: int | None = None) -> Table:
    """Table in an MDF file: its channels of numbers, each with the times of its group.

    LogError if it is damaged, or asammdf is not installed.
    """
    require_installed("asammdf", path)
    return table_of_channels(channels_apart("symid.data.formats.mdf", path, memory, "MDF"))


def _parsed(path: Path, memory: int | None) -> list[Channel]:
    with import_module("asammdf").MDF(path) as whole:
        values = sum(int(group.channel_group.cycles_nr) * len(group.channels) for group in whole.groups)
        require_memory(values, memory)
        signals = [
            (group, whole.get(group=group, index=index))
            for group, group_of_channels in enumerate(whole.groups)
            for index in range(len(group_of_channels.channels))
            if index != whole.masters_db.get(group)
        ]
    numeric = [(group, s) for group, s in signals if s.samples.ndim == 1 and s.samples.dtype.kind in "biuf"]
    names = short_names([(str(group + 1), s.name) for group, s in numeric])
    times = {group: np.asarray(s.timestamps, np.float64) for group, s in numeric}
    return [
        Channel(name, str(s.unit or ""), times[group], s.samples)
        for name, (group, s) in zip(names, numeric, strict=True)
    ]


READERS = {".mf4": open_mdf, ".mdf": open_mdf}


if __name__ == "__main__":
    answer(_parsed)
