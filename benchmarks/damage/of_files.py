"""Kinds of damage of the bytes of a file, of the text of a CSV file, and of the types of its columns."""

from collections.abc import Callable

import numpy as np
import polars as pl

from benchmarks.damage.log import Columns, as_bytes

Generator = np.random.Generator
OfBytes = Callable[[bytes, Generator, float], bytes]


def truncated(content: bytes, rng: Generator, extent: float) -> bytes:
    """A file that ends early."""
    return content[: int(extent * len(content))]


def flipped(content: bytes, rng: Generator, extent: float) -> bytes:
    """Single bytes that are others."""
    out = bytearray(content)
    for place in rng.integers(0, len(out), 1 + int(20 * extent)):
        out[place] = int(rng.integers(0, 256))
    return bytes(out)


def garbage(content: bytes, rng: Generator, extent: float) -> bytes:
    """Random bytes replace the file."""
    return rng.integers(0, 256, 1 + int(extent * 20_000), dtype=np.uint8).tobytes()


def empty(content: bytes, rng: Generator, extent: float) -> bytes:
    """The file has no content."""
    return b""


def hole(content: bytes, rng: Generator, extent: float) -> bytes:
    """Zeros in the middle, as a disk leaves that lost a block."""
    start = int(rng.integers(0, len(content)))
    length = 1 + int(extent * 4096)
    return content[:start] + bytes(min(length, len(content) - start)) + content[start + length :]


def twice(content: bytes, rng: Generator, extent: float) -> bytes:
    """One file behind the other."""
    return content + content


OF_BYTES: dict[str, OfBytes] = {f.__name__: f for f in (truncated, flipped, garbage, empty, hole, twice)}


def _lines(columns: Columns) -> list[str]:
    return as_bytes(columns, "csv").decode().splitlines()


def text_cells(columns: Columns, rng: Generator, extent: float) -> bytes:
    """Words among the numbers of a CSV file."""
    lines = _lines(columns)
    for row in rng.integers(1, len(lines), 1 + int(5 * extent)):
        fields = lines[row].split(",")
        fields[rng.integers(0, 3)] = str(
            rng.choice(["hello", "#N/A", "1.2.3", "0x1F", "1e", "—", "1,5", '"'])
        )
        lines[row] = ",".join(fields)
    return "\n".join(lines).encode()


def ragged_lines(columns: Columns, rng: Generator, extent: float) -> bytes:
    """Lines with too few or too many fields."""
    lines = _lines(columns)
    for row in rng.integers(1, len(lines), 1 + int(5 * extent)):
        fields = lines[row].split(",")
        lines[row] = ",".join(fields[: rng.integers(0, 3)] if rng.random() < 0.5 else [*fields, "1.0"])
    return "\n".join(lines).encode()


def odd_header(columns: Columns, rng: Generator, extent: float) -> bytes:
    """A header with marks, blanks, another encoding, quotes, duplicates, or none."""
    head, *rest = _lines(columns)
    heads = [
        "\ufefft,q,F",
        " t , q , F ",
        '"t","q","F"',
        "t,q,q",
        "q,q,F",
        "",
        "t;q;F",
        "т,q,F",
        "T,Q,f",
        "t,q,F,,",
    ]
    head = str(rng.choice(heads))
    encoding = str(rng.choice(["utf-8", "utf-16", "utf-8-sig"]))
    return "\n".join([head, *rest]).encode(encoding)


def decimal_commas(columns: Columns, rng: Generator, extent: float) -> bytes:
    """Numbers and separators as in Germany."""
    return "\r\n".join(line.replace(",", ";").replace(".", ",") for line in _lines(columns)).encode()


OF_TEXT: dict[str, Callable[[Columns, Generator, float], bytes]] = {
    f.__name__: f for f in (text_cells, ragged_lines, odd_header, decimal_commas)
}


def nested(columns: Columns, rng: Generator, extent: float) -> pl.DataFrame:
    """A column of lists, structures, dates, categories, decimals or nothing."""
    frame, name = pl.DataFrame(columns), str(rng.choice(["t", "q", "F"]))
    column = pl.col(name)
    others = [
        pl.concat_list(column),
        pl.struct(column),
        (1e6 * column).cast(pl.Int64).cast(pl.Datetime("us")),
        column.cast(pl.String),
        column.cast(pl.String).cast(pl.Categorical),
        column.cast(pl.Decimal(30, 12)),
        pl.lit(None),
        pl.lit(None).cast(pl.Float64),
        (1e6 * column).cast(pl.Int64).cast(pl.Duration("us")),
        column.cast(pl.String).cast(pl.Binary),
    ]
    return frame.with_columns(others[rng.integers(0, len(others))].alias(name))


OF_FRAME: dict[str, Callable[[Columns, Generator, float], pl.DataFrame]] = {"nested": nested}
