"""Text of serial monitors: values beside their names, and a time of day before each line.

The serial plotter of Arduino takes lines such as ``t:120,pos:3.5``; its monitor writes ``10:15:03.120 -> `` before
each.
"""

import re
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Final

from symid.data.table import Table
from symid.data.text_files.csv_table import laid_out
from symid.data.text_files.foreign import quantity_named
from symid.data.text_files.layout import encoding_of, layout_of_text, lines_of
from symid.data.text_files.text_table import LEAST_ROWS
from symid.errors import LogError

_BEGINNING: Final = 200_000  # bytes that show what a text is
_PAIR: Final = re.compile(
    r"(?<!\w)(?P<name>[^\W\d][\w.\[\]]*)\s*[:=]\s*(?P<value>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
    r"(?P<unit>[^\W\d]+)?(?=[\s,;|]|$)"
)
_MOMENT: Final = re.compile(r"\s*\[?(?P<moment>\d{1,2}:\d\d:\d\d[.,]\d+)\]?\s*->\s*")
_ALIKE_SHARE: Final = 0.5  # of the lines, which are alike in such a text


def serial_text_in(path: Path, begin: bytes) -> Callable[[], Table] | None:
    """Reader of a text file that begins as that of a serial monitor; None of others."""
    begin = begin[:_BEGINNING]
    if b"->" not in begin and b":" not in begin and b"=" not in begin:
        return None
    encoding = encoding_of(begin)
    try:
        lines = lines_of(path, begin, encoding)[:-1]
    except LogError:
        return None
    names, prefixed = _names_in(lines), sum(map(bool, map(_MOMENT.match, lines))) > _ALIKE_SHARE * len(lines)
    if len(lines) < LEAST_ROWS or not (names or prefixed):
        return None
    return partial(_open_serial, path, encoding, names, prefixed=prefixed)


def _open_serial(path: Path, encoding: str, names: tuple[str, ...], *, prefixed: bool) -> Table:
    """Table in the text of a serial monitor."""
    text = path.read_bytes().decode(encoding, errors="replace")
    content = _as_table(text.splitlines(), names, prefixed=prefixed).encode()
    layout = layout_of_text(path, content)
    return laid_out(path, layout, lines_of(path, content, layout.encoding), lambda: content)


def _names_in(lines: list[str]) -> tuple[str, ...]:
    """Names of the values in most lines; none where values have none.

    >>> _names_in(["booting", *["t=1 pos=2.5mm"] * 3]), _names_in(["Rate: 9", "1;2", "2;4"])
    (('t', 'pos [mm]'), ())
    """
    alike = Counter(tuple(name for name, _ in _pairs(line)) for line in lines)
    names, count = max(alike.items(), key=lambda item: (len(item[0]) > 1) * item[1], default=((), 0))
    return names if len(names) > 1 and count > _ALIKE_SHARE * len(lines) else ()


def _pairs(line: str) -> list[tuple[str, str]]:
    """Names with units, and values, of a line."""
    matches = _PAIR.finditer(line)
    return [(m["name"] + (f" [{m['unit']}]" if m["unit"] else ""), m["value"]) for m in matches]


def _as_table(lines: list[str], names: tuple[str, ...], *, prefixed: bool) -> str:
    r"""Lines of names and values, separated by commas; moments come last, unless there is a better clock.

    >>> _as_table(["go", "10:15:03.120 -> x:1 y:2", "10:15:03.130 -> x:1.5 y:3"], ("x", "y"), prefixed=True)
    'x,y,moment\n1,2,10:15:03.120\n1.5,3,10:15:03.130'
    """
    timed = prefixed and not any(quantity_named(name) == "time" for name in names)
    rows = [",".join((*names, *["moment"] * timed))] if names else []
    for line in lines:
        moment, pairs = _MOMENT.match(line), _pairs(line)
        last = [moment["moment"]] if moment else []
        if not names and moment:
            rows.append(",".join((line[moment.end() :], *last)))
        elif names and tuple(name for name, _ in pairs) == names and (moment or not timed):
            rows.append(",".join((*(value for _, value in pairs), *last * timed)))
    return "\n".join(rows)
