"""Data frames of pandas, polars and pyarrow, and columns by name, as the tables that files are read as."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np
import numpy.typing as npt

from symid.arrays import FloatArray
from symid.data.columns import REFERENCE, TIME, split_unit
from symid.data.quality.clock import Clock, inspect_clock, require_seconds
from symid.data.table import Table, naming_file
from symid.errors import LogError
from symid.units import Unit, to_si

if TYPE_CHECKING:
    from narwhals.stable.v2.typing import IntoFrame

Frame: TypeAlias = "IntoFrame | Mapping[str, npt.ArrayLike]"
"""A data frame of pandas, polars, pyarrow or another library that narwhals knows, or columns by name."""

FRAME_SOURCE: Final = Path("frame")
"""Name of a frame in messages and results."""
_CONTEXTS: Final = tuple(map(Unit.of, ("rad", "rad/s", "rad/s^2", "m/s^2")))
"""Signals whose quantity changes the meaning of some units."""


def table_of(frame: Frame) -> Table:
    """A data frame, or arrays by name, as a table; a column of moments or durations is seconds from its first value.

    An index of pandas that has a name is a column, and one that holds moments the column ``t``. A lazy frame is
    collected. LogError if columns differ in length, or it is not a frame.

    >>> table = table_of({"t": [0.0, 0.1], "q [mm]": [1, 2]})
    >>> table.headers, table.read([1])[0].tolist()
    (('t', 'q [mm]'), [1.0, 2.0])
    """
    columns = _columns_of(frame)
    lengths = {name: np.shape(values)[:1] for name, values in columns.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{name} {size[0] if size else 'a number'}" for name, size in lengths.items())
        raise LogError(
            f"{FRAME_SOURCE}: the columns differ in length ({listed}): give as many samples of each"
        )
    headers = tuple(columns)
    moments = frozenset(place for place, values in enumerate(columns.values()) if _are_times(values))
    return Table(
        headers,
        lambda positions: [_values(columns[headers[position]]) for position in positions],
        stamps=moments,
    )


def uniform(
    frame: Frame,
    *,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    gains: Mapping[str, float] | None = None,
    sampling_period: float | None = None,
    source: str,
) -> tuple[dict[str, FloatArray], Clock]:
    """Signals of a frame, SI, and their clock: parameters and errors as those of `Log.from_frame`."""
    table, named_columns = table_of(frame), dict(columns or {})
    signals_by_column = {column: signal for signal, column in named_columns.items()}
    values: dict[str, FloatArray] = {}
    notes: list[str] = []
    stated = True
    for header, column in zip(table.headers, table.read(range(len(table.headers))), strict=True):
        name, written = split_unit(header)
        signal = signals_by_column.get(header, signals_by_column.get(name, name))
        if isinstance(column, str):
            notes.append(f"column {header!r} {column}; left out")
            continue
        if signal in values:
            raise LogError(f"{source}: two columns are named {signal!r}: rename one")
        unit = (units or {}).get(signal, written)
        try:
            factor = 1.0 if unit is None else _factor(unit, is_time=signal == TIME)
        except LogError as error:
            raise LogError(f"{source}: column {header!r}: {error}") from error
        stated = stated and (
            signal != TIME or unit is not None or table.headers.index(header) in table.stamps
        )
        values[signal] = (gains or {}).get(signal, 1.0) * factor * column
    if lacking := [signal for signal in named_columns if signal not in values]:
        raise LogError(
            f"{source}: there is no column {named_columns[lacking[0]]!r} of numbers for {lacking[0]!r}: it has "
            f"{', '.join(table.headers)}"
        )
    if TIME in values and not stated:
        with naming_file(Path(source)):
            require_seconds(values[TIME])
    clock = _clock(values.pop(TIME, None), sampling_period, source)
    missing = [n for n, x in values.items() if n.startswith(REFERENCE) and not np.isfinite(x).all()]
    signals = {name: x for name, x in values.items() if name not in missing}
    return signals, replace(clock, notes=(*notes, *clock.notes))


def _columns_of(frame: Frame) -> dict[str, Any]:
    if isinstance(frame, Mapping):
        return {str(name): np.asarray(values) for name, values in frame.items()}
    table: Any = frame
    index = getattr(table, "index", None)
    of_moments = getattr(getattr(index, "dtype", None), "kind", "") in ("m", "M")
    named = TIME if of_moments else getattr(index, "name", None)
    if named is not None and named not in getattr(table, "columns", ()):
        table = table.rename_axis(named).reset_index()
    import narwhals.stable.v2 as nw  # only frames need it

    try:
        read = nw.from_native(table)
        native = read.collect() if isinstance(read, nw.LazyFrame) else read
    except TypeError as error:
        raise LogError(
            f"{type(frame).__name__} is not a log: give a Log, the path of a file, a data frame of pandas, polars or "
            "pyarrow, or columns by name"
        ) from error
    except nw.exceptions.DuplicateError as error:
        repeated = {str(name) for name in table.columns if list(table.columns).count(name) > 1}
        raise LogError(
            f"{FRAME_SOURCE}: several columns are named {', '.join(sorted(repeated))}: rename them"
        ) from error
    return {str(name): column for name, column in zip(native.columns, native.iter_columns(), strict=True)}


def _are_times(column: Any) -> bool:
    """Whether a column holds moments or durations, which are read in seconds."""
    return column.dtype.kind in "mM" if isinstance(column, np.ndarray) else bool(column.dtype.is_temporal())


def _values(column: Any) -> FloatArray | str:
    """Numbers of a column, NaN where it has none, or the reason why it has no numbers."""
    if not isinstance(column, np.ndarray):
        import narwhals.stable.v2 as nw

        if column.dtype.is_numeric():
            return np.asarray(column.cast(nw.Float64).to_numpy(), dtype=np.float64)
        column = column.to_numpy()
    if column.dtype.kind in "mM":
        seconds = (column - column[0]) / np.timedelta64(1, "s") if column.size else column.astype(float)
        return np.asarray(seconds, dtype=np.float64)
    if column.dtype.kind not in "biuf" or column.ndim != 1:
        what = f"{column.dtype}" if column.ndim == 1 else f"an array of shape {column.shape}"
        return f"holds {what} where a vector of numbers is required"
    return np.array(column, dtype=np.float64)


def _factor(text: str, *, is_time: bool) -> float:
    if is_time:
        return to_si(text, Unit.of("s"))
    factor = to_si(text)
    for expected in _CONTEXTS:
        try:
            in_context = to_si(text, expected)
        except LogError:
            continue
        if in_context != factor:
            raise LogError(
                f"unit {text!r} depends on what is measured: read it with read_axis_log, or give units"
            )
    return factor


def _clock(time: FloatArray | None, period: float | None, source: str) -> Clock:
    """The clock of the times of a frame, or of a given period where it has none."""
    if time is None:
        if period is None:
            raise LogError(
                f"{source}: there is no column 't' of the time: give columns={{'t': NAME}} or sampling_period"
            )
        return Clock(0.0, period)
    if period is not None:
        raise LogError(f"{source}: has a column 't' already: omit the sampling period")
    clock = inspect_clock(time)
    if clock.faults:
        raise LogError(f"{source}: {'; '.join(clock.faults)}")
    return clock
