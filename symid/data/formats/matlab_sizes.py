"""Sizes of the compressed variables of a MATLAB file, before they are loaded.

A file of version 5 to 7 is a header of 128 bytes and elements: type and size in 4 bytes each, then the data. A
compressed element holds one other element (MathWorks, MAT-File Format, "Level 5 MAT-File Format"). Little of a file can
become much memory, and the size that the inner element states need not be true.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Final

_HEADER: Final = 128
_ORDERS: Final = {b"IM": "<", b"MI": ">"}
"""Mark of the byte order at the end of the header, as written by a machine of the other order."""
COMPRESSED: Final = 15
"""Type of an element that is compressed."""
_PIECE: Final = 1 << 20
DEFLATED: Final = 1032
"""Largest ratio of zlib's compression (https://zlib.net/zlib_tech.html)."""


def unpacked_sizes(path: Path) -> Iterator[int]:
    """Bytes that the compressed variables of a file take: a growing sum, first as stated, then as counted."""
    with path.open("rb") as file:
        order = _ORDERS.get(file.read(_HEADER)[-2:])
        if order is None:
            return  # version 4, which has no compression, or 7.3, which is HDF5
        whole = 0
        while len(tag := file.read(8)) == 8:
            kind, size = struct.unpack(f"{order}II", tag)
            if kind != COMPRESSED:
                file.seek(size, 1)
                continue
            packed, counted, stream = file.read(size), 0, zlib.decompressobj()
            while packed and not stream.eof:
                piece = stream.decompress(packed, _PIECE if counted else 8)
                stated = struct.unpack(f"{order}II", piece)[1] if not counted and len(piece) == 8 else 0
                counted, packed = counted + len(piece), stream.unconsumed_tail
                yield whole + max(counted, stated)
            whole += counted
