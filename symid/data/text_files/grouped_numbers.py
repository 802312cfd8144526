"""Numbers whose thousands are separated: 1,234.5 and 1.234,5 and 1 234,5.

One column has one decimal mark. It is the mark that stands last in a number with both, or the one that does not always
stand before three digits.
"""

import re
from collections.abc import Sequence

_SPACES = re.compile("(?<=\\d)[ '\u2019\u00a0\u202f](?=\\d{3})")
_GROUPED = re.compile(r"[-+]?[1-9]\d{0,2}(?:[.,]\d{3})+")
_NUMBER = re.compile(r"[-+]?[\d.,]*\d[\d.,]*(?:[eE][-+]?\d+)?")


def without_groups(texts: Sequence[str], decimal: str = "") -> list[str] | None:
    """Texts of a column with a point as decimal mark and no marks of thousands; None if that is not certain.

    `decimal` is the decimal mark, if that is known.

    >>> without_groups(["1.234,5", "-12", "1.000"]), without_groups(["1,234.5"]), without_groups(["1 234,5", ""])
    (['1234.5', '-12', '1000'], ['1234.5'], ['1234.5', ''])

    A single mark before three digits may be either.

    >>> without_groups(["1,234", "2,345"]), without_groups(["1,234", "2,345"], ".")
    (None, ['1234', '2345'])
    """
    plain = [_SPACES.sub("", text) for text in texts]
    if not all(_NUMBER.fullmatch(text) for text in plain if text):
        return None
    decimals = {mark for text in plain if (mark := _decimal_mark(text))} or {decimal} - {""}
    if len(decimals) != 1:
        return plain if plain != list(texts) and not any("," in text for text in plain) else None
    decimal = decimals.pop()
    group = "," if decimal == "." else "."
    if not all(_GROUPED.fullmatch(text.partition(decimal)[0]) for text in plain if group in text):
        return None
    return [text.replace(group, "").replace(decimal, ".") for text in plain]


def is_grouped(text: str) -> bool:
    """Whether a text is a number with marks of thousands or a decimal comma.

    >>> is_grouped("1.234,5"), is_grouped("1 234"), is_grouped("12 34"), is_grouped("1.5")
    (True, True, False, False)
    """
    return any(without_groups([text], decimal) not in (None, [text]) for decimal in ".,")


def _decimal_mark(text: str) -> str:
    """The mark that must be the decimal one in a number; empty if it has none, or one that may separate thousands."""
    marks = [mark for mark in text if mark in ".,"]
    if len(set(marks)) == 2:
        return marks[-1]
    if len(marks) == 1:
        return "" if _GROUPED.fullmatch(text) else marks[0]
    return ("," if marks[0] == "." else ".") if marks else ""
