"""Parsers that may crash on a damaged file, run in a separate process.

``python -m MODULE FILE OUT.npz MEMORY`` writes the channels of FILE for the process that asked, by `answer`.
"""

import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np

from symid.data.formats.channels import Channel
from symid.data.table import damaged
from symid.errors import LogError

Parser: TypeAlias = "Callable[[Path, int | None], Sequence[Channel]]"
"""Function of a file and the memory in bytes that it may use (free memory if None)."""
_LONGEST: Final = 600.0
"""Seconds that reading a file may take."""
_REFUSED: Final = 3
"""Exit code of a process that reports what is wrong with the file."""


def channels_apart(module: str, path: Path, memory: int | None, kind: str) -> list[Channel]:
    """Channels of a file, parsed by a module in a separate process; LogError if that fails."""
    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "channels.npz"
        command = [sys.executable, "-W", "ignore", "-m", module, str(path.absolute()), str(written)]
        command.append(str(memory or ""))
        try:
            done = subprocess.run(command, capture_output=True, timeout=_LONGEST, check=False)
        except subprocess.TimeoutExpired as error:
            raise damaged(path, kind, error) from error
        if done.returncode or not written.exists():
            printed = done.stderr.decode("utf-8", "replace").strip().splitlines()
            reason = printed[-1] if printed else "its parser ended"
            if done.returncode == _REFUSED:
                raise LogError(f"{path}: {reason.removeprefix(f'{path.absolute()}: ')}")
            raise damaged(path, kind, ValueError(reason))
        with np.load(written) as arrays:
            clocks = [arrays[f"time_{clock}"] for clock in arrays["clocks"]]
            values = [arrays[f"values_{place}"] for place in range(len(clocks))]
            listed = zip(arrays["names"], arrays["units"], clocks, values, strict=True)
            return [Channel(str(name), str(unit), *rest) for name, unit, *rest in listed]


def answer(parse: Parser) -> None:
    """Parse the file that the arguments name and write its channels; a failure is one line and an exit code."""
    path, out, memory = sys.argv[1:4]
    try:
        channels = parse(Path(path), int(memory) if memory else None)
        times = {id(channel.time): channel.time for channel in channels}
        places = {key: place for place, key in enumerate(times)}
        np.savez(
            Path(out),
            allow_pickle=False,
            names=np.array([channel.name for channel in channels], dtype=np.str_),
            units=np.array([channel.unit for channel in channels], dtype=np.str_),
            clocks=np.array([places[id(channel.time)] for channel in channels], dtype=np.int64),
            **{f"time_{places[key]}": np.asarray(time, np.float64) for key, time in times.items()},
            **{f"values_{place}": channel.values for place, channel in enumerate(channels)},
        )
    except LogError as refused:
        print(str(refused).partition("\n")[0], file=sys.stderr)
        sys.exit(_REFUSED)
    except Exception as failure:  # noqa: BLE001  any exception on a damaged file becomes one line
        sys.exit(f"{type(failure).__name__}: {failure}".partition("\n")[0])
