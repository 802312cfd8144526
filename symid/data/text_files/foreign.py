"""Guesses about the columns of a foreign log: quantity, unit and part, each with its reason."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from typing import Final

import numpy as np

from symid.arrays import FloatArray
from symid.data.quality.coarse_clock import change_between, is_coarse, period_of_rows
from symid.data.table import Table
from symid.data.text_files.clock_columns import counts_up, rises_evenly, rises_unevenly, step_of_clock
from symid.data.text_files.column_names import is_in_doubt, match, measured_in, named, split_header, words_of
from symid.data.text_files.column_words import (
    CLOCKS_NAMED,
    COUNTS,
    DIFFERENCE,
    IN_TURNS,
    NUMBERS,
    SETPOINT,
    TORQUE,
    Quantity,
)
from symid.data.text_files.foreign_column import ForeignColumn
from symid.data.text_files.unit_by_motion import PositionOrVelocity, unit_by_motion
from symid.units import to_si

_SIGN_BITS: Final = (10, 11, 15)
_REGISTERS: Final = (8, 16, 32)  # bits
_MOST_OF_BIT, _CHANGES = 0.75, 3
"""Largest magnitude as a share of the sign bit's value, and fewest changes of sign, to take the bit as a sign; more
values than these make a part of the numbers."""
_NUMBERED: Final = "it numbers the samples"
_COUNTED: Final = "it rises by 1: numbers of samples, or ms"
LONGEST_STROKE: Final = (
    10.0  # m: a position that covers more is in a smaller unit, and one of more mm in counts
)
_MOST_TURNS: Final = 1e3
_MOST_WHOLE: Final = 10.0  # range of whole numbers above which rounding of SI is no cause of them
_ENCODER: Final = "enc(?:oder)?"


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
    columns_found = {
        i: ForeignColumn(table.headers[i], "time", "s", False, clocks[i], True)
        if i in clocks
        else described_column(table.headers[i], column)
        for i, column in finite.items()
    }
    if not any(column.quantity == "time" for column in columns_found.values()):
        unknown = (i for i, c in columns_found.items() if c.quantity is None and c.unit is None)
        if (i := next((i for i in unknown if rises_unevenly(finite[i])), None)) is not None:
            columns_found[i] = _uneven_clock(table.headers[i], finite[i])
    for i, column in columns_found.items():
        if column.quantity != "time" or not is_coarse(finite[i]):
            continue
        if any(change_between(finite[j], finite[i]) for j in columns_found if j != i):
            columns_found[i] = replace(column, coarse=True, row_period=period_of_rows(finite[i]))
        else:
            why = f"{column.reason}; rows of one time are equal: remove the repeated rows"
            columns_found[i] = replace(column, reason=why)
    return tuple({**columns_found, **_by_motion(columns_found, finite)}.values())


def _by_motion(
    columns: Mapping[int, ForeignColumn], values: Mapping[int, FloatArray]
) -> dict[int, ForeignColumn]:
    """Measured positions and velocities without a stated unit, with the one that follows from their rates."""
    times = [(i, column.unit) for i, column in columns.items() if column.quantity == "time" and column.unit]
    if not times:
        return {}
    clock, unit = times[0]
    time, identified = values[clock] * to_si(unit), dict[int, ForeignColumn]()
    pairs: tuple[tuple[PositionOrVelocity, PositionOrVelocity], ...] = (
        ("velocity", "position"),
        ("position", "velocity"),
    )
    for known, wanted in pairs:
        of_known = [
            i for i, c in columns.items() if c.quantity == known and c.stated and not c.setpoint and c.unit
        ]
        lacking = [i for i, c in columns.items() if c.quantity == wanted and not (c.stated or c.setpoint)]
        # Each column without a unit is compared with each column of the other quantity that has one; the first match
        # decides.
        for i, j in product(lacking, of_known):
            if i in identified or not values[i].size == values[j].size == time.size:
                continue
            place, speed = (i, j) if wanted == "position" else (j, i)
            read = unit_by_motion(values[place], values[speed], time, known, columns[j].unit or "")
            if read is not None:
                moves = "its rate is" if wanted == "position" else "it is the rate of"
                why = f"{moves} what column {columns[j].header!r} reads in {columns[j].unit}"
                identified[i] = replace(columns[i], unit=read, scaled=False, reason=why)
    return identified


def described_column(header: str, values: FloatArray) -> ForeignColumn:
    """Quantity and unit of a column as guessed from its header and finite values, with remarks."""
    if not values.size:
        return replace(_guessed(header, np.zeros(1)), constant=True)
    guessed = _guessed(header, values)
    extent = float(values.min()), float(values.max())
    if guessed.quantity is None and not guessed.unit:
        guessed = replace(guessed, reason=f"{guessed.reason}; {extent[0]:.4g} to {extent[1]:.4g}")
    is_constant = extent[0] == extent[1]
    return replace(guessed, doubt=_sign_and_magnitude(values), constant=is_constant, extent=extent)


def _guessed(header: str, values: FloatArray) -> ForeignColumn:
    # The evidence in order: an unambiguous unit, a word of the name with the unit or the values, the values alone.
    name, written = split_header(header)
    words = words_of(name)
    setpoint = match(words, SETPOINT) is not None
    quantity, unit = measured_in(written)
    if quantity == "time" and next(named(words), ("time", ""))[0] != "time":  # the end of an unknown unit
        written = quantity = unit = None
    if (difference := match(words, DIFFERENCE)) is not None:
        why = f"{difference!r} in its name: the difference of two signals"
        return ForeignColumn(header, None, unit, False, why, unit is not None)
    by_words, _ = next(named(words), (None, ""))
    if written and by_words and (doubt := is_in_doubt(header, written, by_words)):
        return ForeignColumn(header, by_words, None, setpoint, doubt, False, scaled=True)
    if quantity is not None and quantity != "percent":
        return ForeignColumn(header, quantity, unit, setpoint, f"its unit is stated: {written}", True)
    is_even = not setpoint and rises_evenly(values)
    if (
        written
        and match([written.partition("/")[0].lstrip("0123456789., ")], COUNTS)
        and not match(words, NUMBERS)
    ):
        counted = by_words or "position"
        why = f"its unit is {written}, of unknown {'length' if counted == 'position' else 'size'}"
        return ForeignColumn(header, counted, None, setpoint, why, False, scaled=True)
    if written and quantity is None:  # what is in brackets, or below, may be the name
        words += words_of(written)
    for by_name, word in named(words):
        if by_name == "position" and is_even:  # no measured position does
            continue
        if quantity == "percent":
            why = f"{word!r} in percent: of a rated value"
            return ForeignColumn(header, "percent", unit, setpoint, why, True)
        return _without_unit(header, by_name, word, setpoint, values, written)
    numbered = match(words, NUMBERS) is not None
    if numbered and is_even:
        return ForeignColumn(header, None, None, setpoint, _NUMBERED, False)
    if is_even and counts_up(values):
        return ForeignColumn(header, "time", None, setpoint, _COUNTED, False)
    if is_even:
        return _without_unit(header, "time", "rises in equal steps", setpoint, values, written)
    quantity, unit = measured_in(header)
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
        parts = [np.unique(values[side]) for side in (~negative, negative)]
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
        largest = [float(sizes[side].max(initial=0.0)) for side in (sign, ~sign)]
        changes = np.count_nonzero(np.diff(sign))
        if min(largest) > 0.3 * max(largest) and max(largest) < _MOST_OF_BIT * 2**bit and changes >= _CHANGES:
            return (
                f"0 to {largest[1]:.0f} and {2**bit} to {2**bit + largest[0]:.0f} look like sign and magnitude "
                f"with the sign in bit {bit}: write negative numbers"
            )
    return ""


def _uneven_clock(header: str, values: FloatArray) -> ForeignColumn:
    """A column without a name of the time that may be one; whole numbers that rise by 1 may number samples instead."""
    if match(words_of(header), NUMBERS):
        return ForeignColumn(header, None, None, False, _NUMBERED, False)
    if counts_up(values):
        return ForeignColumn(header, "time", None, False, _COUNTED, False)
    column = _without_unit(header, "time", "always rises", False, values, None)
    return column if column.unit else replace(column, quantity=None)


def _without_unit(
    header: str, quantity: Quantity, word: str, setpoint: bool, values: FloatArray, written: str | None
) -> ForeignColumn:
    """A column identified by its name; its unit is guessed from its values where possible."""
    evidence = f"{word!r} in its name" if word in header else f"it {word}"
    if quantity == "time":
        step, unit = step_of_clock(values, [u for u, words in CLOCKS_NAMED.items() if match([word], words)])
        if unit:
            reason = f"{evidence}; steps of {step:g} are a plausible sampling period in {unit}"
            return ForeignColumn(header, "time", unit, setpoint, reason, False)
        fits = f"steps of {step:g} fit no unit" if step else "it does not rise from row to row"
        return ForeignColumn(header, "time", None, setpoint, f"{evidence}; {fits}", False)
    if quantity in ("position", "velocity") and not written and IN_TURNS.search(header):
        reason = f"{evidence}; {header!r} is a name of ODrive, which counts turns"
        if np.all(values % 1 == 0) or np.ptp(values) > _MOST_TURNS:
            reason = f"{reason}, or counts in early versions"
            return ForeignColumn(header, quantity, None, setpoint, reason, False, scaled=True)
        unit = "turn" if quantity == "position" else "turn/s"
        return ForeignColumn(header, quantity, unit, setpoint, reason, False)
    if quantity == "position" and np.ptp(values) > LONGEST_STROKE:
        reason = f"{evidence}; a stroke of {np.ptp(values):.3g} is too long for metres"
        is_whole = bool(np.all(values % 1 == 0))
        if written or is_whole or match([word], _ENCODER) or np.ptp(values) > 1e3 * LONGEST_STROKE:
            counts = "whole numbers may be counts" if is_whole else "it may be in counts"
            what = f"{written!r} is not a unit" if written else counts
            return ForeignColumn(header, "position", None, setpoint, f"{reason}; {what}", False, scaled=True)
        return ForeignColumn(header, "position", "mm", setpoint, reason, False)
    if header.endswith("]") and written not in (None, "-"):
        why = f"{evidence}; {written!r} is not a unit"
        return ForeignColumn(header, quantity, None, setpoint, why, False, scaled=True)
    if quantity != "command" and np.ptp(values) > _MOST_WHOLE and np.all(values % 1 == 0):
        why = f"{evidence}; no unit, and whole numbers may be counts"
        return ForeignColumn(header, quantity, None, setpoint, why, False, scaled=True)
    lacking = f"{written!r} is not a unit" if written else "no unit"
    follows = "of unknown size" if quantity == "command" or match([word], TORQUE) else "so SI is assumed"
    return ForeignColumn(header, quantity, None, setpoint, f"{evidence}; {lacking}, {follows}", False)
