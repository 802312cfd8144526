"""Name and unit of a column as its header writes them, and the words of its name."""

import re
from collections.abc import Iterator, Sequence
from itertools import product
from typing import Final

from symid.data.text_files.column_words import COUNTS, EFFORTS, SPELLED, UNITS, WEIGHTS, WORDS, Quantity
from symid.errors import LogError
from symid.units import UNIT_NAMES, Unit, to_si

_BRACKETS: Final = re.compile(r"(?P<name>.*?)\s*[\[(](?P<unit>[^\]):]*)[\])]\s*")
_MOTION: Final = r"(?:[nmcuµμ]?m|m?rad|deg|°|м|мм|мкм|рад|град)(?:[/_][sс](?:\^?2|²)?)?"
_TRAILING: Final = re.compile(
    rf"(?P<name>.*?\S)(?:,? |[_/])(?:in )?(?P<unit>{_MOTION}|[mµuμn]?s|[mu]?sec|rpm|rps|об/мин|%|‰|"
    r"(?:[mk]|da)?N|[mk]?Nm|[mµuμ]?A|[mk]?V|counts|cts|inc|qc|pct|percent|permille|мс|с|кН|Н|Нм|А|В)"
)
_JOINT: Final = re.compile(r"[\s_,/]+")
_PER_CENT: Final = re.compile(r"(?P<size>\d+[.,]?\d*)?\s*%")
_NO_COUNT: Final = "step"  # a step of the position is a movement
_SINGLE: Final = "gGmsh"  # letters that are a unit; others, such as U, name an axis or a phase


def split_header(header: str) -> tuple[str, str | None]:
    """Name and unit of a foreign header; a number in brackets is that of an axis or channel.

    If the name ends with a unit of the quantity that it names, this is its unit, whatever else it may mean.

    >>> split_header("Time (ms)"), split_header("Torque %"), split_header("data(:,1)"), split_header("load (4)")
    (('Time', 'ms'), ('Torque', '%'), ('data(:,1)', None), ('load (4)', None))
    >>> split_header("vel_rad_s"), split_header("iq_mA"), split_header("Speed mm/s"), split_header("dq_rad_s")
    (('vel', 'rad/s'), ('iq', 'mA'), ('Speed', 'mm/s'), ('dq', 'rad/s'))
    >>> split_header("acc_g"), split_header("pos_inch"), split_header("FORCE_KN"), split_header("torque_N_mm")
    (('acc', 'g'), ('pos', 'inch'), ('FORCE', 'kN'), ('torque', 'N*mm'))
    """
    match = _BRACKETS.fullmatch(header)
    if match is None and (found := _unit_at_end(header)):
        return found
    if match is None and (match := _TRAILING.fullmatch(header)):
        return match["name"], match["unit"].replace("_", "/")
    if match is None or match["unit"].strip().isdecimal():
        return header, None
    return match["name"], match["unit"].strip()


def is_in_doubt(header: str, unit: str, quantity: Quantity) -> str:
    """Second meaning of the unit at the end of a name, for which the user is asked; empty without one.

    >>> is_in_doubt("pos_in", "in", "position"), is_in_doubt("pos [in]", "in", "position")
    ("'in' at the end of its name may be inches or an input", '')
    """
    if _BRACKETS.fullmatch(header):
        return ""
    if quantity == "position" and unit.lower() == "in":
        return f"{unit!r} at the end of its name may be inches or an input"
    if quantity in EFFORTS and unit.lower() in WEIGHTS:
        return f"{unit!r} at the end of its name is a mass, or the force that it weighs"
    of_quantity = {to_si(name) for name in _in_capitals(unit, quantity)}
    return f"{unit!r} at the end of its name stands for several units" if len(of_quantity) > 1 else ""


def _unit_at_end(header: str) -> tuple[str, str] | None:
    """Name and unit, if the header ends with a unit of the quantity that its other words name."""
    for joint in _JOINT.finditer(header):
        name, end = header[: joint.start()].removesuffix(" in"), header[joint.end() :]
        quantity, _ = next(named(words_of(name)), (None, ""))
        if quantity is None or not end:
            continue
        mark = "*" if quantity in EFFORTS else "/"
        end = re.sub(r"_(?:per|p)_", "/", end).replace("_", mark)
        counted = end.partition("/")[0]
        if match([counted], COUNTS) and counted.lower() != _NO_COUNT:
            return name, end
        if is_in_doubt(header, end, quantity):
            return name, end
        if len(end) > 1 or end in _SINGLE:
            written = next(iter(_in_capitals(end, quantity)), end)
            if _measures(written, quantity):
                return name, written
    return None


def _in_capitals(written: str, quantity: Quantity) -> list[str]:
    """Units of a quantity that are `written` in capitals.

    >>> _in_capitals("MM/S", "velocity"), _in_capitals("MN", "force")
    (['mm/s'], ['mN', 'MN'])
    """
    if len(written) < 2 or not written.isupper():
        return []
    parts = [_FOLDED.get(part, [part]) for part in re.split(r"([/*])", written)]
    return [unit for chosen in product(*parts) if _measures(unit := "".join(chosen), quantity)]


def _measures(written: str, quantity: Quantity) -> bool:
    known, _ = measured_in(written)
    return known is not None and (known == quantity or {known, quantity} <= set(EFFORTS))


def words_of(name: str) -> list[str]:
    """Words of a name, without numbers at their ends."""
    words = re.split(r"[\W_]+|(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z]{2})", name)
    return [word if len(bare := word.rstrip("0123456789")) < 2 else bare for word in words if word]


def named(words: Sequence[str]) -> Iterator[tuple[Quantity, str]]:
    """Quantities by the words of a name; single letters, which may be the type of a variable, count least."""
    for letters in (False, True):
        words_alone = [word for word in words if (len(word) == 1) is letters]
        for quantity, pattern in WORDS:
            word = match(words_alone, pattern)
            if word is not None:
                yield quantity, word


def match(words: Sequence[str], pattern: str) -> str | None:
    """The first word of a pattern."""
    return next((word for word in words if re.fullmatch(pattern, word, re.IGNORECASE)), None)


def measured_in(written: str | None) -> tuple[Quantity | None, str | None]:
    """Quantity that a unit measures, and the unit as `to_si` reads it."""
    if not written:
        return None, None
    written = SPELLED.get(written, written)
    if (share := _PER_CENT.search(written.replace("‰", "0.1 %"))) is not None:
        return "percent", f"{share['size'].replace(',', '.')} %" if share["size"] else "%"
    unit = written.replace("²", "^2").replace("°", "deg")
    for quantity, names in UNITS:
        for name in names:
            try:
                to_si(unit, Unit.of(name))
            except LogError:
                continue
            return quantity, unit
    return None, None


def _folded() -> dict[str, list[str]]:
    folded: dict[str, list[str]] = {}
    for name in UNIT_NAMES:
        folded.setdefault(name.upper(), []).append(name)
    return folded


_FOLDED: Final = _folded()
"""Names of units by their capitals."""
