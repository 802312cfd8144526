"""Layout of a CSV file, guessed from its beginning: encoding, separator, decimal mark, lines above the header."""

import codecs
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from symid.data.text_files.column_names import named, split_header, words_of
from symid.data.text_files.comma_pairs import are_pairs, may_be_pairs
from symid.data.text_files.text_table import (
    LEAST_ROWS,
    are_units,
    fields,
    is_number_text,
    names_above,
    names_in,
    numbers_columns,
    values_in,
)
from symid.errors import LogError

_BEGINNING = 200_000  # characters from which the layout is guessed
_LINES = 400  # most lines above the values
_SEPARATORS = ("\t", ";", ",", "|", " ")
_MARKS = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))
_OLD = ("cp1252", "cp932", "cp1251", "koi8-r", "gbk", "euc_jp", "big5")
"""Encodings of files that are not in UTF-8; cp932 is that of Shift-JIS on Windows."""
_BINARY = {
    b"PK\x03\x04": "a .zip, .xlsx or .ods file",
    b"\x1f\x8b": "a .gz file",
    b"BZh": "a .bz2 file",
    b"\xfd7zXZ": "an .xz file",
    b"PAR1": "a .parquet file",
    b"ARROW1": "a .feather file",
    b"\x89HDF": "an .h5 file",
    b"MATLAB 5.0 MAT": "a .mat file",
    b"MATLAB 7.3 MAT": "a .mat file",
    b"\xd0\xcf\x11\xe0": "an .xls file",
    b"TDSm": "a .tdms file",
    b"MDF  ": "an .mf4 file",
    b"\x89MCAP": "an .mcap file",
    b"SQLite format 3": "a .db3 file",
    b"\x93NUMPY": "an .npy file",
}
_UNITS_LABEL = re.compile(r"(?:\w*[ _])?(?:units?|einheit(?:en)?)(?:[ _]\w*)?:?", re.IGNORECASE)
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
        Decimal mark, a point or a comma; where fields are separated by commas too, a number is two of them.
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
        if not known or self.separator in '\r\n\0"' or self.separator == ".":
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
        """Headers in the first lines of a file; a line of units is joined to them as ``name [unit]``.

        It stands below the names, or above them. A header that occurs more than once is numbered.
        """
        if not self.named:
            count = len(fields(lines[self.skipped].rstrip(self.separator), self.separator))
            return tuple(f"column {i + 1}" for i in range(count))
        width = len(fields("".join(lines[self.skipped :][:1]), self.separator))
        names = names_in(lines[self.above], self.separator, width)
        below = [line for line in lines[self.above + 1 : self.skipped] if line.strip(f"{self.separator} ")]
        others = [
            texts
            for line in [*below, *lines[: self.above][-1:]]
            if not numbers_columns(texts := names_in(line, self.separator, width))
        ]
        # A line that is called units goes first, then one that holds units, then the only line below the names.
        written = next(
            (line for line in others if are_units(line)), others[0] if len(below) == 1 and others else []
        )
        written = next(filter(None, map(self._labelled_units, reversed(lines[: self.above]))), written)
        units = [*(text.strip().strip("[]()") for text in written), *[""] * len(names)][: len(names)]
        pairs = list(zip(names, units, strict=True))
        repeated = [pair[0] and pairs.count(pair) > 1 for pair in pairs]
        numbers = [
            f" ({pairs[: i + 1].count(pairs[i])})" if again else "" for i, again in enumerate(repeated)
        ]
        columns = zip(pairs, numbers, strict=True)
        return tuple(
            f"{name}{number} [{unit}]" if unit else f"{name}{number}" for (name, unit), number in columns
        )

    def _labelled_units(self, line: str) -> list[str]:
        """Units in a line above the header that says so in its first field; none in others."""
        label, *units = fields(line, self.separator) or [""]
        return ["", *units] if _UNITS_LABEL.fullmatch(label.strip()) and are_units(units) else []


def first_lines(path: Path, encoding: str) -> list[str]:
    """The first lines of a text file; LogError if the text has another encoding."""
    with path.open("rb") as file:
        return lines_of(path, file.read(4 * _BEGINNING), encoding)


def lines_of(path: Path, content: bytes, encoding: str) -> list[str]:
    """The first lines of the bytes of a text file; errors as those of `first_lines`."""
    kind = next((kind for begin, kind in _BINARY.items() if content.startswith(begin)), None)
    if kind:
        raise LogError(f"{path}: is not text but {kind}: give it that suffix")
    if content[:200].lstrip().lower().startswith((b"<!doctype html", b"<html", b"<table", b"<?xml")):
        raise LogError(f"{path}: holds a page of HTML or XML: export it as CSV")
    if not content.strip():
        raise LogError(f"{path}: is empty: give a file with a header and samples")
    try:
        text = codecs.getincrementaldecoder(encoding)().decode(content[: 4 * _BEGINNING])[:_BEGINNING]
    except UnicodeError as error:
        raise LogError(
            f"{path}: is not text in {encoding}: give its `encoding`, or a file that symid reads"
        ) from error
    return [line.rstrip("\r\n") for line in io.StringIO(text, newline="")][:_LINES]


def guessed_layout(path: Path, encoding: str | None = None) -> Layout:
    """The layout that a CSV file seems to have, in a given encoding or the one that it seems to have.

    The values begin where at least five lines in a row hold equally many numbers and nothing else, or, if there is no
    such place, where columns of numbers beside columns of texts begin. The separator is that of most columns.

    Raises
    ------
    LogError
        If no separator gives columns of numbers.
    """
    with path.open("rb") as file:
        return layout_of_text(path, file.read(4 * _BEGINNING), encoding)


def layout_of_text(path: Path, content: bytes, encoding: str | None = None) -> Layout:
    """The layout that the bytes of a text file seem to have; errors as those of `guessed_layout`.

    Text that is not UTF-8 is read in the first encoding in which most names are known words.
    """
    seems = Layout(encoding).encoding if encoding else encoding_of(content[:_BEGINNING])
    if encoding or seems != _OLD[0]:
        return _layout_in(path, content, seems)
    layouts, faults = [], []
    for codec in _OLD:
        try:
            layout = _layout_in(path, content, codec)
        except LogError as error:
            faults.append(error)
            continue
        names = layout.headers(lines_of(path, content, codec))
        layouts.append((sum(_is_known(split_header(name)[0]) for name in names), layout))
    if not layouts:
        raise faults[0]
    return max(layouts, key=lambda codec: codec[0])[1]


def _is_known(name: str) -> bool:
    """Whether a word, not a single letter, names a quantity: a wrong encoding leaves single letters between symbols."""
    _, word = next(named(words_of(name)), (None, ""))
    return len(word) > 1


def _layout_in(path: Path, content: bytes, encoding: str) -> Layout:
    lines = lines_of(path, content, encoding)
    for beside_texts in (False, True):
        candidates = [
            layout
            for separator in _SEPARATORS
            if (layout := _with_separator(lines, encoding, separator, beside_texts=beside_texts))
        ]
        if candidates:
            return max(candidates, key=lambda one: one[0])[1]
    if pairs := may_be_pairs(lines):
        raise LogError(
            f"{path}: {pairs}: its decimal marks seem to be commas as well, and some numbers lack their fraction, so "
            "that decimal commas and separators look alike: export it with semicolons between columns, or with decimal "
            "points"
        )
    few = max((values_in(lines, separator, 1) or (0, 0) for separator in _SEPARATORS), default=(0, 0))
    if few[0] > 1:
        raise LogError(
            f"{path}: has fewer than {LEAST_ROWS} consecutive rows of numbers: give a log with samples"
        )
    raise LogError(
        f"{path}: has no columns of numbers below a line of names: export it as CSV with one line of names"
    )


def _with_separator(
    lines: Sequence[str], encoding: str, separator: str, *, beside_texts: bool
) -> tuple[int, Layout] | None:
    """Columns of a table with this separator, and its layout; None if there is no such table."""
    run = values_in(lines, separator, beside_texts=beside_texts)
    if run is None:
        return None
    width, begin = run
    fraction = r"\d\.\d" if separator == "," else r"\d[.,]\d"  # below whole numbers that are no sample
    # Whole numbers 1, 2, 3 above numbers with decimals number the columns.
    numbered = numbers_columns([text.strip() for text in fields(lines[begin], separator)])
    numbered = numbered and re.search(fraction, lines[begin + 1]) is not None
    begin += numbered
    header = names_above(lines[:begin], separator, width)
    # Without names for all fields, there may be half as many: each number is then two fields, with a decimal comma.
    names = fields(lines[begin - 1], separator) if header is None and begin and separator == "," else []
    if names and are_pairs([line for line in lines[begin:-1] if line.strip()], len(names)):
        header, decimal = names_above(lines[:begin], separator, len(names)), ","
        if header is not None:
            return len(names), Layout(encoding, separator, decimal, header, begin - header - 1)
        return None
    decimal = "," if separator != "," and has_decimal_comma(lines[begin:], separator) else "."
    if header is not None:
        return width, Layout(encoding, separator, decimal, header, begin - header - 1)
    if begin == 0 or numbered or sum(bool(text.strip()) for text in fields(lines[begin - 1], separator)) < 2:
        return width, Layout(encoding, separator, decimal, begin, named=False)
    return None


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
        return _OLD[0]
    return "utf-8-sig"


def without_footer(text: str, separator: str) -> str:
    r"""Lines of values without those below them that begin with a word, such as ``EOF``, ``Samples: 2`` and ``Max``.

    >>> without_footer("0;1,5\n1;2,5\n\nSamples: 2", ";")
    '0;1,5\n1;2,5'
    """
    first = fields(text.split("\n", 1)[0], separator)
    width, comma = len(first), separator != ","
    is_timed = bool(first) and is_number_text(first[0].strip(), comma=comma)
    while True:
        text = text.rstrip("\n")
        above, _, last = text.rpartition("\n")
        filled = [part.strip() for part in fields(last, separator) if part.strip()]
        is_remark = 0 < len(filled) < width or (is_timed and filled and filled[0][0].isalpha())
        if not is_remark or is_number_text(filled[0], comma=comma):
            return text
        text = above


def has_decimal_comma(lines: Sequence[str], separator: str) -> bool:
    """Whether lines hold numbers such as 1,5."""
    return any(_COMMA_NUMBER.fullmatch(text.strip()) for line in lines for text in fields(line, separator))
