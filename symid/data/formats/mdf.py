"""MDF files of measurement systems (ASAM, versions 3 and 4), read by asammdf in a separate process.

Its parser ends the process, or speaks on standard error, where a file is damaged: ``python -m symid.data.formats.mdf
FILE OUT.npz`` writes the channels of FILE for the process that asked.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from importlib import import_module
from pathlib import Path
from typing import Final

import numpy as np

from symid.data.formats.channels import Channel, short_names, table_of_channels
from symid.data.formats.extra import require_installed
from symid.data.memory import require_room
from symid.data.table import Table, damaged
from symid.errors import LogError

_LONGEST: Final = 600.0
"""Seconds that reading a file may take."""


def open_mdf(path: Path, memory: int | None = None) -> Table:
    """Table in an MDF file: its channels of numbers, each with the times of its group.

    LogError if it is damaged, or asammdf is not installed.
    """
    require_installed("asammdf", path)
    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "channels.npz"
        command = [sys.executable, "-m", "symid.data.formats.mdf", str(path.absolute()), str(written)]
        command.append(str(memory or ""))
        try:
            done = subprocess.run(command, capture_output=True, timeout=_LONGEST, check=False)
        except subprocess.TimeoutExpired as error:
            raise damaged(path, "MDF", error) from error
        if done.returncode or not written.exists():
            printed = done.stderr.decode("utf-8", "replace").strip().splitlines()
            raise damaged(path, "MDF", ValueError(printed[-1] if printed else "its parser ended"))
        with np.load(written) as arrays:
            clocks = [arrays[f"time_{clock}"] for clock in arrays["clocks"]]
            values = [arrays[f"values_{place}"] for place in range(len(clocks))]
            listed = zip(arrays["names"], arrays["units"], clocks, values, strict=True)
            return table_of_channels([Channel(str(name), str(unit), *rest) for name, unit, *rest in listed])


def _write(path: Path, file: Path, memory: int | None) -> None:
    """Write the channels of an MDF file as arrays."""
    with import_module("asammdf").MDF(path) as whole:
        values = sum(int(group.channel_group.cycles_nr) * len(group.channels) for group in whole.groups)
        require_room(values, memory)
        signals = [
            (group, whole.get(group=group, index=index))
            for group, one in enumerate(whole.groups)
            for index in range(len(one.channels))
            if index != whole.masters_db.get(group)
        ]
    numeric = [(group, s) for group, s in signals if s.samples.ndim == 1 and s.samples.dtype.kind in "biuf"]
    times = {f"time_{group}": np.asarray(s.timestamps, np.float64) for group, s in numeric}
    np.savez(
        file,
        allow_pickle=False,
        names=np.array(short_names([(str(group + 1), s.name) for group, s in numeric]), dtype=np.str_),
        units=np.array([str(s.unit or "") for _, s in numeric], dtype=np.str_),
        clocks=np.array([group for group, _ in numeric], dtype=np.int64),
        **times,
        **{f"values_{place}": s.samples for place, (_, s) in enumerate(numeric)},
    )


if __name__ == "__main__":
    try:
        _write(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]) if sys.argv[3] else None)
    except LogError as refused:
        sys.exit(str(refused))
    except Exception as failure:  # noqa: BLE001  any exception on a damaged file becomes one line
        sys.exit(f"{type(failure).__name__}: {failure}".partition("\n")[0])
