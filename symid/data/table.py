"""Tables of named columns, read as a whole or in slices of rows, and the memory that they may take."""

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from symid.arrays import FloatArray
from symid.errors import LogError

_VALUE = 8  # bytes of a number
_MANY_ROWS = 1_000_000


def require_memory(n_values: int, memory: int | None = None) -> None:
    """Raise LogError if `n_values` 64-bit numbers take more than `memory` bytes; by default, more than are free."""
    if not fits_memory(n_values, memory):
        needed, allowed = _VALUE * n_values, _allowed(memory)
        which = "are free" if memory is None else "are allowed (`memory`)"
        raise LogError(
            f"needs {_size(needed)} of memory, but {_size(allowed)} {which}: cut the log, or save it as a CSV or "
            "Parquet file and identify it by wls, which reads blocks"
        )


def fits_memory(n_values: int, memory: int | None = None) -> bool:
    """Whether `n_values` numbers fit into `memory`, as `require_memory` judges it."""
    return _VALUE * n_values <= _allowed(memory)


def _allowed(memory: int | None) -> float:
    return free_memory() if memory is None else memory


def free_memory() -> float:
    """Bytes of memory that are free or can be freed; infinite where the system does not report it."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return next(1024.0 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable"))
    except (OSError, ValueError, StopIteration):
        return whole_memory()


def whole_memory() -> float:
    """Bytes of memory of this machine; infinite where the system does not report it."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return math.inf


def _size(n_bytes: float) -> str:
    return f"{n_bytes / 1e9:.3g} GB" if n_bytes >= 1e8 else f"{n_bytes / 1e6:.3g} MB"


@dataclass(frozen=True)
class Slices:
    """Rows of some columns of a file, read in slices."""

    n_rows: int  # rows of the file
    # takes the first row and the one behind the last; gives what `read` of a table gives, of these rows
    read: Callable[[int, int], list[FloatArray | str]]


@dataclass(frozen=True)
class Table:
    """Named columns of a file."""

    headers: tuple[str, ...]
    """Header of each column as written in the file."""
    read: Callable[[Sequence[int]], list[FloatArray | str]]
    """Takes positions of columns, gives for each its values, with NaN where the file has none, or a sentence that
    says why they cannot be used."""
    slices: Callable[[Sequence[int]], Slices] | None = None
    """Takes positions of columns, gives their rows piece by piece; None where a file can only be read as a whole."""
    n_rows: int | None = None
    """Rows by the header of the file; None without such a number."""
    clocks: Mapping[int, int] = field(default_factory=dict)
    """Position of the column of the times of each column, where columns have separate clocks."""
    stamps: frozenset[int] = frozenset()
    """Positions of columns whose values are moments written as text, which are read as seconds."""

    def beginning(self) -> list[FloatArray | str]:
        """Columns up to a million rows; all rows of a file that can only be read as a whole."""
        everything = range(len(self.headers))
        if self.slices is None or self.n_rows is None:
            require_memory(len(self.headers) * (self.n_rows or 0))
            return self.read(everything)
        return self.slices(everything).read(0, min(self.n_rows, _MANY_ROWS))


@contextmanager
def naming_file(file: Path) -> Iterator[None]:
    """Put the name of a file before the message of a LogError."""
    try:
        yield
    except LogError as error:
        message = str(error)
        named = error if message.startswith(f"{file}: ") else LogError(f"{file}: {message}")
        raise named from error.__cause__


def first_line(error: BaseException) -> str:
    """First line of the message of an error."""
    lines = str(error).strip().splitlines()
    return lines[0].rstrip(".") if lines else type(error).__name__


def damaged(path: Path, kind: str, error: BaseException) -> LogError:
    """Error for a file whose content does not match its suffix."""
    return LogError(f"{path}: is damaged, or not a {kind} file ({first_line(error)}): write it again")


@contextmanager
def parsing(path: Path, kind: str, *failures: type[BaseException]) -> Iterator[None]:
    """Turn the exceptions of a parser, by default all but LogError, into `damaged`."""
    expected = failures or (Exception,)
    try:
        yield
    except LogError:
        raise
    except expected as error:
        raise damaged(path, kind, error) from error
