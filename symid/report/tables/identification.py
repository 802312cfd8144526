"""An identification, and one of groups of logs, as JSON records and as tables."""

import math
from collections.abc import Sequence
from typing import Any

from rich.console import Console

from symid.arrays import FloatArray
from symid.estimation import relative_standard_deviation
from symid.identification import (
    Bias,
    EquationResidual,
    Identification,
    OutputPrediction,
    Preparation,
    SharedIdentification,
)
from symid.report.tables.console import TextTable, report_console
from symid.report.tables.number_text import MISSING, significant


def identification_record(
    found: Identification, validation: OutputPrediction | None = None
) -> dict[str, Any]:
    """Record of `symid identify --json`.

    ``std`` is the classical deviation of the paper [22]-[30], which takes the residual as white; ``std_corrected``
    allows for its correlation, ``deviation`` also for scatter between parts of the logs and for ``bias``, the expected
    systematic error. ``bias_dominates`` names parameters whose bias exceeds a tenth of the corrected deviation.
    """
    record: dict[str, Any] = {
        "axis": found.model.axis,
        "measured": list(found.model.measured),
        "method": found.fit.method,
        "log": list(found.logs),
        "status": found.status,
        "message": found.message,
        "notes": list(found.notes),
        "filter": _filter(found.observations[0].preparation),
        "samples": max(found.fit.rows),
        "rows": list(found.fit.rows),
        "condition_number": found.fit.condition_number,
        "condition_number_scaled": found.fit.condition_number_scaled,
        "minimal": parameter_records(
            found.model.minimal_units,
            found.fit.parameters,
            found.fit.standard_deviations,
            found.correlated.standard_deviations,
            found.bias,
            found.standard_deviations,
        ),
        "physical": _physical(found, 0) if found.physical else {},
        "known": {name: {"value": v, "unit": unit} for name, (v, unit) in found.model.known.items()},
        "physical_branches": [_physical(found, i) for i in range(1, len(found.physical))],
        # as `std_corrected`; the physical ones of the first branch
        "covariance": {
            "minimal": found.covariance.tolist(),
            "physical": found.physical[0].propagated(found.covariance).tolist() if found.physical else None,
        },
        "relations": _relations(found),
        "residual": _residuals(found, found.residuals),
        "correlation": {
            "status": found.correlated.status,
            "bandwidth": found.correlated.bandwidth,
            "effective_samples": found.correlated.effective_samples,
        },
        "bias_dominates": list(found.dominated_by_bias),
        "timing": _timing(found),
        "assumptions": list(found.model.assumptions),
    }
    if validation is not None:
        record["validation"] = {"log": validation.log, "residual": _residuals(found, validation.residuals)}
    return record


def _filter(prepared: Preparation) -> dict[str, Any]:
    return {
        "cutoff_hz": prepared.cutoff_hz,
        "order": prepared.order,
        "decimation": prepared.decimation,
        "difference_order": prepared.difference_order,
        "force_filtered": prepared.filter_force,
        "trim": list(prepared.trim or ()),
        "late_s": dict(prepared.late),
    }


def parameter_records(
    units: Any,
    values: FloatArray,
    stds: FloatArray,
    corrected: FloatArray,
    bias: Bias | None = None,
    widened: FloatArray | None = None,
) -> dict[str, dict[str, Any]]:
    """Records of parameters by name: values, deviations, units."""
    relative = relative_standard_deviation(values, stds)
    relative_corrected = relative_standard_deviation(values, corrected)
    return {
        name: {
            "value": float(values[i]),
            "std": float(stds[i]),
            "relative_std_percent": float(relative[i]),
            "std_corrected": float(corrected[i]),
            "relative_std_corrected_percent": float(relative_corrected[i]),
            "deviation": float(corrected[i] if widened is None else widened[i]),
            "bias": None if bias is None else float(bias.total[i]),
            "bias_by_noise": None if bias is None else float(bias.noise[i]),
            "unit": unit,
        }
        for i, (name, unit) in enumerate(units.items())
    }


def _physical(found: Identification, branch: int) -> dict[str, dict[str, Any]]:
    estimate = found.physical[branch]
    classical = estimate.propagated_deviations(found.fit.covariance)
    corrected = estimate.propagated_deviations(found.correlated.covariance)
    bias = None if found.bias is None else found.bias.mapped(estimate.sensitivity)
    values = found.model.physical_units, estimate.parameters, classical, corrected, bias
    return parameter_records(*values, found.widened_deviations(estimate))


def _timing(found: Identification) -> dict[str, Any] | None:
    """Estimated delay of the force; ``late_s`` has the sign of ``late``."""
    timing = found.timing
    if timing is None:
        return None
    return {
        "signal": timing.signal,
        "late_s": timing.late,
        "std_s": timing.deviation,
        "samples": timing.samples,
        "suggested_s": timing.suggested,
        "significant": timing.is_significant,
        "remedy": timing.remedy if timing.is_significant and timing.may_be_clock else None,
    }


def _relations(found: Identification) -> dict[str, Any] | None:
    """Chi-square of the relations between the minimal parameters."""
    if not found.physical or not found.physical[0].relations:
        return None
    estimate = found.physical[0]
    return {
        "count": estimate.relations,
        "chi_square": estimate.disagreement,
        "probability": estimate.disagreement_probability,
    }


def _residuals(found: Identification, residuals: Sequence[EquationResidual]) -> dict[str, dict[str, Any]]:
    outputs = [residual.output for residual in residuals]
    return {
        # an output that occurs again gets the number of its equation
        name if outputs.index(name) == i else f"{name} (equation {i + 1})": {
            "rms": r.rms,
            "relative": r.relative,
            "unit": found.output_units.get(r.output, ""),
            "norm": r.norm,
            "std": r.deviation,
            "rows": r.rows,
        }
        for i, (name, r) in enumerate(zip(outputs, residuals, strict=True))
    }


def print_identification(record: dict[str, Any], console: Console | None = None) -> None:
    """Print the record of `identification_record`."""
    console = console or report_console()
    measured, logs = ", ".join(record["measured"]), ", ".join(record["log"])
    console.print(f"[bold]{record['axis']}[/bold] from {measured}: {logs}", markup=True)
    console.print(_settings_line(record))
    if record["physical"]:
        console.print(_parameter_table("Physical parameters", record["physical"]))
    known = ", ".join(f"{name} {p['value']:.7g} {p['unit']}" for name, p in record["known"].items())
    if known:
        console.print(f"known: {known}", markup=False)
    for i, branch in enumerate(record["physical_branches"]):
        console.print(_parameter_table(f"Physical parameters, solution {i + 2}", branch))
    shown = {p["value"] for p in record["physical"].values()}
    if any(p["value"] not in shown for p in record["minimal"].values()):
        console.print(_parameter_table("Minimal parameters", record["minimal"]))
    console.print(_residual_table("Residual", record["residual"]))
    if "validation" in record:
        log, residual = record["validation"]["log"], record["validation"]["residual"]
        console.print(_residual_table(f"Residual on {log}", residual))
        kept = min(output["rows"] for output in residual.values())
        if kept <= len(record["minimal"]):
            console.print(
                f"note: {kept} rows of {log} are left by filter, decimation and reversals, "
                f"no more than the {len(record['minimal'])} parameters: take a longer log to judge the prediction",
                markup=False,
            )
    relations = record["relations"]
    if relations is not None:
        console.print(
            f"{relations['count']} relation(s) between the minimal parameters disagree by "
            f"chi-square {relations['chi_square']:.3g} "
            f"(probability {relations['probability']:.2g} if structure and noise are as assumed)"
        )
    for line in (*record["notes"], *record["assumptions"]):
        console.print(f"note: {line}", markup=False)
    if record["status"] != "ok":
        console.print(f"[bold]{record['status']}[/bold]: {record['message']}")


def shared_record(found: SharedIdentification) -> dict[str, Any]:
    """Record of `symid identify --known ... --json`: the physical parameters, and each group of logs."""
    first, units = found.groups[0], found.physical_units.items()
    deviations = found.standard_deviations.tolist()
    return {
        "axis": found.axis.name,
        "measured": list(first.model.measured),
        "method": first.fit.method,
        "log": [log for group in found.groups for log in group.logs],
        "status": found.status,
        "message": found.message,
        "notes": list(found.constraint_notes),
        "physical": {
            name: {"value": value, "std": std, "deviation": std, "unit": unit}
            for (name, unit), value, std in zip(units, found.values.tolist(), deviations, strict=True)
        },
        "relations": {
            "number": found.relations,
            "disagreement": found.disagreement,
            "probability": found.probability,
        },
        "groups": [
            {**identification_record(group), "known": dict(known)}
            for group, known in zip(found.groups, found.known, strict=True)
        ],
    }


def print_shared(record: dict[str, Any], console: Console | None = None) -> None:
    """Print the record of `shared_record`."""
    console = console or report_console()
    console.print(f"[bold]{record['axis']}[/bold] from {', '.join(record['measured'])}", end="")
    console.print(f", {len(record['groups'])} groups of logs: {record['status']}", markup=False)
    if record["message"]:
        console.print(record["message"], markup=False)
    for group in record["groups"]:
        given = ", ".join(f"{name} = {value:.6g}" for name, value in group["known"].items())
        console.print(f"  {given}: {', '.join(group['log'])}", markup=False)
    table = TextTable("", "parameter", "value", "deviation", "% of value", "unit")
    for name, one in record["physical"].items():
        table.add(name, f"{one['value']:.6g}", f"{one['deviation']:.2g}", _relative(one), one["unit"])
    console.print(table)
    for line in record["notes"]:
        console.print(f"note: {line}", markup=False)


def _settings_line(record: dict[str, Any]) -> str:
    settings = record["filter"]
    if record["condition_number"] is None:
        return ""
    if record["method"] == "oe":
        noise = (f"{name} {n['std']:.3g} {n['unit']}" for name, n in record["noise"].items())
        how = f"no filter, noise found: {', '.join(noise)}"
    else:
        how = f"cutoff {settings['cutoff_hz']:g} Hz (order {settings['order']}), decimation {settings['decimation']}"
    condition = f"condition {record['condition_number']:.6g} ({record['condition_number_scaled']:.4g} scaled)"
    return f"{sum(record['rows'])} rows, {how}, {condition}\n"


def _parameter_table(title: str, parameters: dict[str, dict[str, Any]]) -> TextTable:
    numbers = ("value", "deviation", "% of value", "bias", "white std")
    table = TextTable(title, "", *numbers, "unit", right=numbers)
    for name, p in parameters.items():
        bias = MISSING if p["bias"] is None else significant(p["bias"], 2)
        uncertainty = (significant(p["deviation"]), _relative(p), bias, significant(p["std"]))
        table.add(name, _rounded_to_deviation(p["value"], p["std"]), *uncertainty, p["unit"])
    return table


def _relative(parameter: dict[str, Any]) -> str:
    """Deviation in per cent of the value."""
    value = abs(parameter["value"])
    return significant(100 * parameter["deviation"] / value if value else math.nan, 3)


def _residual_table(title: str, residuals: dict[str, dict[str, Any]]) -> TextTable:
    numbers = ("rows", "norm", "rms", "std", "relative")
    table = TextTable(title, "output", *numbers, "unit", right=numbers)
    for name, r in residuals.items():
        relative = f"{100 * r['relative']:.4f} %" if math.isfinite(r["relative"]) else MISSING
        sizes = (f"{r['norm']:.7g}", f"{r['rms']:.5g}", f"{r['std']:.5g}")
        table.add(name, str(r["rows"]), *sizes, relative, r["unit"])
    return table


def _rounded_to_deviation(value: float, deviation: float) -> str:
    """Value with the digits that its deviation leaves, and some more for comparison."""
    if not math.isfinite(value) or not math.isfinite(deviation) or deviation <= 0 or value == 0:
        return significant(value, 7)
    digits = math.floor(math.log10(abs(value))) - math.floor(math.log10(deviation)) + 5
    return significant(value, min(max(digits, 4), 10))
