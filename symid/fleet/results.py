"""The table of results of a batch: one row per log, with columns for its parameters."""

import json
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import polars as pl

from symid.arrays import FloatArray
from symid.data import POLARS_FAILURES, require_memory, source_of
from symid.errors import LogError, SettingError
from symid.files import require_regular
from symid.fleet.row import BEFORE, TEXT_COLUMNS, TIMES

UNKNOWN_AXIS = "unknown axis"
"""Axis of logs that failed before their axis was known."""
UNITS_KEY = "symid.units"
"""Key of the units in the metadata of a Parquet file: JSON, from axis to sensors to column to unit."""
Units = Mapping[str, Mapping[str, Mapping[str, str]]]
_MINIMAL = re.compile(r"X\d+")
"""Names of minimal parameters."""
_NEEDED = ("log", "axis", "status")
_FORMULA, _MADE_SAFE = r"^('*[=+\-@\t\r])", r"^'('*[=+\-@\t\r])"
"""Text that a spreadsheet would interpret as a formula, and the same with an apostrophe before it."""
_LARGEST = 1e150  # square of a parameter must not overflow


@dataclass(frozen=True)
class Group:
    """Rows of results of one axis."""

    name: str  # the axis, with its sensors or its folder if there are several
    axis: str
    sensors: tuple[str, ...]  # those of the identification; empty if unknown
    rows: pl.DataFrame


def read_results(file: str | Path) -> pl.DataFrame:
    """Results of a batch from a Parquet or CSV file.

    Raises
    ------
    SettingError
        If the file has another format, cannot be read, or has no column that all results have.
    """
    path = Path(file)
    kind = path.suffix.lower()
    if kind not in (".parquet", ".csv"):
        raise SettingError(
            f"results {path.name!r} are of an unknown kind: give a .parquet or .csv of symid batch"
        )
    if not path.exists():
        raise SettingError(f"results {path}: there is no such file; symid batch writes one")
    require_regular(path)
    try:
        if kind == ".parquet":
            scanned = pl.scan_parquet(path, glob=False)
            require_memory(scanned.select(pl.len()).collect().item() * len(scanned.collect_schema()))
            table = scanned.collect()
        else:
            texts = dict.fromkeys(TEXT_COLUMNS, pl.String)
            table = pl.read_csv(path, schema_overrides=texts, infer_schema_length=None)
            table = table.with_columns(pl.col(pl.String).str.replace(_MADE_SAFE, "$1"))
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException, OSError, LogError) as error:
        raise SettingError(f"results {path} cannot be read: {' '.join(str(error).split())}") from error
    return checked_results(table)


def with_safe_cells(table: pl.DataFrame) -> pl.DataFrame:
    """The table with an apostrophe before texts that look like formulas of a spreadsheet; `read_results` removes it.

    >>> with_safe_cells(pl.DataFrame({"log": ["=1+1.csv", "-2.csv", "a.csv"]}))["log"].to_list()
    ["'=1+1.csv", "'-2.csv", 'a.csv']
    """
    return table.with_columns(pl.col(pl.String).str.replace(_FORMULA, "'$1"))


def units_in(file: str | Path) -> Units:
    """Units in a Parquet file of results; empty for a CSV file.

    Parameters
    ----------
    file : path-like
        File of results, as for `read_results`.
    """
    if Path(file).suffix.lower() != ".parquet":
        return {}
    try:
        return dict(json.loads(pl.read_parquet_metadata(file).get(UNITS_KEY, "{}")))
    except (ValueError, TypeError):
        return {}


def holds_results(file: str | Path) -> bool:
    """Whether a CSV or Parquet file holds results of a batch, by the names of its first columns."""
    path, names = Path(file), tuple(BEFORE)[:4]
    try:
        if path.suffix.lower() == ".csv" and path.is_file():
            with path.open("rb") as opened:
                return opened.read(64).startswith(f"{','.join(names)},".encode())
        if path.suffix.lower() == ".parquet" and path.is_file():
            return tuple(pl.read_parquet_schema(source_of(path)))[: len(names)] == names
    except (OSError, *POLARS_FAILURES):
        pass
    return False


def checked_results(table: pl.DataFrame) -> pl.DataFrame:
    """The table; SettingError if it does not have the columns of results."""
    if missing := [name for name in _NEEDED if name not in table.columns]:
        raise SettingError(
            f"results without column {', '.join(missing)}: {', '.join(_NEEDED)} are required, one row per log"
        )
    for name in (name for name in TEXT_COLUMNS if name in table.columns):
        kind = table.schema[name]
        if name == "measured" and kind == pl.List(pl.String):
            continue
        if kind not in (pl.String, pl.Null) and not (name in TIMES and kind.is_temporal()):
            raise SettingError(f"results hold {kind} in column {name!r}, where texts are required")
    return table


def parameter_names(table: pl.DataFrame) -> tuple[str, ...]:
    """Parameters in a table: columns with a corresponding column of standard deviations.

    >>> parameter_names(pl.DataFrame({"log": ["a"], "M": [1.0], "M_std": [0.1], "seconds": [2.0]}))
    ('M',)
    """
    columns = set(table.columns)
    return tuple(name for name in table.columns if f"{name}_std" in columns)


def without_repeats(known: Iterable[str], declared: Iterable[str] = ()) -> list[str]:
    """Known parameters without the minimal ones, if these repeat the physical ones.

    They do where each physical parameter of those declared is known.

    >>> without_repeats(["X1", "X2", "M"]), without_repeats(["X1", "X2"]), without_repeats(["X1", "M"], ["M", "K"])
    (['M'], ['X1', 'X2'], ['X1', 'M'])
    """
    names = list(known)
    physical = [name for name in names if not _MINIMAL.fullmatch(name)]
    complete = all(name in physical for name in declared if not _MINIMAL.fullmatch(name))
    return physical if physical and complete else names


def groups(table: pl.DataFrame, by_folder: bool = False) -> tuple[Group, ...]:
    """Rows by axis and set of sensors, and optionally by folder of the logs, if that identifies the machine.

    >>> table = pl.DataFrame({"log": ["x/1.csv", "y/1.csv"], "axis": ["emps"] * 2, "status": ["ok"] * 2})
    >>> [group.name for group in groups(table, by_folder=True)]
    ['emps in x', 'emps in y']
    """
    logs = table["log"].cast(pl.String).fill_null("")
    folders = pl.Series([str(Path(log).parent) if by_folder else "" for log in logs], dtype=pl.String)
    keyed = _filled(table.with_columns(_FOLDER=folders, _SENSORS=_sensors(table)))
    several = keyed.group_by("_AXIS").agg(pl.col("_SENSORS").n_unique()).filter(pl.col("_SENSORS") > 1)
    parts_named = []
    parts = keyed.partition_by("_AXIS", "_SENSORS", "_FOLDER", maintain_order=True, as_dict=True)
    for (axis, sensors, folder), rows in parts.items():
        name = str(axis)
        if axis in several["_AXIS"]:
            name += f" from {sensors or 'unknown sensors'}"
        if folder:
            name += f" in {folder}"
        signals = tuple(each.strip() for each in str(sensors).split(",") if each.strip())
        parts_named.append(Group(name, str(axis), signals, rows.drop("_AXIS", "_SENSORS", "_FOLDER")))
    return tuple(sorted(parts_named, key=lambda group: group.name))


def _filled(table: pl.DataFrame) -> pl.DataFrame:
    """The table with axis and sensors filled in for logs that failed early, where there is only one choice."""
    axis, sensors = pl.col("axis").cast(pl.String), pl.col("_SENSORS")
    only = pl.when(axis.n_unique() - axis.is_null().any() == 1).then(axis.drop_nulls().first())
    table = table.with_columns(_AXIS=axis.fill_null(only.over("_FOLDER")).fill_null(UNKNOWN_AXIS))
    only = pl.when(sensors.n_unique() - sensors.is_null().any() == 1).then(sensors.drop_nulls().first())
    return table.with_columns(_SENSORS=sensors.fill_null(only.over("_AXIS")).fill_null(""))


def _sensors(table: pl.DataFrame) -> pl.Expr:
    if "measured" not in table.columns:
        return pl.lit(None, pl.String)
    column = pl.col("measured")
    if isinstance(table.schema["measured"], pl.List):
        column = column.list.join(", ")
    return column.cast(pl.String).replace("", None)


def numbers_in(rows: pl.DataFrame, column: str) -> FloatArray:
    """A column as numbers; nan for a missing value and for one whose square is not finite.

    >>> numbers_in(pl.DataFrame({"M": [1.0, None]}), "M").tolist()
    [1.0, nan]
    """
    if rows.schema[column].is_nested() or rows.schema[column].is_temporal():
        return np.full(rows.height, np.nan)
    values: FloatArray = rows[column].cast(pl.Float64, strict=False).to_numpy().astype(np.float64)
    return np.where(np.abs(values) < _LARGEST, values, np.nan)


def moments(rows: pl.DataFrame) -> Sequence[datetime] | None:
    """Recording time of each log in UTC; None unless all are known and not all equal.

    >>> moments(pl.DataFrame({"recorded": ["2026-03-01T06:00:00Z"]}))[0].isoformat()
    '2026-03-01T06:00:00+00:00'
    """
    if "recorded" not in rows.columns:
        return None
    times = [_moment(value) for value in rows["recorded"]]
    known = [moment for moment in times if moment is not None]
    if len(known) > 1 and len(set(known)) == 1:
        return None  # times of a copy of the files, not of the recordings
    return known if len(known) == len(times) else None


def _moment(value: object) -> datetime | None:
    if isinstance(value, str):
        try:
            value = datetime.fromisoformat(value)
        except ValueError:
            return None
    if not isinstance(value, datetime):
        return None
    return value.replace(tzinfo=UTC) if value.tzinfo is None else value.astimezone(UTC)


@dataclass(frozen=True)
class EffectCount:
    """Number of logs in which a diagnosis found an effect at a place, in total and by axis."""

    effect: str
    at: str
    logs: int
    axes: Mapping[str, int]


def count_effects(places: Iterable[tuple[str, object, object]]) -> tuple[EffectCount, ...]:
    """Effects in a fleet, the most frequent first, from the axis, effect (or None) and place of each log.

    >>> count_effects([("emps", "backlash", "load"), ("rig", None, None), ("emps", "backlash", "load")])
    (EffectCount(effect='backlash', at='load', logs=2, axes={'emps': 2}),)
    """
    axes: dict[tuple[str, str], Counter[str]] = defaultdict(Counter)
    for axis, effect, at in places:
        if effect:
            axes[str(effect), str(at or "")][axis] += 1
    counts = (EffectCount(*place, counted.total(), dict(counted)) for place, counted in axes.items())
    return tuple(sorted(counts, key=lambda one: (-one.logs, one.effect, one.at)))
