"""Layout of a CSV file, guessed from its beginning: encoding, separator, decimal mark, lines above the header."""

from __future__ import annotations

import codecs
import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from symid.data.grouped_numbers import is_grouped
from symid.data.time_stamps import is_stamp
from symid.errors import LogError

_BEGINNING = 200_000  # characters from which the layout is guessed
_LINES = 400  # most lines above the values
_LEAST_ROWS = 5  # adjacent lines with the same number of fields make a table
_SEPARATORS = ("\t", ";", ",", "|", " ")
_MARKS = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))
_COMMA_NUMBER = re.compile(r"[-+]?\d+,\d+([eE][-+]?\d+)?")


@dataclass(frozen=True)
class Layout:
    """Layout of a CSV file.

    Parameters
    ----------
    encoding : str
        Encoding of its text.
    separator : str
        Separator of fields; a space means any number of spaces and tabs.
    decimal : str
        Decimal mark, a point or a comma.
    above : int
        Lines above the header.
    below : int
        Lines between header and values: if one holds texts, they are joined to the names as units.
    named : bool
        Whether there is a line of names; without one the columns are called ``column 1`` and so on.
    """

    encoding: str = "utf-8-sig"
    separator: str = ","
    decimal: str = "."
    above: int = 0
    below: int = 0
    named: bool = True

    def __post_init__(self) -> None:
        if self.decimal not in (".", ",") or len(self.separator) != 1 or min(self.above, self.below) < 0:
            raise LogError(
                f"layout of a file is not possible (separator {self.separator!r}, decimal {self.decimal!r}, "
                f"{self.above} lines above, {self.below} below): give one character, a point or comma, and no "
                "negative numbers"
            )
        try:
            known = isinstance("".encode(self.encoding), bytes)  # hex, zlib and rot13 are not text encodings
        except (LookupError, ValueError, TypeError) as error:
            raise LogError(f"encoding {self.encoding!r} is not known: write for example utf-8") from error
        if not known or self.separator in '\r\n\0"' or self.separator == self.decimal:
            raise LogError(f"separator {self.separator!r} is not possible: write for example ';'")
        if max(self.above, self.below) > _LINES:
            raise LogError(
                f"{max(self.above, self.below)} lines around the header: at most {_LINES} are read"
            )

    @property
    def skipped(self) -> int:
        """Lines above the values."""
        return self.above + self.below + self.named

    def headers(self, lines: Sequence[str]) -> tuple[str, ...]:
        """Headers in the first lines of a file; a line of units below them is joined to them as ``name [unit]``.

        A header that occurs more than once is numbered.
        """
        if not self.named:
            count = len(fields(lines[self.skipped].rstrip(self.separator), self.separator))
            return tuple(f"column {i + 1}" for i in range(count))
        names = [text.strip() for text in fields(uncommented(lines[self.above]), self.separator)]
        below = [line for line in lines[self.above + 1 : self.skipped] if line.strip(f"{self.separator} ")]
        units = [""] * len(names)
        if len(below) == 1:
            written = [text.strip().strip("[]()") for text in fields(below[0], self.separator)]
            units = [*written, *units][: len(names)]
        pairs = list(zip(names, units, strict=True))
        return tuple(
            (f"{name} ({pairs[: i + 1].count(pair)})" if name and pairs.count(pair) > 1 else name)
            + (f" [{unit}]" if unit else "")
            for i, pair in enumerate(pairs)
            for name, unit in [pair]
        )


def uncommented(line: str) -> str:
    """A line without the mark of a comment at its beginning, as programs write it before names.

    >>> uncommented("# t q F")
    't q F'
    """
    return line.lstrip().removeprefix("#").lstrip(" ") if line.lstrip().startswith("#") else line


def fields(line: str, separator: str) -> list[str]:
    """Fields of a line; a line with an unclosed quote or an overlong field is one field."""
    if separator == " ":
        return line.split()
    try:
        return next(csv.reader([line], delimiter=separator), [])
    except csv.Error:
        return [line]


def first_lines(path: Path, encoding: str) -> list[str]:
    """The first lines of a text file; LogError if the text has another encoding."""
    with path.open("rb") as file:
        return lines_of(path, file.read(4 * _BEGINNING), encoding)


def lines_of(path: Path, content: bytes, encoding: str) -> list[str]:
    """The first lines of the bytes of a text file; errors as those of `first_lines`."""
    if content.startswith(b"PK\x03\x04"):
        raise LogError(f"{path}: is an archive: unpack it, and give the files in it")
    try:
        text = codecs.getincrementaldecoder(encoding)().decode(content[: 4 * _BEGINNING])[:_BEGINNING]
    except UnicodeError as error:
        raise LogError(f"{path}: is not text in {encoding}: give its encoding") from error
    return [line.rstrip("\r\n") for line in io.StringIO(text, newline="")][:_LINES]


def guessed_layout(path: Path) -> Layout:
    """The layout that a CSV file seems to have.

    The values begin where at least five lines in a row hold equally many numbers and nothing else; the separator is
    the one that gives most of them. The header is the nearest line above with as many texts.

    Raises
    ------
    LogError
        If no separator gives columns of numbers.
    """
    with path.open("rb") as file:
        return layout_of_text(path, file.read(4 * _BEGINNING))


def layout_of_text(path: Path, content: bytes) -> Layout:
    """The layout that the bytes of a text file seem to have; errors as those of `guessed_layout`."""
    encoding = encoding_of(content[:_BEGINNING])
    lines = lines_of(path, content, encoding)
    best: tuple[int, Layout] | None = None
    for separator in _SEPARATORS:
        found = _table(lines, separator)
        if found is None:
            continue
        width, begin = found
        header = _header(lines[:begin], separator, width)
        decimal = "," if separator != "," and has_decimal_comma(lines[begin:], separator) else "."
        if header is not None:
            layout = Layout(encoding, separator, decimal, header, begin - header - 1)
        elif begin == 0 or sum(bool(text.strip()) for text in fields(lines[begin - 1], separator)) < 2:
            layout = Layout(encoding, separator, decimal, begin, named=False)
        else:
            continue
        if best is None or width > best[0]:
            best = width, layout
    if best is None:
        raise LogError(
            f"{path}: no columns of numbers below a line of names are found: export it as CSV with one line of names"
        )
    return best[1]


def encoding_of(begin: bytes) -> str:
    """The encoding that the beginning of a text file seems to have."""
    for mark, name in _MARKS:
        if begin.startswith(mark):
            return name
    if begin[1:2] == b"\x00":
        return "utf-16-le"
    try:
        codecs.getincrementaldecoder("utf-8")().decode(begin)
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8-sig"


def _table(lines: Sequence[str], separator: str) -> tuple[int, int] | None:
    """Number of columns of the values, and their first line."""
    widths = [_numbers(line, separator) for line in lines]
    for begin in range(len(widths) - _LEAST_ROWS + 1):
        run = widths[begin : begin + _LEAST_ROWS]
        width = max(filled for _, filled in run)
        if width > 1 and min(filled for _, filled in run) and len({whole for whole, _ in run}) == 1:
            return width, begin
    return None


def _numbers(line: str, separator: str) -> tuple[int, int]:
    """Fields of a line of numbers, all and those up to the last that is not blank; 0 if one is anything else.

    A blank one at the end is a separator too many, or a sample that a slower channel lacks.
    """
    texts = [text.strip() for text in fields(line, separator)]
    comma = separator != ","
    if not all(is_number_text(text, comma=comma) for text in texts):
        return 0, 0
    return len(texts), max((place for place, text in enumerate(texts, 1) if text), default=0)


def without_footer(text: str, separator: str) -> str:
    r"""Lines of values without those below them that hold a remark, such as ``EOF``: fewer fields, the first no number.

    >>> without_footer("0;1,5\n1;2,5\n\nSamples: 2", ";")
    '0;1,5\n1;2,5'
    """
    width = len(fields(text.split("\n", 1)[0], separator))
    while True:
        text = text.rstrip("\n")
        above, _, last = text.rpartition("\n")
        filled = [part.strip() for part in fields(last, separator) if part.strip()]
        if not 0 < len(filled) < width or is_number_text(filled[0], comma=separator != ","):
            return text
        text = above


def is_number_text(text: str, *, comma: bool) -> bool:
    """Whether a field holds a number, with marks of thousands or without, or a moment, or nothing."""
    try:
        float(text.replace(",", ".") if comma else text)
    except ValueError:
        return text == "" or is_stamp(text) or is_grouped(text)
    return True


def _header(above: Sequence[str], separator: str, width: int) -> int | None:
    """Line of the names: the upper one if there are two adjacent lines of texts above the values.

    Empty lines may stand between them and the values. A line with a number holds a property such as the sampling time.
    """
    nearest: int | None = None
    last = len(above) - 1
    while last >= 0 and not above[last].strip(f"{separator} "):
        last -= 1
    for place in range(last, max(last - 2, -1), -1):
        texts = [text.strip() for text in fields(uncommented(above[place]), separator)]
        filled = [text for text in texts if text]
        if (
            len(texts) < width
            or (separator == " " and len(texts) > width)
            or not filled
            or any(_numbers(above[place], separator))
            or (nearest is not None and any(is_number_text(text, comma=separator != ",") for text in filled))
        ):
            break
        if len(filled) >= width - 1 or nearest is None:
            nearest = place
    return nearest


def has_decimal_comma(lines: Sequence[str], separator: str) -> bool:
    """Whether lines hold numbers such as 1,5."""
    return any(_COMMA_NUMBER.fullmatch(text.strip()) for line in lines for text in fields(line, separator))
