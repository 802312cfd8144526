"""Files as tables of named columns: the reader of each kind of file, found by its suffix.

Of CSV, Parquet, Feather and HDF5 files only the headers and the requested columns are read. A fault of the file raises
an error. A fault of one column is returned in place of its values, as a sentence, so that a caller can report all
columns together.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Final, TypeAlias

from symid.data.columns import TIME, split_unit
from symid.data.formats.channels import Channel, short_names, table_of_channels
from symid.data.formats.codesys_trace import codesys_trace_in
from symid.data.formats.compressed import OPENERS, open_compressed
from symid.data.formats.named_rows import named_rows_in
from symid.data.formats.own_clocks import with_own_clocks
from symid.data.formats.scope_text import scope_text_in
from symid.data.formats.serial_text import serial_text_in
from symid.data.formats.split_times import with_joined_times
from symid.data.table import Table, first_line, naming_file
from symid.data.text_files.csv_table import open_csv, open_laid_out
from symid.data.text_files.foreign import foreign_columns
from symid.data.text_files.layout import Layout, guessed_layout
from symid.errors import LogError
from symid.files import require_regular
from symid.registered import registered
from symid.units import to_si


def files_of_log(path: Path) -> tuple[Path, ...]:
    """Files of a log; all but the first may be named without their folder.

    >>> files_of_log(Path("a.csv"))
    (PosixPath('a.csv'),)
    """
    first, *others = map(Path, str(path).split("+"))
    if not others or path.exists() or not first.is_file():
        return (path,)
    return (first, *(other if other.exists() else first.parent / other for other in others))


def open_joined(parts: Sequence[Path], read: Callable[[Path], Table]) -> Table:
    """Columns of several files in one table, each with the times of its file; all times count from the same moment.

    LogError if a file has no time column, or its times are moments: those are read as seconds from the first one.
    """
    channels: list[tuple[tuple[str, ...], Channel]] = []
    for part in parts:
        table = read(part)
        clock, factor = _clock(part, table)
        columns = table.read(range(len(table.headers)))
        for place, values in enumerate(columns):
            clock_place = table.clocks.get(place, clock)
            time = columns[clock_place]
            if isinstance(time, str):
                raise LogError(f"{part}: column {table.headers[clock_place]!r} {time}")
            if place != clock and place not in table.clocks.values() and not isinstance(values, str):
                name, unit = split_unit(table.headers[place])
                channels.append(((part.stem, name), Channel(name, unit or "", factor * time, values)))
    names = short_names([path for path, _ in channels])
    return table_of_channels(
        [replace(channel, name=name) for name, (_, channel) in zip(names, channels, strict=True)]
    )


def _clock(part: Path, table: Table) -> tuple[int, float]:
    """Position of the time column, and its unit in seconds."""
    if table.stamps:
        raise LogError(
            f"{part}: its times are moments, whose common start is not known: save seconds in both files"
        )
    if table.clocks:
        return next(iter(table.clocks.values())), 1.0
    guesses = {column.header: column for column in foreign_columns(table) if column.quantity == "time"}
    for place, header in enumerate(table.headers):
        if header == TIME:
            return place, 1.0
        column = guesses.get(header)
        if column is not None and column.unit and (column.stated or column.unit == "s"):
            return place, to_si(column.unit)
    raise LogError(f"{part}: has no column of times in a known unit: call one 't [s]' or 't [ms]'")


Reader: TypeAlias = "Callable[[Path, int | None], Table]"
"""Function of the file and the memory in bytes that it may use (free memory if None)."""


_BEGINNING: Final = 800_000
"""Bytes from which the program that wrote a text is recognised: 200 000 characters of any encoding."""


def _open_text(path: Path, memory: int | None = None) -> Table:
    """Table in a CSV file, or in the text of a scope, a trace, a serial monitor or a database."""
    special = _special_text(path)
    return special() if special else open_csv(path)


def _special_text(path: Path) -> Callable[[], Table] | None:
    """Reader for the text of a scope, a trace, a serial monitor or a database; None for other files."""
    with path.open("rb") as file:
        begin = file.read(_BEGINNING)
    kinds = scope_text_in, codesys_trace_in, serial_text_in, named_rows_in
    return next((read for kind in kinds if (read := kind(path, begin))), None)


READERS: Final[Mapping[str, Reader]] = MappingProxyType(
    {".csv": _open_text}
    | {suffix: read for own in registered(__package__, "READERS") for suffix, read in own.items()}
)
"""Readers by suffix: those that the modules of this package list in their own `READERS`."""

SUFFIXES: Final = tuple(READERS)
"""Suffixes of files that can be read."""
_COMMON: Final = (".csv", ".parquet", ".mat")
"""Suffixes that a message names first."""
FOLDER_SUFFIXES: Final = tuple(
    s for s in SUFFIXES if s not in (".json", ".npz", ".npy", ".xls", ".ods", *OPENERS)
)
"""Suffixes that count as logs in a folder; other files often hold results and settings."""


def layout_found(path: Path, encoding: str | None = None) -> Layout | None:
    """Layout that a text file seems to have; None of other files, and of the text of scopes and traces."""
    is_table = path.is_file() and _is_text(path) and _special_text(path) is None
    return guessed_layout(path, encoding) if is_table else None


def _is_text(path: Path) -> bool:
    """Whether a file is text by its suffix, or by its content: some programs write text with the suffix of Excel."""
    suffix = suffix_of(path)
    if suffix == ".xls":
        with path.open("rb") as file:
            return not file.read(4).startswith((b"\xd0\xcf\x11\xe0", b"PK\x03\x04"))
    return suffix == ".csv" or suffix not in SUFFIXES


def suffix_of(path: Path) -> str:
    """Suffix of a file that selects its reader, in lower case.

    Examples
    --------
    >>> suffix_of(Path("a.b/Run.CSV.GZ")), suffix_of(Path("run.2.mat"))
    ('.csv.gz', '.mat')
    """
    name = path.name.lower()
    return next((s for s in SUFFIXES if s.startswith(".csv.") and name.endswith(s)), Path(name).suffix)


def open_table(path: Path, layout: Layout | None = None, memory: int | None = None) -> Table:
    """Table in a file, by its suffix; a CSV file by its layout if one is given, whatever its suffix.

    Parameters
    ----------
    path : Path
        The file, or several that hold one log as ``drive.csv+scope.csv``.
    layout : Layout, optional
        Of a CSV file, compressed or not.
    memory : int, optional
        Memory for what is read at once, such as a MATLAB file, bytes; the free memory by default.

    Raises
    ------
    LogError
        If the file does not exist, is of another kind, empty, damaged, or needs a library that is not installed.
    """
    try:
        parts = files_of_log(path)
    except (OSError, ValueError) as error:
        raise _not_readable(path, error) from error
    if len(parts) > 1:
        return open_joined(parts, lambda part: open_table(part, layout_found(part), memory))
    others = ", ".join(suffix for suffix in SUFFIXES if suffix not in _COMMON)
    kinds = f"{', '.join(_COMMON[:-1])} or {_COMMON[-1]} file, or {others}"
    if path.is_dir():
        raise LogError(f"{path}: is a directory: give a {kinds}")
    require_regular(path, LogError)
    suffix = suffix_of(path)
    if suffix in (".txt", ".tsv", ".log") and layout is None and path.is_file():
        with naming_file(path):
            if path.stat().st_size and (special := _special_text(path)):
                return special()
    if suffix not in SUFFIXES and layout is None:
        raise LogError(f"{path}: suffix {path.suffix!r} is not known: give a {kinds}")
    try:
        if path.stat().st_size == 0:
            raise LogError(f"{path}: is empty: give a file with a header and samples")
        if layout is not None and READERS.get(suffix) is open_compressed:
            return open_compressed(path, memory, layout)
        if layout is not None and _is_text(path):
            return with_own_clocks(with_joined_times(open_laid_out(path, layout)))
        with naming_file(path):
            return with_joined_times(READERS[suffix](path, memory))
    except OSError as error:
        raise _not_readable(path, error) from error


def _not_readable(path: Path, error: OSError | ValueError) -> LogError:
    """Error for a file that the system cannot open."""
    reason = getattr(error, "strerror", None) or first_line(error)
    return LogError(f"{path}: cannot be read ({reason}): check the file and its permissions")
