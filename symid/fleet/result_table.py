"""The table of results: its columns, its units, and the files that hold it."""

import json
import os
from collections.abc import Iterable, Sequence
from pathlib import Path

import polars as pl

from symid.data import write_frame
from symid.errors import SettingError, SymidError
from symid.fleet.plan import FleetAxis
from symid.fleet.results import UNITS_KEY, Units, read_results, with_safe_cells
from symid.fleet.row import AFTER, BEFORE, DIAGNOSIS, FACTORS, ResultRow

RESULT_SUFFIXES = (".parquet", ".csv")
_TYPES = {str: pl.String(), int: pl.Int64(), float: pl.Float64()}


def result_frame(
    rows: Sequence[ResultRow], parameters: Iterable[str], diagnosed: bool, joint: bool = False
) -> pl.DataFrame:
    """Rows, one per log, as a table with columns of parameters; missing values are null.

    Columns of a diagnosis and of triangular factors for a joint estimate are optional.

    >>> result_frame([{"log": "a.csv", "M": 5.0}], ["M"], False).select("log", "M", "status").row(0)
    ('a.csv', 5.0, None)
    """
    kinds = {**BEFORE, **dict.fromkeys(parameters, float), **AFTER, **(DIAGNOSIS if diagnosed else {})}
    kinds |= {FACTORS: str} if joint else {}
    schema = {name: _TYPES[kind] for name, kind in kinds.items()}
    return pl.DataFrame([[row.get(name) for name in schema] for row in rows], schema=schema, orient="row")


def units_of(rows: Iterable[ResultRow], axes: Iterable[FleetAxis]) -> dict[str, dict[str, dict[str, str]]]:
    """Units of the parameters, by axis and sensors that occur in the rows.

    Minimal parameters such as X1 differ between sets of sensors, and so do their units.
    """
    seen = dict.fromkeys((row.get("axis"), row.get("measured")) for row in rows if "condition_number" in row)
    units: dict[str, dict[str, dict[str, str]]] = {}
    for axis in axes:
        for signals, _ in axis.modules:
            measured = ",".join(signals)
            if (axis.axis.name, measured) in seen:
                model = axis.model(signals)
                named = {**model.minimal_units, **model.physical_units}
                units.setdefault(axis.axis.name, {})[measured] = {n: str(unit) for n, unit in named.items()}
    return units


def columns_of_parameters(units: Units) -> tuple[str, ...]:
    """Columns of all parameters, each followed by the column of its standard deviation."""
    names = dict.fromkeys(name for sets in units.values() for named in sets.values() for name in named)
    return tuple(column for name in names for column in (name, f"{name}_std"))


def result_files(
    output: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] | None,
) -> tuple[Path, ...]:
    """Files of the results, at most one of each format, the Parquet file first.

    SettingError if a suffix is unknown, or a folder does not exist.
    """
    if output is None:
        return ()
    given = (output,) if isinstance(output, (str, os.PathLike)) else output
    files = tuple(sorted(map(Path, given), key=lambda file: file.suffix, reverse=True))
    for file in files:
        if file.suffix not in RESULT_SUFFIXES:
            raise SettingError(
                f"results {str(file)!r} are of an unknown kind: end the name with .parquet or .csv"
            )
        if not file.parent.is_dir() or file.is_dir():
            raise SettingError(
                f"results {str(file)!r} cannot be written: give a file in a folder that exists"
            )
    if len({file.suffix for file in files}) < len(files):
        raise SettingError("results go to one .parquet and one .csv file at most: give each kind once")
    return files


def read_rows(file: Path) -> list[ResultRow]:
    """Rows of a file written by `write_table`, none if it does not exist; SettingError if it has other contents."""
    if not file.exists():
        return []
    nothing = SettingError(f"{file}: exists but holds no results: give another file, or remove it")
    try:
        frame = read_results(file)
    except SettingError as error:
        raise nothing from error
    if "key" not in frame.columns:
        raise nothing
    return [{k: v for k, v in row.items() if v is not None} for row in frame.iter_rows(named=True)]


def write_table(table: pl.DataFrame, units: Units, file: Path) -> None:
    """Write a table atomically; SymidError if that fails, as on a full disk."""
    try:
        if file.suffix == ".parquet":
            write_frame(table, file, {UNITS_KEY: json.dumps(units)})
        else:
            write_frame(with_safe_cells(table), file)
    except OSError as error:
        raise SymidError(f"{file}: cannot be written ({error.strerror or error})") from error
