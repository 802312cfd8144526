"""Options for prior knowledge of the parameters: values, bounds, priors."""

import csv
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from click import option

from symid.axis import Axis
from symid.cli.options import named_values, number, shared
from symid.data import split_unit
from symid.errors import SettingError, SymidError
from symid.files import read_json, require_regular
from symid.identification import known_of_logs
from symid.parameter_entries import parameter_entries
from symid.units import Unit, to_si

_QUANTITY = re.compile(r"\s*(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(?P<unit>.*?)\s*")

fix_option = option(
    "--fix",
    "fixed",
    multiple=True,
    metavar="NAME=VALUE",
    help="Value of a parameter that is known, such as M=95 or M=95kg.",
)

knowledge_options = shared(
    fix_option,
    option(
        "--bounds",
        multiple=True,
        metavar="NAME=LOW..HIGH",
        help="Range of a parameter, such as Fv=0..300 or Ml=2..; 'physical': no negative masses, springs or frictions.",
    ),
    option(
        "--prior",
        metavar="P.json",
        help='Means and deviations known beforehand, {"M": [95, 2]} in SI, or what identify --json wrote.',
    ),
)


known_option = option(
    "--known",
    multiple=True,
    metavar="NAME=VALUE,...",
    help="Value of a parameter in each LOG, in their order, such as the payload: Ml=0,12.5kg; or a CSV table "
    "with a column log and one for each such parameter.",
)


def fixed_values(values: tuple[str, ...], axis: Axis) -> dict[str, float]:
    """Values of ``--fix``, SI."""
    units = axis.parameter_units
    values_si = named_values(values, "--fix", units)
    return {name: quantity(text, units[name], f"--fix {name}") for name, text in values_si.items()}


def known_by_log(values: tuple[str, ...], axis: Axis, logs: Sequence[str]) -> list[dict[str, float]]:
    """Values of ``--known`` in each log, SI; those without ``=`` are tables."""
    units = axis.parameter_units
    tables = [value for value in values if "=" not in value]
    known = [dict(values_of_log) for values_of_log in known_of_logs(known_of_tables(tables, units), logs)]
    for name, text in named_values(tuple(v for v in values if v not in tables), "--known", units).items():
        parts = text.split(",")
        if len(parts) != len(logs):
            raise SettingError(
                f"--known {name}={text} has {len(parts)} values for {len(logs)} logs: give one for each log"
            )
        for values_of_log, part in zip(known, parts, strict=True):
            values_of_log[name] = quantity(part, units[name], f"--known {name}")
    return known


def known_of_tables(files: Sequence[str], units: Mapping[str, Unit]) -> dict[str, dict[str, float]]:
    """Values that tables give for each log, by what they call it: its path or its name."""
    known: dict[str, dict[str, float]] = {}
    for file in files:
        header, *rows = _cells(file)
        columns = [split_unit(column) for column in header]
        if "log" not in header:
            raise SettingError(f"--known {file} has no column log: write one, and one for each parameter")
        if strange := [name for name, _ in columns if name not in (*units, "log")]:
            raise SettingError(f"--known {file}: {strange[0]} is not known: choose from {', '.join(units)}")
        logs = [row[header.index("log")] for row in rows if len(row) == len(header)]
        if len(logs) < len(rows) or len(set(logs)) < len(logs):
            raise SettingError(f"--known {file}: give each log one row of {len(header)} values")
        for log, row in zip(logs, rows, strict=True):
            known.setdefault(log, {}).update(
                (name, quantity(text + (unit or ""), units[name], f"--known {file}: {name}"))
                for (name, unit), text in zip(columns, row, strict=True)
                if name != "log"
            )
    return known


def _cells(file: str) -> list[list[str]]:
    """Cells of a CSV table, also of one with semicolons and decimal commas."""
    require_regular(file)
    lines = [
        line for line in Path(file).read_text("utf-8-sig", errors="replace").splitlines() if line.strip()
    ]
    if lines and ";" in lines[0]:
        lines = [line.replace(",", ".").replace(";", ",") for line in lines]
    return [*csv.reader(lines, skipinitialspace=True)] or [[]]


def quantity(text: str, unit: Unit, what: str) -> float:
    """A number with or without a unit, in SI.

    >>> quantity("12.5kg", Unit.of("kg"), "--fix M"), quantity("3 kN", Unit.of("N"), "--fix Fs"), quantity(
    ...     "7", Unit.of("N"), "--fix Fs"
    ... )
    (12.5, 3000.0, 7.0)
    """
    match = _QUANTITY.fullmatch(text)
    if match is None:
        return number(text, what)
    try:
        factor = to_si(match["unit"], unit) if match["unit"] else 1.0
    except SymidError as error:
        raise SettingError(f"{what}={text}: {error}") from error
    return number(match["number"], what) * factor


def bounds_of(values: tuple[str, ...], axis: Axis) -> dict[str, tuple[float | None, float | None]]:
    """Ranges of ``--bounds``, SI; 'physical' is a lower bound of 0 for parameters that cannot be negative."""
    ranges = tuple(value for value in values if value != "physical")
    bounds: dict[str, tuple[float | None, float | None]] = {}
    if len(ranges) < len(values):
        bounds |= {n: (0.0, None) for n in axis.physical_parameters if n not in axis.signed_parameters}
    for name, text in named_values(ranges, "--bounds").items():
        low, dots, high = text.partition("..")
        unit = axis.parameter_units.get(name, Unit())
        if not dots:
            raise SettingError(
                f"--bounds {name}={text} is not a range: write LOW..HIGH, one of them may be left out"
            )
        low_end, high_end = (quantity(x, unit, f"--bounds {name}") if x else None for x in (low, high))
        bounds[name] = low_end, high_end
    return bounds


def priors_of(file: str | None, axis: Axis) -> dict[str, Any]:
    """Mean and deviation by parameter from ``--prior``: a file of such pairs, or a result of symid identify."""
    if file is None:
        return {}
    values = read_json(file)
    if not isinstance(values, dict):
        raise SettingError(f'{file} holds no priors: write {{"NAME": [mean, deviation], ...}} in SI units')
    if isinstance(values.get("physical"), dict):
        entries = {
            n: entry for n, entry in parameter_entries(values).items() if n in axis.physical_parameters
        }
        if unsure := [name for name, entry in entries.items() if math.isnan(entry.std)]:
            raise SettingError(f"{file}: {unsure[0]} has no standard deviation, which a prior needs")
        return {name: (entry.value, entry.std) for name, entry in entries.items()}
    return values
