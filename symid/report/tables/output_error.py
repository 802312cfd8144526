"""An identification by maximum likelihood as a JSON record, of the form of `identification_record`."""

import math
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from symid.output_error import OutputErrorIdentification, OutputErrorPrediction
from symid.report.tables.identification import parameter_records


def output_error_record(
    found: OutputErrorIdentification, validation: OutputErrorPrediction | None = None
) -> dict[str, Any]:
    """Record of `symid identify --method oe --json`; the residual is that of the one-step predictions."""
    fit = found.fit
    record: dict[str, Any] = {
        "axis": found.model.axis,
        "measured": list(found.model.measured),
        "method": "oe",
        "log": [log.source for log in found.logs],
        "status": found.status,
        "message": found.message,
        "notes": list(found.notes),
        "filter": {"cutoff_hz": None, "order": None, "decimation": 1},
        "force": {
            "course": found.comparison.force,
            "late_s": found.late,
            "timing": "estimated" if found.comparison.free_timing else "declared",
        },
        "noise": {n: {"std": std, "unit": str(found.axis.signal_units[n])} for n, std in found.noise.items()},
        "samples": sum(log.n_samples for log in found.logs),
        "rows": [] if fit is None else list(fit.linear.rows),
        "condition_number": None if fit is None else fit.linear.condition_number,
        "condition_number_scaled": None if fit is None else fit.linear.condition_number_scaled,
        "minimal": _output_error_parameters(found, "minimal"),
        "physical": _output_error_parameters(found, "physical"),
        "known": {name: {"value": v, "unit": unit} for name, (v, unit) in found.model.known.items()},
        "physical_branches": [],
        "covariance": None
        if fit is None
        else {
            "minimal": found.minimal_covariance(corrected=True).tolist(),
            "physical": found.physical_covariance(corrected=True).tolist(),
        },
        "relations": None,
        "residual": _prediction_errors(found, found.predictions),
        "assumptions": [],
    }
    if validation is not None:
        record["validation"] = {"log": validation.log, "residual": _prediction_errors(found, [validation])}
    return record


def _output_error_parameters(
    found: OutputErrorIdentification, kind: Literal["minimal", "physical"]
) -> dict[str, dict[str, Any]]:
    if found.fit is None:
        return {}
    units, values, covariance = (
        (found.model.minimal_units, found.minimal_parameters, found.minimal_covariance)
        if kind == "minimal"
        else (found.model.physical_units, found.physical_parameters, found.physical_covariance)
    )
    classical, corrected = (np.sqrt(np.diag(covariance(corrected=which))) for which in (False, True))
    return parameter_records(units, np.array(list(values.values())), classical, corrected)


def _prediction_errors(
    found: OutputErrorIdentification, predictions: Sequence[OutputErrorPrediction]
) -> dict[str, dict[str, Any]]:
    """Innovations of each reading over all logs."""
    units, errors = found.reading_units, {}
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
