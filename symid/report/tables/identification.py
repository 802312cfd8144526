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
    result: Identification, validation: OutputPrediction | None = None
) -> dict[str, Any]:
    """Record of `symid identify --json`.

    ``std`` is the classical deviation of the paper [22]-[30], which takes the residual as white; ``std_corrected``
    allows for its correlation, ``deviation`` also for scatter between parts of the logs and for ``bias``, the expected
    systematic error. ``bias_dominates`` names parameters whose bias exceeds a tenth of the corrected deviation.
    """
    covariance = result.covariance
    record: dict[str, Any] = {
        "axis": result.model.axis,
        "measured": list(result.model.measured),
        "method": result.fit.method,
        "log": list(result.logs),
        "status": result.status,
        "message": result.message,
        "notes": list(result.notes),
        "filter": _filter(result.observations[0].preparation),
        "samples": max(result.fit.rows),
        "rows": list(result.fit.rows),
        "condition_number": result.fit.condition_number,
        "condition_number_scaled": result.fit.condition_number_scaled,
        "minimal": parameter_records(
            result.model.minimal_units,
            result.fit.parameters,
            result.fit.standard_deviations,
            result.correlated.standard_deviations,
            result.bias,
            result.standard_deviations,
        ),
        "physical": _physical(result, 0) if result.physical else {},
        "known": {name: {"value": v, "unit": unit} for name, (v, unit) in result.model.known.items()},
        "physical_branches": [_physical(result, i) for i in range(1, len(result.physical))],
        # as `std_corrected`; the physical ones of the first branch
        "covariance": {
            "minimal": covariance.tolist(),
            "physical": result.physical[0].propagated(covariance).tolist() if result.physical else None,
        },
        "relations": _relations(result),
        "residual": _residuals(result, result.residuals),
        "correlation": {
            "status": result.correlated.status,
            "bandwidth": result.correlated.bandwidth,
            "effective_samples": result.correlated.effective_samples,
        },
        "bias_dominates": list(result.dominated_by_bias),
        "timing": _timing(result),
        "assumptions": list(result.model.assumptions),
    }
    if validation is not None:
        record["validation"] = {"log": validation.log, "residual": _residuals(result, validation.residuals)}
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


def _physical(result: Identification, branch: int) -> dict[str, dict[str, Any]]:
    estimate = result.physical[branch]
    classical = estimate.propagated_deviations(result.fit.covariance)
    corrected = estimate.propagated_deviations(result.correlated.covariance)
    bias = None if result.bias is None else result.bias.mapped(estimate.sensitivity)
    values = result.model.physical_units, estimate.parameters, classical, corrected, bias
    return parameter_records(*values, result.widened_deviations(estimate))


def _timing(result: Identification) -> dict[str, Any] | None:
    """Estimated delay of the force; ``late_s`` has the sign of ``late``."""
    timing = result.timing
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


def _relations(result: Identification) -> dict[str, Any] | None:
    """Chi-square of the relations between the minimal parameters."""
    if not result.physical or not result.physical[0].relations:
        return None
    estimate = result.physical[0]
    return {
        "count": estimate.relations,
        "chi_square": estimate.disagreement,
        "probability": estimate.disagreement_probability,
    }


def _residuals(result: Identification, residuals: Sequence[EquationResidual]) -> dict[str, dict[str, Any]]:
    outputs = [residual.output for residual in residuals]
    return {
        # an output that occurs again gets the number of its equation
        name if outputs.index(name) == i else f"{name} (equation {i + 1})": {
            "rms": r.rms,
            "relative": r.relative,
            "unit": result.output_units.get(r.output, ""),
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
                f"note: {kept} rows of {log} remain after filter, decimation and reversals, "
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


def shared_record(result: SharedIdentification) -> dict[str, Any]:
    """Record of `symid identify --known ... --json`: the physical parameters, and each group of logs."""
    first, units = result.groups[0], result.physical_units.items()
    deviations = result.standard_deviations.tolist()
    return {
        "axis": result.axis.name,
        "measured": list(first.model.measured),
        "method": first.fit.method,
        "log": [log for group in result.groups for log in group.logs],
        "status": result.status,
        "message": result.message,
        "notes": list(result.constraint_notes),
        "physical": {
            name: {"value": value, "std": std, "deviation": std, "unit": unit}
            for (name, unit), value, std in zip(units, result.values.tolist(), deviations, strict=True)
        },
        "relations": {
            "number": result.relations,
            "disagreement": result.disagreement,
            "probability": result.probability,
        },
        "groups": [
            {**identification_record(group), "known": dict(known)}
            for group, known in zip(result.groups, result.known, strict=True)
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
        known = ", ".join(f"{name} = {value:.6g}" for name, value in group["known"].items())
        console.print(f"  {known}: {', '.join(group['log'])}", markup=False)
    table = TextTable("", "parameter", "value", "deviation", "% of value", "unit")
    for name, entry in record["physical"].items():
        table.add(name, f"{entry['value']:.6g}", f"{entry['deviation']:.2g}", _relative(entry), entry["unit"])
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
