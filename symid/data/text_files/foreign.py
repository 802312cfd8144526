"""Guesses about the columns of a foreign log: quantity, unit and part, each with its reason."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from symid.arrays import FloatArray
from symid.data.table import Table
from symid.data.text_files.clock_columns import counts_up, rises_evenly, rises_unevenly, step_of_clock
from symid.data.text_files.column_words import (
    CLOCKS_NAMED,
    COUNTS,
    DIFFERENCE,
    NUMBERS,
    SETPOINT,
    SPELLED,
    UNITS,
    WORDS,
    Quantity,
)
from symid.errors import LogError
from symid.units import Unit, to_si

_BRACKETS: Final = re.compile(r"(?P<name>.*?)\s*[\[(](?P<unit>[^\]):]*)[\])]\s*")
_MOTION: Final = r"(?:[nmcuµμ]?m|m?rad|deg|°|м|мм|мкм|рад|град)(?:[/_][sс](?:\^?2|²)?)?"
_TRAILING: Final = re.compile(
    rf"(?P<name>.*?\S)(?:,? |[_/])(?:in )?(?P<unit>{_MOTION}|[mµuμn]?s|[mu]?sec|rpm|rps|об/мин|%|‰|"
    r"(?:[mk]|da)?N|[mk]?Nm|[mµuμ]?A|[mk]?V|counts|cts|inc|qc|pct|percent|permille|мс|с|кН|Н|Нм|А|В)"
)
_SIGN_BITS: Final = (10, 11, 15)
_REGISTERS: Final = (8, 16, 32)  # bits
_MOST_OF_BIT, _CHANGES = 0.75, 3
"""Largest magnitude as a share of the sign bit's value, and fewest changes of sign, to take the bit as a sign; more
values than these make a part of the numbers."""
_NUMBERED: Final = "it numbers the samples"
_COUNTED: Final = "it rises by 1: numbers of samples, or ms"
_PER_CENT: Final = re.compile(r"(?P<size>\d+[.,]?\d*)?\s*%")
_LONGEST_STROKE: Final = 10.0  # m: a position that covers more is in a smaller unit


@dataclass(frozen=True)
class ForeignColumn:
    """A column with its guessed meaning."""

    header: str
    """As written in the file."""
    quantity: Quantity | None
    """Guessed quantity; None without evidence."""
    unit: str | None
    """Unit that `to_si` reads; None where none is known."""
    setpoint: bool
    """Whether it seems to be commanded, not measured."""
    reason: str
    """Reason for the guess."""
    stated: bool
    """Whether the file states the unit; otherwise it is guessed, or unknown."""
    doubt: str = ""
    """Evidence that the values are not numbers of a quantity; empty without such evidence."""
    scaled: bool = False
    """Whether the values cannot be in SI and their unit is unknown, such as counts of an encoder."""
    constant: bool = False
    """Whether all values are equal."""


def foreign_columns(table: Table) -> tuple[ForeignColumn, ...]:
    """Guess what each column of numbers of a table is; columns of anything else are left out.

    Parameters
    ----------
    table : Table
        Table in the file.
    """
    values = table.beginning()
    clocks = dict.fromkeys(
        table.clocks.values(), "it holds the times of other columns, which are read in seconds"
    )
    clocks |= dict.fromkeys(table.stamps, "its values are moments, which are read in seconds")
    finite = {
        i: column[np.isfinite(column)]
        for i, (header, column) in enumerate(zip(table.headers, values, strict=True))
        if not isinstance(column, str) and column.size and header
    }
    found = {
        i: ForeignColumn(table.headers[i], "time", "s", False, clocks[i], True)
        if i in clocks
        else described_column(table.headers[i], column)
        for i, column in finite.items()
    }
    if not any(column.quantity == "time" for column in found.values()):
        unknown = (i for i, c in found.items() if c.quantity is None and c.unit is None)
        if (i := next((i for i in unknown if rises_unevenly(finite[i])), None)) is not None:
            found[i] = _uneven_clock(table.headers[i], finite[i])
    return tuple(found.values())


def described_column(header: str, values: FloatArray) -> ForeignColumn:
    """Quantity and unit of a column as guessed from its header and finite values, with remarks."""
    if not values.size:
        return replace(_guessed(header, np.zeros(1)), constant=True)
    guessed = _guessed(header, values)
    return replace(guessed, doubt=_sign_and_magnitude(values), constant=bool(np.ptp(values) == 0))


def _guessed(header: str, values: FloatArray) -> ForeignColumn:
    name, written = split_header(header)
    words = _words(name)
    setpoint = _match(words, SETPOINT) is not None
    quantity, unit = _measured_in(written)
    if (
        quantity == "time" and next(_named(words), ("time", ""))[0] != "time"
    ):  # the end of a unit, such as in/s
        written = quantity = unit = None
    if (difference := _match(words, DIFFERENCE)) is not None:
        why = f"{difference!r} in its name: the difference of two signals"
        return ForeignColumn(header, None, unit, False, why, unit is not None)
    if quantity is not None and quantity != "percent":
        return ForeignColumn(header, quantity, unit, setpoint, f"its unit is written, {written}", True)
    is_even = not setpoint and rises_evenly(values)
    if written and _match([written], COUNTS) and not _match(words, NUMBERS):
        by_name, _ = next(_named(words), ("position", ""))
        why = f"its unit is {written}, of unknown {'length' if by_name == 'position' else 'size'}"
        return ForeignColumn(header, by_name, None, setpoint, why, False, scaled=True)
    if written and quantity is None:  # what is in brackets, or below, may be the name
        words += _words(written)
    for by_name, word in _named(words):
        if by_name == "position" and is_even:  # no measured position does
            continue
        if quantity == "percent":
            why = f"{word!r} in percent: of a rated value"
            return ForeignColumn(header, "percent", unit, setpoint, why, True)
        return _without_unit(header, by_name, word, setpoint, values, written)
    numbered = _match(words, NUMBERS) is not None
    if numbered and is_even:
        return ForeignColumn(header, None, None, setpoint, _NUMBERED, False)
    if is_even and counts_up(values):
        return ForeignColumn(header, "time", None, setpoint, _COUNTED, False)
    if is_even:
        return _without_unit(header, "time", "rises in equal steps", setpoint, values, written)
    quantity, unit = _measured_in(header)
    if quantity is not None:
        return ForeignColumn(header, quantity, unit, setpoint, "its name is a unit", True)
    why = f"its unit {written!r} is not known" if written else "neither name nor unit identifies it"
    return ForeignColumn(header, None, None, setpoint, why, False)


def quantity_named(header: str) -> Quantity | None:
    """Quantity of a column by its header alone.

    >>> quantity_named("Kraft [N]"), quantity_named("Status")
    ('force', None)
    """
    return _guessed(header, np.zeros(1)).quantity


def with_unit(column: ForeignColumn, unit: str) -> ForeignColumn:
    """A column in a unit that its user gives; LogError if it measures nothing that a log holds."""
    quantity, read = _measured_in(unit)
    if quantity is None:
        to_si(unit)
        raise LogError(
            f"unit {unit!r} is not a unit of any signal of an axis: give one such as ms, mm, rpm, N or A"
        )
    return replace(column, quantity=quantity, unit=read, reason="its unit is given", stated=True)


def _sign_and_magnitude(values: FloatArray) -> str:
    """Remark on a register whose values seem to be sign and magnitude, as those of bus servos are, or unsigned.

    >>> _sign_and_magnitude(np.array([0, 12, 250, 65530, 65236, 65531, 65535, 3]))
    '0 to 250 and 65236 to 65535 look like signed numbers of 16 bits, read as unsigned: write negative numbers'
    >>> load = np.tile([0, 12, 250, 387, 25, 0, 1061, 1299, 1361, 1111], 3)
    >>> _sign_and_magnitude(load)
    '0 to 387 and 1024 to 1361 look like sign and magnitude with the sign in bit 10: write negative numbers'
    >>> _sign_and_magnitude(np.arange(0.0, 2000.0, 50.0))
    ''
    """
    if np.any(values % 1 != 0) or values.min() < 0:
        return ""
    for whole in (2**bits for bits in _REGISTERS):
        negative = values >= whole / 2
        parts = [np.unique(values[own]) for own in (~negative, negative)]
        middle = np.any((values > whole / 4) & (values < 3 * whole / 4))
        if values.max() < whole and not middle and min(part.size for part in parts) > _CHANGES:
            spans = " and ".join(f"{part[0]:.0f} to {part[-1]:.0f}" for part in parts)
            bits = whole.bit_length() - 1
            return (
                f"{spans} look like signed numbers of {bits} bits, read as unsigned: write negative numbers"
            )
    for bit in _SIGN_BITS:
        sign = values >= 2**bit
        sizes = np.where(sign, values - 2**bit, values)
        largest = [float(sizes[own].max(initial=0.0)) for own in (sign, ~sign)]
        changes = np.count_nonzero(np.diff(sign))
        if min(largest) > 0.3 * max(largest) and max(largest) < _MOST_OF_BIT * 2**bit and changes >= _CHANGES:
            return (
                f"0 to {largest[1]:.0f} and {2**bit} to {2**bit + largest[0]:.0f} look like sign and magnitude "
                f"with the sign in bit {bit}: write negative numbers"
            )
    return ""


def _uneven_clock(header: str, values: FloatArray) -> ForeignColumn:
    """A column without a name of the time that may be one; whole numbers that rise by 1 may number samples instead."""
    if _match(_words(header), NUMBERS):
        return ForeignColumn(header, None, None, False, _NUMBERED, False)
    if counts_up(values):
        return ForeignColumn(header, "time", None, False, _COUNTED, False)
    column = _without_unit(header, "time", "always rises", False, values, None)
    return column if column.unit else replace(column, quantity=None)


def split_header(header: str) -> tuple[str, str | None]:
    """Name and unit of a foreign header; a number in brackets is that of an axis or channel.

    >>> split_header("Time (ms)"), split_header("Torque %"), split_header("data(:,1)"), split_header("load (4)")
    (('Time', 'ms'), ('Torque', '%'), ('data(:,1)', None), ('load (4)', None))
    >>> split_header("vel_rad_s"), split_header("iq_mA"), split_header("Speed mm/s")
    (('vel', 'rad/s'), ('iq', 'mA'), ('Speed', 'mm/s'))
    """
    match = _BRACKETS.fullmatch(header) or _TRAILING.fullmatch(header)
    if match is None or match["unit"].strip().isdecimal():
        return header, None
    return match["name"], match["unit"].strip().replace("_", "/")


def _words(name: str) -> list[str]:
    """Words of a name, without numbers at their ends."""
    words = re.split(r"[\W_]+|(?<=[a-z])(?=[A-Z])", name)
    return [word if len(bare := word.rstrip("0123456789")) < 2 else bare for word in words if word]


def _named(words: Sequence[str]) -> Iterator[tuple[Quantity, str]]:
    """Quantities by the words of a name; single letters, which may be the type of a variable, count least."""
    for letters in (False, True):
        own = [word for word in words if (len(word) == 1) is letters]
        for quantity, pattern in WORDS:
            word = _match(own, pattern)
            if word is not None:
                yield quantity, word


def _match(words: Sequence[str], pattern: str) -> str | None:
    return next((word for word in words if re.fullmatch(pattern, word, re.IGNORECASE)), None)


def _measured_in(written: str | None) -> tuple[Quantity | None, str | None]:
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


def _without_unit(
    header: str, quantity: Quantity, word: str, setpoint: bool, values: FloatArray, written: str | None
) -> ForeignColumn:
    """A column identified by its name; its unit is guessed from its values where possible."""
    evidence = f"{word!r} in its name" if word in header else f"it {word}"
    if quantity == "time":
        step, unit = step_of_clock(values, [u for u, words in CLOCKS_NAMED.items() if _match([word], words)])
        if unit:
            reason = f"{evidence}; steps of {step:g} are a plausible sampling period in {unit}"
            return ForeignColumn(header, "time", unit, setpoint, reason, False)
        return ForeignColumn(
            header, "time", None, setpoint, f"{evidence}; steps of {step:g} fit no unit", False
        )
    if quantity == "position" and np.ptp(values) > _LONGEST_STROKE:
        reason = f"{evidence}; a stroke of {np.ptp(values):.3g} is too long for metres"
        if written or np.all(values % 1 == 0):
            what = f"{written!r} is not a unit" if written else "whole numbers may be counts"
            return ForeignColumn(header, "position", None, setpoint, f"{reason}; {what}", False, scaled=True)
        return ForeignColumn(header, "position", "mm", setpoint, reason, False)
    lacking = f"{written!r} is not a unit" if written else "no unit"
    follows = "of unknown size" if quantity == "command" else "so SI is assumed"
    return ForeignColumn(header, quantity, None, setpoint, f"{evidence}; {lacking}, {follows}", False)
