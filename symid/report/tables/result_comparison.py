"""Comparison of two sets of parameters: differences and their significance."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy
from rich.console import Console

from symid.arrays import FloatArray
from symid.errors import SettingError
from symid.files import is_finite_number, shortened
from symid.parameter_entries import parameter_entries
from symid.report.tables.console import TextTable, plain, report_console
from symid.report.tables.number_text import MISSING, significant, with_deviation
from symid.text import spoken

_DIFFERENT = 3.0
"""Standard deviations beyond which parameters count as different."""
_STAGES = {
    "nominal": "nominal values",
    "reidentified": "re-identified",
    "explained": "with the effects found",
    "noise_floor": "noise alone",
}
_CERTAIN = 1e-3
"""Probability below which two sets as a whole count as different."""


@dataclass(frozen=True, eq=False)
class ComparedValues:
    """Physical parameters of a result."""

    # source, axis, status: name of the file, and its axis and status; empty if missing
    source: str
    axis: str
    status: str
    # values, deviations: SI; nan where a deviation is not known
    values: Mapping[str, float]
    deviations: Mapping[str, float]
    units: Mapping[str, str] = field(default_factory=dict)  # of the parameters, where they are known
    covariance: FloatArray | None = None  # shape (n, n): of the parameters in their order
    settings: Mapping[str, Any] = field(default_factory=dict)  # with which they were found
    facts: Mapping[str, str] = field(default_factory=dict)  # logs, method and verdict in words
    # residual of the model, and its unit
    errors: Mapping[str, tuple[float, str]] = field(default_factory=dict)


def values_of_record(record: object, source: str) -> ComparedValues:
    """Parameters in the JSON of `symid identify`, `symid diagnose` or a user; SettingError if it holds none.

    >>> values_of_record({"M": 5.0, "Fv": {"value": 1.0, "std": 0.1}}, "P.json").deviations["Fv"]
    0.1
    """
    if not isinstance(record, dict):
        raise SettingError(f"{source} holds {shortened(record)}: give the record of an identification")
    entries = {n: entry for n, entry in parameter_entries(record).items() if is_finite_number(entry.value)}
    if not entries:
        raise SettingError(
            f"{source} holds no parameters: give the record of an identification, or names and values"
        )
    axis, status = (record[name] if isinstance(record.get(name), str) else "" for name in ("axis", "status"))
    deviations = {name: entry.std for name, entry in entries.items()}
    return ComparedValues(
        source=source,
        axis=axis,
        status=status,
        values={name: float(entry.value) for name, entry in entries.items()},
        deviations=deviations,
        units={name: entry.unit for name, entry in entries.items() if entry.unit},
        covariance=_covariance(record, deviations),
        settings=record["filter"] if isinstance(record.get("filter"), dict) else {},
        facts=_facts(record),
        errors=_errors(record),
    )


def comparison_record(first: ComparedValues, second: ComparedValues) -> dict[str, Any]:
    """Record of `symid compare --json`; SettingError if the two share no parameter."""
    shared = [name for name in first.values if name in second.values]
    if not shared:
        raise SettingError(
            f"{first.source} has {', '.join(first.values)}, {second.source} has {', '.join(second.values)}: "
            "they share no parameter, compare two results of one axis"
        )
    both = (first, second)
    return {
        "files": [side.source for side in both],
        "axis": [side.axis for side in both],
        "status": [side.status for side in both],
        "parameters": {name: _compared(name, first, second) for name in shared},
        "facts": _side_by_side(first.facts, second.facts),
        "errors": {
            name: {"a": a and a[0], "b": b and b[0], "unit": (a or b)[1]}
            for name, (a, b) in _side_by_side(first.errors, second.errors).items()
        },
        "only_in": [[name for name in side.values if name not in shared] for side in both],
        "together": _together(first, second),
        "settings": {
            name: values
            for name, values in _side_by_side(first.settings, second.settings).items()
            if first.settings and second.settings and values[0] != values[1]
        },
    }


def print_comparison(record: dict[str, Any], console: Console | None = None) -> None:
    """Print the record of `comparison_record`."""
    console = console or report_console()
    files = zip("AB", record["files"], record["axis"], record["status"], strict=True)
    for which, file, axis, status in files:
        console.print(plain(f"{which}: {file}" + "".join(f", {word}" for word in (axis, status) if word)))
    numbers = ("A", "B", "B - A", "% of A", "deviations")
    table = TextTable("", "", *numbers, "unit", right=numbers)
    for name, entry in record["parameters"].items():
        sides = (with_deviation(entry[key]["value"], entry[key]["std"]) for key in ("a", "b", "difference"))
        apart = significant(entry["deviations"], 2) + "  differs" * entry["differs"]
        table.add(name, *sides, significant(100 * entry["relative"], 2), apart, entry["unit"])
    console.print(table)
    if record["errors"]:
        errors = TextTable("", "", "A", "B", "unit", right=("A", "B"))
        for name, entry in record["errors"].items():
            sizes = (MISSING if size is None else significant(size) for size in (entry["a"], entry["b"]))
            errors.add(name, *sizes, entry["unit"])
        console.print(errors)
    together = record["together"]
    if together is not None:
        console.print(
            f"together: chi-square {together['chi_square']:.3g} of {together['parameters']} parameters, "
            f"probability {together['probability']:.2g} if both logs were of one machine"
            + (": they differ" if together["differs"] else "")
        )
    for file, names in zip(record["files"], record["only_in"], strict=True):
        if names:
            console.print(plain(f"only in {file}: {', '.join(names)}"))
    for name in ("sensors", "method", "verdict", "effects"):
        a, b = record["facts"].get(name, (None, None))
        if a and b and a != b:
            console.print(plain(f"{name}: {a} and {b}"))
    for name, (a, b) in record["settings"].items():
        console.print(plain(f"setting {name}: {shown_setting(a)} and {shown_setting(b)}"))


def shown_setting(value: Any) -> str:
    """A setting of a result as text.

    >>> shown_setting({"F": -0.0005}), shown_setting({}), shown_setting([49, 0]), shown_setting(True)
    ('F -0.0005', 'none', '49, 0', 'yes')
    """
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {shown_setting(item)}" for name, item in value.items()) or "none"
    if isinstance(value, list):
        return ", ".join(map(shown_setting, value)) or "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "none" if value is None else str(value)


def comparison_sentence(record: Mapping[str, Any]) -> str:
    """Sentence on the parameters in which two results differ.

    >>> a, b = (values_of_record({"M": {"value": m, "std": 0.1}, "Fv": 1.0}, f"{m}.json") for m in (5.0, 6.0))
    >>> comparison_sentence(comparison_record(a, b))
    'A and B differ in M'
    """
    different = [name for name, entry in record["parameters"].items() if entry["differs"]]
    if different:
        return f"A and B differ in {', '.join(different)}"
    together = record["together"]
    if together is not None and together["differs"]:
        return "A and B differ in their parameters jointly, in no single one"
    if not any(math.isfinite(entry["deviations"]) for entry in record["parameters"].values()):
        return "Neither A nor B has deviations: whether they differ is not known"
    return f"A and B do not differ: no parameter by more than {_DIFFERENT:g} deviations"


def _side_by_side(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, list[Any]]:
    """Entries of both by name, None where one has none."""
    return {name: [first.get(name), second.get(name)] for name in dict.fromkeys([*first, *second])}


def _facts(record: Mapping[str, Any]) -> dict[str, str]:
    """Status, setting and statements of a result."""
    statements = {
        "axis": record.get("axis"),
        "sensors": record.get("measured"),
        "logs": record.get("log", record.get("logs")),
        "method": record.get("method"),
        "status": record.get("status"),
        "verdict": record.get("verdict"),
        "sentence": record.get("sentence") or record.get("message"),
        "effects": _effects(record),
    }
    facts = {name: [value] if isinstance(value, str) else value for name, value in statements.items()}
    return {
        name: ", ".join(map(str, value))
        for name, value in facts.items()
        if isinstance(value, list) and any(value)
    }


def _effects(record: Mapping[str, Any]) -> list[str]:
    listed = record.get("effects")
    effects = [effect for effect in listed if isinstance(effect, dict)] if isinstance(listed, list) else []
    return [spoken(str(effect.get("effect")), str(effect.get("at"))) for effect in effects]


def _errors(record: Mapping[str, Any]) -> dict[str, tuple[float, str]]:
    """Residuals of an identification and of its validation, or stages of the gap of a diagnosis."""
    validation, gap = record.get("validation"), record.get("gap")
    errors = {}
    for where, of in (("", record), (" on the validation", validation)):
        residuals = of.get("residual") if isinstance(of, dict) else None
        for output, entry in residuals.items() if isinstance(residuals, dict) else ():
            errors[f"rms of the residual of {output}{where}"] = entry
    if isinstance(gap, dict):
        for stage in ("nominal", "reidentified", "explained", "noise_floor"):
            level, unit = gap.get(stage), gap.get("unit")
            if isinstance(level, dict):
                errors[f"error of {gap.get('signal')}, {_STAGES[stage]}"] = {**level, "unit": unit}
    return {
        name: (float(entry["rms"]), str(entry.get("unit") or ""))
        for name, entry in errors.items()
        if isinstance(entry, dict) and is_finite_number(entry.get("rms"))
    }


def _covariance(record: Mapping[str, Any], deviations: Mapping[str, float]) -> FloatArray | None:
    """Covariance of the parameters, with their correlations and these deviations; None where it is not known."""
    covariance = record.get("covariance")
    names = record.get("physical")
    if not isinstance(covariance, dict) or not isinstance(names, dict) or list(names) != list(deviations):
        return None
    try:
        matrix = np.array(covariance.get("physical"), dtype=np.float64)
    except (TypeError, ValueError):
        return None
    if matrix.shape != (len(deviations), len(deviations)) or not (np.diag(matrix) > 0).all():
        return None
    widened = np.array(list(deviations.values())) / np.sqrt(np.diag(matrix))
    with np.errstate(over="ignore"):
        matrix *= np.outer(widened, widened)
    return matrix if np.isfinite(matrix).all() else None


def _compared(name: str, first: ComparedValues, second: ComparedValues) -> dict[str, Any]:
    a, b = first.values[name], second.values[name]
    stds = (first.deviations[name], second.deviations[name])
    known = [std for std in stds if math.isfinite(std)]
    spread = math.hypot(*known) if known else math.nan
    apart = (b - a) / spread if spread > 0 else math.nan
    return {
        "a": {"value": a, "std": stds[0]},
        "b": {"value": b, "std": stds[1]},
        "difference": {"value": b - a, "std": spread},
        "relative": (b - a) / a if a else math.nan,
        "deviations": apart,
        "differs": bool(abs(apart) > _DIFFERENT),
        "unit": first.units.get(name) or second.units.get(name, ""),
    }


def _together(first: ComparedValues, second: ComparedValues) -> dict[str, Any] | None:
    """Test whether both sets as a whole belong to one machine: (b - a)' (A + B)^-1 (b - a) against chi-square."""
    names = list(first.values)
    if first.covariance is None or second.covariance is None or names != list(second.values):
        return None
    difference = np.array([second.values[name] - first.values[name] for name in names])
    with np.errstate(all="ignore"):
        covariance = first.covariance + second.covariance
        scale = np.sqrt(np.diag(covariance))
        scaled, correlation = difference / scale, covariance / np.outer(scale, scale)
    if not (np.isfinite(scaled).all() and np.isfinite(correlation).all()):
        return None
    solved, *_ = np.linalg.lstsq(correlation, scaled, rcond=None)
    square = float(scaled @ solved)
    probability = float(scipy.special.chdtrc(len(names), max(square, 0.0)))
    return {
        "chi_square": square,
        "parameters": len(names),
        "probability": probability,
        "differs": probability < _CERTAIN,
    }
