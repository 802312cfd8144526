"""Text whose fields are separated by commas and whose decimal marks are commas too: each number is two fields."""

import re
from collections.abc import Sequence
from typing import Final

_WHOLE: Final = re.compile(r"[-+]?\d+")
_FRACTION: Final = re.compile(r"\d+(?:[eE][-+]?\d+)?")
_PAIR: Final = re.compile(r"([-+]?\d+),(\d+(?:[eE][-+]?\d+)?)[^\S\n]*(,|$)", re.MULTILINE)


def are_pairs(lines: Sequence[str], n_names: int) -> bool:
    """Whether each number takes two fields, its whole part and its fraction, below the given number of names.

    All lines have twice as many fields as there are names. The fractions of a column have as many digits each, or
    never end in a zero.

    >>> are_pairs(["0,001,1,25", "0,002,-1,50"], 2), are_pairs(["0,001,1,5", "0,002,1,25"], 2)
    (True, True)
    >>> are_pairs(["0,001,1", "0,002,1,25"], 2), are_pairs(["1,10,4,8", "2,9,4,8"], 2)
    (False, False)
    """
    rows = [[text.strip() for text in line.split(",")] for line in lines]
    if not rows or n_names < 1 or any(len(row) != 2 * n_names for row in rows):
        return False
    for whole, fraction in zip(*[iter(zip(*rows, strict=True))] * 2, strict=True):
        if not all(map(_WHOLE.fullmatch, whole)) or not all(map(_FRACTION.fullmatch, fraction)):
            return False
        digits = [re.split("[eE]", text)[0] for text in fraction]
        if len(set(map(len, digits))) > 1 and any(len(text) > 1 and text.endswith("0") for text in digits):
            return False
    return True


def may_be_pairs(lines: Sequence[str]) -> str:
    """Sentence on lines that hold more numbers than names, none with a point; empty for other lines.

    >>> may_be_pairs(["t,q", "0,1", "0,001,1,25", "0,002,1,5", "0,003,1,5", "0,004,2,5"])
    'below 2 names lines have 2 or 4 whole numbers between commas'
    """
    rows = [[text.strip() for text in line.split(",")] for line in lines if line.strip()]
    numbers = [len(row) for row in rows if len(row) > 1 and all(map(_WHOLE.fullmatch, row))]
    names = next((len(row) for row in rows if not any(map(_WHOLE.fullmatch, row)) and len(row) > 1), 0)
    if len(numbers) < 2 or not names or not names < max(numbers) <= 2 * names:
        return ""
    counts = " or ".join(map(str, sorted(set(numbers))))
    return f"below {names} names lines have {counts} whole numbers between commas"


def with_points(text: str) -> str:
    r"""Text with points for the decimal commas.

    >>> with_points("0,001,-1,25\n0,002,1,5E-3")
    '0.001,-1.25\n0.002,1.5E-3'
    """
    return _PAIR.sub(r"\1.\2\3", text)
