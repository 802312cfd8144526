"""An identification by maximum likelihood as a JSON record, of the form of `identification_record`."""

import math
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from symid.output_error import OutputErrorIdentification, OutputErrorPrediction
from symid.report.tables.identification import parameter_records


def output_error_record(
    result: OutputErrorIdentification, validation: OutputErrorPrediction | None = None
) -> dict[str, Any]:
    """Record of `symid identify --method oe --json`; the residual is that of the one-step predictions."""
    fit = result.fit
    record: dict[str, Any] = {
        "axis": result.model.axis,
        "measured": list(result.model.measured),
        "method": "oe",
        "log": [log.source for log in result.logs],
        "status": result.status,
        "message": result.message,
        "notes": list(result.notes),
        "filter": {"cutoff_hz": None, "order": None, "decimation": 1},
        "force": {
            "course": result.comparison.force,
            "late_s": result.late,
            "timing": "estimated" if result.comparison.free_timing else "declared",
        },
        "noise": {
            n: {"std": std, "unit": str(result.axis.signal_units[n])} for n, std in result.noise.items()
        },
        "samples": sum(log.n_samples for log in result.logs),
        "rows": [] if fit is None else list(fit.linear.rows),
        "condition_number": None if fit is None else fit.linear.condition_number,
        "condition_number_scaled": None if fit is None else fit.linear.condition_number_scaled,
        "minimal": _output_error_parameters(result, "minimal"),
        "physical": _output_error_parameters(result, "physical"),
        "known": {name: {"value": v, "unit": unit} for name, (v, unit) in result.model.known.items()},
        "physical_branches": [],
        "covariance": None
        if fit is None
        else {
            "minimal": result.minimal_covariance(corrected=True).tolist(),
            "physical": result.physical_covariance(corrected=True).tolist(),
        },
        "relations": None,
        "residual": _prediction_errors(result, result.predictions),
        "assumptions": [],
    }
    if validation is not None:
        record["validation"] = {"log": validation.log, "residual": _prediction_errors(result, [validation])}
    return record


def _output_error_parameters(
    result: OutputErrorIdentification, kind: Literal["minimal", "physical"]
) -> dict[str, dict[str, Any]]:
    if result.fit is None:
        return {}
    units, values, covariance = (
        (result.model.minimal_units, result.minimal_parameters, result.minimal_covariance)
        if kind == "minimal"
        else (result.model.physical_units, result.physical_parameters, result.physical_covariance)
    )
    classical, corrected = (np.sqrt(np.diag(covariance(corrected=which))) for which in (False, True))
    return parameter_records(units, np.array(list(values.values())), classical, corrected)


def _prediction_errors(
    result: OutputErrorIdentification, predictions: Sequence[OutputErrorPrediction]
) -> dict[str, dict[str, Any]]:
    """Innovations of each reading over all logs."""
    units, errors = result.reading_units, {}
    for j, (name, unit) in enumerate(units.items()):
        parts = [prediction.residuals[j] for prediction in predictions]
        if not parts:
            continue
        rows, norm = sum(part.rows for part in parts), math.hypot(*(part.norm for part in parts))
        whole = math.hypot(*(part.norm / part.relative for part in parts))
        errors[name] = {
            "rms": norm / math.sqrt(rows),
            "relative": norm / whole,
            "unit": unit,
            "norm": norm,
            "std": norm / math.sqrt(rows),
            "rows": rows,
        }
    return errors
