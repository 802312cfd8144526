"""JSON logs: columns by name, records, or one record per line."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from symid.data.formats.channels import described, short_names, table_of_arrays
from symid.data.formats.named_rows import table_of_records
from symid.data.table import Table, parsing, require_memory
from symid.data.text_files.foreign import quantity_named
from symid.data.text_files.time_stamps import seconds_of_stamps
from symid.errors import LogError

_BYTES_OF_A_VALUE, _DEEPEST = 2, 12  # least text of a value; levels of nested objects


def open_json(path: Path, memory: int | None = None) -> Table:
    """Table in a JSON file: lists of numbers by name, at any depth, or a list of records with the same names.

    LogError if it is not JSON, or holds no lists of numbers.
    """
    return _table(path, _parsed(path, memory, lines=False))


def open_json_lines(path: Path, memory: int | None = None) -> Table:
    """Table in a file of one JSON record a line; errors as those of `open_json`."""
    return _table(path, _parsed(path, memory, lines=True))


def _parsed(path: Path, memory: int | None, *, lines: bool) -> object:
    require_memory(path.stat().st_size // _BYTES_OF_A_VALUE, memory)
    try:
        with parsing(path, "JSON", ValueError):
            content = path.read_bytes()
            text = content.decode(json.detect_encoding(content))
            if lines:
                return [json.loads(line) for line in text.splitlines() if line.strip()]
            return json.loads(text)
    except RecursionError as error:
        raise LogError(f"{path}: is nested too deep: give columns or records of numbers") from error


def _table(path: Path, whole: object) -> Table:
    if (of_rows := table_of_records(path, whole)) is not None:
        return of_rows
    columns = list(_columns(whole, ()))
    names = short_names([_with_quantity(names or ("values",)) for names, _ in columns])
    table = table_of_arrays(dict(zip(names, (array for _, array in columns), strict=True)))
    if not table.headers:
        raise LogError(
            f"{path}: holds no columns of numbers: give lists of numbers by name, or a list of records"
        )
    return table


def _with_quantity(names: tuple[str, ...]) -> tuple[str, ...]:
    """Names that lead to a list; the last two are joined if only the first of them names a quantity.

    >>> _with_quantity(("x", "pos", "actual")), _with_quantity(("x", "pos"))
    (('x', 'pos.actual'), ('x', 'pos'))
    """
    if len(names) > 1 and quantity_named(names[-1]) is None and quantity_named(names[-2]):
        return (*names[:-2], ".".join(names[-2:]))
    return names


def _columns(value: object, names: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], npt.NDArray[Any]]]:
    """Lists of numbers in nested objects, with the names that lead to them."""
    if len(names) > _DEEPEST:
        return
    if isinstance(value, Mapping):
        headers: list[str] = next((item for item in value.values() if _are_texts(item)), [])
        rows = next((item for item in value.values() if _are_rows(item, len(headers))), None)
        if rows is not None:
            yield from _records([dict(zip(headers, row, strict=True)) for row in rows], names)
            return
        if value and all(str(key).isdecimal() for key in value):  # as pandas writes a column, by its index
            yield from _columns(list(value.values()), names)
            return
        description = described(value, names)
        for name, inner in value.items():
            if description is None or name != description[0]:
                yield from _columns(inner, (*names, str(name)))
            else:
                for (*path, last), array in _columns(inner, description[1]):
                    yield (*path, f"{last} [{description[2]}]" if description[2] else last), array
    elif isinstance(value, list) and value and isinstance(value[0], Mapping):
        records = [item for item in value if isinstance(item, Mapping)]
        description = described(records[0], names)
        if description is None or not isinstance(records[0][description[0]], list):
            yield from _records(records, names)
        else:  # one for each signal
            for record in records:
                yield from _columns(record, names)
    elif isinstance(value, list) and value:
        numbers = _numbers(value)
        if numbers is not None:
            yield names, numbers


def _are_texts(value: Any) -> bool:
    return isinstance(value, list) and value != [] and all(isinstance(item, str) for item in value)


def _are_rows(rows: Any, width: int) -> bool:
    """Whether these are rows of a table, as pandas writes them beside the names of its columns."""
    return (
        isinstance(rows, list) and rows != [] and all(isinstance(r, list) and len(r) == width for r in rows)
    )


def _records(
    records: list[Mapping[str, Any]], names: tuple[str, ...]
) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Columns of records; nested values are named by their path."""
    flat = [dict(_flat(record, ())) for record in records]
    for header in dict.fromkeys(name for record in flat for name in record):
        numbers = _numbers([record.get(header) for record in flat])
        if numbers is not None:
            yield (*names, *header), numbers


def _flat(record: Mapping[str, Any], names: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Any]]:
    for name, value in record.items():
        if isinstance(value, Mapping) and len(names) < _DEEPEST:
            yield from _flat(value, (*names, str(name)))
        else:
            yield (*names, str(name)), value


def _numbers(values: list[Any]) -> npt.NDArray[Any] | None:
    """Numbers, with nan for missing ones; moments as seconds; None for anything else."""
    if all(isinstance(value, (int, float)) or value is None for value in values):
        try:
            return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
        except OverflowError:  # an integer that no float holds
            return None
    if all(isinstance(value, str) for value in values):
        return seconds_of_stamps(values)
    try:
        array = np.array(values, dtype=np.float64)
    except (ValueError, TypeError, OverflowError):
        return None
    return array if array.ndim == 2 else None


READERS = {".json": open_json, ".jsonl": open_json_lines, ".ndjson": open_json_lines}
