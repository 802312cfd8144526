"""Parameters in a JSON file: those of `symid identify` or `symid diagnose`, or names with values."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from symid.files import is_finite_number


class ParameterEntry(NamedTuple):
    """A parameter as written in a file."""

    value: Any  # what stands there, which need not be a number
    std: float = math.nan  # the largest one, which covers all that is known, where there are several
    unit: str = ""


def parameter_entries(record: Mapping[str, Any]) -> dict[str, ParameterEntry]:
    """Physical parameters of a record, identified ones and those that were known.

    >>> parameter_entries({"physical": {"M": {"value": 5.0, "std": 0.1}}, "known": {"Fs": 2.0}})["M"].std
    0.1
    >>> parameter_entries({"M": 5.0})["M"].value
    5.0
    """
    found = next((record[x] for x in ("physical", "parameters") if isinstance(record.get(x), dict)), None)
    if found is None:
        return entries_of(record)
    known = record.get("known")
    return entries_of({**found, **(known if isinstance(known, dict) else {})})


def entries_of(written: object) -> dict[str, ParameterEntry]:
    """Entries by name, each a value or its record; empty unless a mapping is given."""
    return {name: _entry(one) for name, one in written.items()} if isinstance(written, dict) else {}


def _entry(written: object) -> ParameterEntry:
    """An entry; of a diagnosis, the values with the effects found."""
    if not isinstance(written, dict):
        return ParameterEntry(written)
    inner = (written.get(name) for name in ("explained", "reidentified"))
    of_model = (one for one in inner if isinstance(one, dict) and is_finite_number(one.get("value")))
    best = next(of_model, written)
    names = ("deviation",) if "deviation" in best else ("std_corrected", "std")
    stds = (best[name] for name in names if is_finite_number(best.get(name)))
    unit = written.get("unit")
    return ParameterEntry(
        best.get("value"), float(next(stds, math.nan)), unit if isinstance(unit, str) else ""
    )
