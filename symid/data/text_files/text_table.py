"""Lines of a text file as a table: where its values begin, which line names them, and which one holds their units."""

import csv
import re
from collections import Counter
from collections.abc import Sequence
from itertools import zip_longest
from typing import Final

from symid.data.text_files.grouped_numbers import is_grouped
from symid.data.text_files.time_stamps import is_stamp
from symid.errors import LogError
from symid.units import COUNT_UNITS, to_si

LEAST_ROWS: Final = 5
"""Adjacent lines with the same fields that make a table."""
_MOST_NAMES: Final = 3
"""Lines of names, units and remarks directly above the values."""
_MOST_ABOVE: Final = 6
"""Lines among which these are, with those that are empty or number the columns."""
_COMMENT: Final = re.compile(r"\s*(#+|%+|//+)\s*")
_UNIT_APART: Final = re.compile(r"(?<=\w)\s+(?=[\[(])")
_APART: Final = re.compile(r"\s{2,}|\t")
FORTRAN: Final = re.compile(r"^([-+]?\d*\.?\d+|[-+]?\d+\.)[dD]([-+]?\d+)$")
"""A number as Fortran writes it, with D before its exponent."""
_NUMBER_WITH_UNIT: Final = re.compile(r"([-+]?[.,]*+\d[\d.,]*+(?:[eE][-+]?\d+)?)\s*([^\W\d_][^\s\d]*|[°%])")
_NO_UNIT: Final = ("", "-", "--", "%", "[]", "none", "None")
_BRACKETS: Final = re.compile(r".*[\w.]\s*[\[(]([^\]):]+)[\])]\s*")


def uncommented(line: str) -> str:
    """A line without the mark of a comment at its beginning, as programs write it before names.

    >>> uncommented("# t q F"), uncommented("%time,q")
    ('t q F', 'time,q')
    """
    mark = _COMMENT.match(line)
    return line[mark.end() :] if mark else line


def fields(line: str, separator: str) -> list[str]:
    """Fields of a line; a line with an unclosed quote or an overlong field is one field.

    >>> fields("time [s]  q [mm]", " ")
    ['time[s]', 'q[mm]']
    """
    if separator == " ":
        return _UNIT_APART.sub("", line).split()
    try:
        return next(csv.reader([line], delimiter=separator), [])
    except csv.Error:
        return [line]


def names_in(line: str, separator: str, width: int) -> list[str]:
    """Fields of a line above values of some `width`; between names that hold spaces, columns of spaces have several.

    >>> names_in(" t [ms]   actual X [mm]   I [A]", " ", 3), names_in("t  q F", " ", 3)
    (['t [ms]', 'actual X [mm]', 'I [A]'], ['t', 'q', 'F'])
    """
    bare = uncommented(line)
    names = fields(bare, separator)
    apart = _APART.split(bare.strip()) if separator == " " and len(names) > width else []
    return [text.strip() for text in (apart if len(apart) == width else names)]


def is_number_text(text: str, *, comma: bool) -> bool:
    """Whether a field holds a number, with marks of thousands or without, or a moment, or nothing."""
    plain = FORTRAN.sub(r"\1e\2", text)
    try:
        float(plain.replace(",", ".") if comma else plain)
    except ValueError:
        number, unit = split_cell(text)
        return text == "" or is_stamp(text) or is_grouped(number) or bool(unit)
    return True


def split_cell(text: str) -> tuple[str, str]:
    """Number and unit of a field; the unit is empty unless the field is a number followed by a unit.

    >>> split_cell("1.5 mm"), split_cell("-3kN"), split_cell("12 %"), split_cell("7"), split_cell("3 axes")
    (('1.5', 'mm'), ('-3', 'kN'), ('12', '%'), ('7', ''), ('3 axes', ''))
    """
    match = _NUMBER_WITH_UNIT.fullmatch(text)
    return (match[1], match[2]) if match and (_is_unit(match[2]) or match[2] == "%") else (text, "")


def with_units(headers: Sequence[str], row: Sequence[str]) -> tuple[str, ...]:
    """Headers with the units of the fields of the first row of values, where they have none in brackets.

    >>> with_units(["t", "q [mm]", "F"], ["0 s", "1 mm", "2"])
    ('t [s]', 'q [mm]', 'F')
    """
    joined = []
    for header, text in zip_longest(headers, row[: len(headers)], fillvalue=""):
        unit, named = split_cell(text.strip(" \t\"'"))[1], _BRACKETS.fullmatch(header)
        if unit and named and named[1].strip() != unit:
            raise LogError(f"column {header!r} holds numbers in {unit}: correct its name")
        joined.append(f"{header} [{unit}]" if header and unit and not named else header)
    return tuple(joined)


def values_in(
    lines: Sequence[str], separator: str, least: int = LEAST_ROWS, *, beside_texts: bool = False
) -> tuple[int, int] | None:
    """Number of columns of the values, and their first line; None if fewer than `least` lines hold any.

    A table holds numbers alone, or columns of texts `beside` its numbers: then it reaches to the last line with as
    many fields, and its numbers stand in the same columns of each.
    """
    rows = [[text.strip() for text in fields(line, separator)] for line in lines]
    if not beside_texts:
        widths = [_widths(row, separator) for row in rows]
        for begin in range(len(widths) - least + 1):
            run = widths[begin : begin + least]
            width = max(filled for _, filled in run)
            if width > 1 and min(filled for _, filled in run) and len({whole for whole, _ in run}) == 1:
                return width, begin
        return None
    # The last lines of the table decide which columns hold numbers; from there it grows upwards while they do.
    usual, count = Counter(map(len, rows)).most_common(1)[0] if rows else (0, 0)
    end = max((place for place, row in enumerate(rows, 1) if len(row) == usual), default=0)
    last = [_are_numbers(row, separator) for row in rows[max(end - least, 0) : end] if len(row) == usual]
    numeric = [place for place in range(usual) if all(row[place] for row in last)]
    numeric = [place for place in numeric if any(row[place] for row in rows[end - len(last) : end])]
    if count < least or len(last) < least or len(numeric) < 2:
        return None
    begin = end
    while begin and len(rows[begin - 1]) == usual:
        are_numbers = _are_numbers(rows[begin - 1], separator)
        if not all(are_numbers[place] for place in numeric):
            break
        begin -= 1
    return usual, begin


def _are_numbers(row: Sequence[str], separator: str) -> list[bool]:
    return [is_number_text(text, comma=separator != ",") for text in row]


def _widths(row: Sequence[str], separator: str) -> tuple[int, int]:
    """Fields of a line of numbers, all and those up to the last that is not blank; 0 if one is anything else.

    A blank one at the end is a separator too many, or a sample that a slower channel lacks.
    """
    if not all(_are_numbers(row, separator)):
        return 0, 0
    return len(row), max((place for place, text in enumerate(row, 1) if text), default=0)


def names_above(above: Sequence[str], separator: str, width: int) -> int | None:
    """Line of the names of a table among the lines above its values, which empty lines may separate; None without one.

    Of several adjacent lines of texts it is the one above that of the units, or below it. Without units it is the
    nearest if that one has units in brackets, else the upper of the nearest two: the one below it specifies. A line
    with a number holds a property such as the sampling time.
    """
    last = len(above) - 1
    while last >= 0 and not above[last].strip(f"{separator} "):
        last -= 1
    candidates: list[tuple[int, list[str]]] = []
    for place in range(last, max(last - _MOST_ABOVE, -1), -1):
        texts = names_in(above[place], separator, width)
        if numbers_columns(texts) or (not any(texts) and candidates and are_units(candidates[-1][1])):
            continue
        if len(candidates) == _MOST_NAMES:
            break
        numbers = [number for text, number in zip(texts, _are_numbers(texts, separator), strict=True) if text]
        is_whole = len(numbers) >= width - 1 or not candidates
        if len(texts) < width or (separator == " " and len(texts) > width) or not is_whole:
            break
        if not numbers or sum(numbers) > len(numbers) / 2 or (candidates and any(numbers)):
            break
        candidates.append((place, texts))
    return _named_by(candidates)


def numbers_columns(texts: Sequence[str]) -> bool:
    """Whether a line numbers the columns, from 0 or 1.

    >>> numbers_columns(["1", "2", "3"]), numbers_columns(["0", "1.5", "2"]), numbers_columns(["1", "2"])
    (True, False, False)
    """
    counted = [str(place) for place in range(len(texts) + 1)]
    return len(texts) > 2 and list(texts) in (counted[:-1], counted[1:])


def _named_by(lines: Sequence[tuple[int, list[str]]]) -> int | None:
    """Line of the names among adjacent lines of texts, the nearest to the values first."""
    worded = [line for line in lines if any(map(str.isalnum, "".join(line[1])))] or lines
    if not worded:
        return None
    of_units = next((i for i, (_, texts) in enumerate(worded) if are_units(texts)), None)
    if of_units is not None and len(worded) > 1:
        return worded[of_units + 1 if of_units + 1 < len(worded) else of_units - 1][0]
    place, texts = worded[0]
    has_units = any((unit := _BRACKETS.fullmatch(text)) and _is_unit(unit[1]) for text in texts)
    return place if has_units or len(worded) == 1 else worded[1][0]


def are_units(texts: Sequence[str]) -> bool:
    """Whether a line holds units rather than names.

    >>> are_units(["s", "[mm]", "-", "Inkr"]), are_units(["s", "v", "F"])
    (True, False)
    """
    written = [text for text in (text.strip("[]() ") for text in texts) if text not in _NO_UNIT]
    return sum(map(_is_unit, written)) > len(written) / 2


def _is_unit(text: str) -> bool:
    if text in COUNT_UNITS:
        return True
    try:
        to_si(text)
    except LogError:
        return False
    return True
