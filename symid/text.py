"""Text to print: that of foreign origin made safe, such as names of files and columns; counts and names in words."""

import difflib
import re
from collections.abc import Collection, Sequence
from typing import Final

_UNSEEN: Final = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2060-\u2069\ufeff\ud800-\udfff]"
)
"""Control characters except for tab and line feed, marks that reorder or hide text, and lone surrogates."""
_NAMES_OF_PERSONS: Final = ("coulomb", "stribeck")
"""Words of effects that have a capital letter."""


def visible(text: str) -> str:
    r"""Text whose control characters are written out, so that a terminal prints them and obeys none.

    A lone surrogate, by which Python keeps a byte of a file name that is not UTF-8, is written as that byte.

    >>> print(visible("a\x1b[2Jb\udce9"))
    a\x1b[2Jb\xe9
    """
    return _UNSEEN.sub(_written, text)


def _written(match: re.Match[str]) -> str:
    code = ord(match[0])
    if 0xDC80 <= code <= 0xDCFF:
        code -= 0xDC00
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"


def one_line(text: str) -> str:
    r"""Visible text without line ends and double spaces.

    >>> one_line("two\n  lines")
    'two lines'
    """
    return visible(" ".join(text.split()))


def counted(count: int, one: str, many: str = "") -> str:
    """A count and its noun, in the plural where there are several.

    >>> counted(1, "log"), counted(2, "log"), counted(0, "axis", "axes")
    ('1 log', '2 logs', '0 axes')
    """
    return f"{count} {one if count == 1 else many or one + 's'}"


def listed(names: Sequence[str], conjunction: str = "and") -> str:
    """Names in words.

    >>> listed(["Mb", "K1", "K2"]), listed(["Mb", "K1"], "or"), listed(["Mb"])
    ('Mb, K1 and K2', 'Mb or K1', 'Mb')
    """
    *others, last = names
    return f"{', '.join(others)} {conjunction} {last}" if others else last


def spoken(name: str, at: str = "") -> str:
    """The name of an effect or a status in words, with its place if one is given that the name does not contain.

    >>> spoken("stribeck_friction", "motor"), spoken("actuator_lag", "actuator")
    ('Stribeck friction at motor', 'actuator lag')
    """
    words = " ".join(word.title() if word in _NAMES_OF_PERSONS else word for word in name.split("_"))
    return f"{words} at {at}" if at and at not in words.split() else words


def moment(seconds: float, digits: int = 7) -> str:
    """A time of a log, to a millisecond and to some digits: clocks may count from long ago.

    >>> moment(1777.0391), moment(0.97068, 4), moment(1711559473.0624)
    ('1777.039', '0.9707', '1711559473.062')
    """
    return f"{seconds:.{max(digits, len(str(int(abs(seconds)))) + 3)}g}"


def similar(name: str, names: Collection[str]) -> str:
    """Suggestion for a misspelt name, in brackets; empty if no known name is close.

    >>> similar("rigid_1", ["emps", "rigid_1m"]), similar("x", ["emps"])
    (" (did you mean 'rigid_1m'?)", '')
    """
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    return f" (did you mean {close[0]!r}?)" if close else ""
