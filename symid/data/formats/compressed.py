"""Text files compressed by gzip, bzip2, xz or zip."""

import bz2
import gzip
import lzma
import zipfile
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import IO, Any, Final, TypeAlias

from symid.data.formats.own_clocks import with_own_clocks
from symid.data.table import Table, free_memory, parsing
from symid.data.text_files.csv_table import laid_out
from symid.data.text_files.layout import Layout, layout_of_text, lines_of
from symid.errors import LogError

_TIMES_TEXT: Final = 4
"""Memory for the columns and the text, in multiples of the text."""
_MEMORY: Final = 1_000_000_000
"""Memory for them by default, bytes: a small file may unpack to any amount of text."""
_Opener: TypeAlias = "Callable[[Path], Any]"


def _only_file(path: Path) -> IO[bytes]:
    """The file in an archive; LogError if it holds several."""
    archive = zipfile.ZipFile(path)
    files = [entry for entry in archive.infolist() if not entry.is_dir()]
    if len(files) != 1:
        raise LogError(f"{path}: is an archive of {len(files)} files: unpack it, and give one of them")
    return archive.open(files[0])


OPENERS: Final[Mapping[str, _Opener]] = MappingProxyType(
    {".gz": gzip.GzipFile, ".bz2": bz2.BZ2File, ".xz": lzma.LZMAFile, ".zip": _only_file}
)
"""Functions that open a compressed file for reading bytes, by suffix."""
_FAILURES: Final = (
    OSError,
    EOFError,
    zlib.error,
    lzma.LZMAError,
    zipfile.BadZipFile,
    RuntimeError,
    ValueError,
)


def open_compressed(path: Path, memory: int | None = None, layout: Layout | None = None) -> Table:
    """Table in a compressed CSV file, of a layout that is given or guessed.

    LogError if it is damaged, or longer than the memory.
    """
    suffix = path.suffix.lower()
    most = min(free_memory(), memory or _MEMORY) / _TIMES_TEXT
    with parsing(path, suffix, *_FAILURES), OPENERS[suffix](path) as file:
        text = file.read(int(min(most, 2**62)) + 1)
    if len(text) > most:
        raise LogError(f"{path}: holds more than {most / 1e6:.3g} MB of text: uncompress it")
    layout_read = layout or layout_of_text(path, text)
    return with_own_clocks(
        laid_out(path, layout_read, lines_of(path, text, layout_read.encoding), lambda: text)
    )


READERS = {text + suffix: open_compressed for text in (".csv", "") for suffix in OPENERS}
