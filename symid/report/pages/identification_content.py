"""What a page shows of an identification, by equations of the motion or by maximum likelihood."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symid.arrays import FloatArray
from symid.data import Log
from symid.identification import Identification, OutputPrediction
from symid.identification.residual_correlation import PredictedOutput, predicted_outputs
from symid.output_error import OutputErrorIdentification, OutputErrorPrediction
from symid.report.tables.identification import identification_record
from symid.report.tables.number_text import significant
from symid.report.tables.output_error import output_error_record

_METHODS = {
    "wls": "weighted least squares (wls)",
    "ols": "ordinary least squares (ols)",
    "iv": "instrumental variables (iv)",
    "oe": "output error, by maximum likelihood (oe)",
}

Lateness = Sequence[tuple[str, Mapping[str, float]]]
"""Title of each log, and the times by which its signals were recorded late, s."""


@dataclass(frozen=True, eq=False)
class IdentifiedEquations:
    """An identification by the equations of the motion, with that of another log by the same parameters."""

    found: Identification
    validation: OutputPrediction | None

    @property
    def record(self) -> dict[str, Any]:
        """Record of the command line."""
        return identification_record(self.found, self.validation)

    @property
    def logs(self) -> tuple[Log, ...]:
        """Logs that the result keeps."""
        return self.found.runs

    @property
    def sources(self) -> list[str]:
        """Files of all logs, that of the validation last."""
        return [*self.found.logs, *([self.validation.log] if self.validation else [])]

    @property
    def outputs(self) -> list[PredictedOutput]:
        """Outputs of the logs that the parameters come from."""
        return predicted_outputs(self.found)

    @property
    def validating(self) -> list[PredictedOutput]:
        """Outputs of the other log."""
        if self.validation is None:
            return []
        run, title = self.validation.observation, validation_title(self.validation.log)
        return [
            PredictedOutput(
                output, title, unit, run.y[j], run.W[j] @ self.validation.parameters, run.valid[j]
            )
            for j, (output, unit) in enumerate(self.found.output_units.items())
        ]

    @property
    def late(self) -> Lateness:
        """Delays that were taken off the signals of each log, s."""
        titles = [*self.found.logs, *(one.log for one in self.validating[:1])]
        observations = [*self.found.observations, *([self.validation.observation] if self.validation else [])]
        return [(title, one.preparation.late) for title, one in zip(titles, observations, strict=True)]

    @property
    def deviations(self) -> FloatArray:
        """Standard deviations of the physical parameters, or of the minimal ones if there are none."""
        return self.found.physical_deviations if self.found.physical else self.found.standard_deviations

    @property
    def values(self) -> Mapping[str, float]:
        """Physical parameters, none if the logs do not determine them."""
        return self.found.physical_parameters

    @staticmethod
    def settings(record: dict[str, Any]) -> list[tuple[str, str]]:
        """Name and value of each setting, in words."""
        one = record["filter"]
        ends = " and ".join(str(samples) for samples in one["trim"]) or "no"
        late = [f"{signal} by {significant(1e6 * by)} us" for signal, by in one["late_s"].items() if by]
        return [
            ("method", _METHODS.get(record["method"], record["method"])),
            ("cutoff frequency", f"{significant(one['cutoff_hz'])} Hz, order {one['order']}"),
            ("force", "filtered as the motion is" if one["force_filtered"] else "not filtered"),
            ("decimation", f"one row for every {one['decimation']} samples"),
            ("differences", f"of order of accuracy {one['difference_order']}"),
            ("left out at the ends", f"{ends} samples"),
            ("recorded late", ", ".join(late) or "nothing"),
            _condition(record),
        ]


@dataclass(frozen=True, eq=False)
class IdentifiedReadings:
    """An identification by maximum likelihood, with the prediction of another log."""

    found: OutputErrorIdentification
    validation: OutputErrorPrediction | None

    @property
    def record(self) -> dict[str, Any]:
        """Record of the command line."""
        return output_error_record(self.found, self.validation)

    @property
    def logs(self) -> tuple[Log, ...]:
        """Logs that the result keeps."""
        return self.found.logs

    @property
    def sources(self) -> list[str]:
        """Files of all logs, that of the validation last."""
        return [*(log.source for log in self.logs), *([self.validation.log] if self.validation else [])]

    @property
    def outputs(self) -> list[PredictedOutput]:
        """Readings of the logs that the parameters come from."""
        return [part for one in self.found.predictions for part in self._readings(one, one.log)]

    @property
    def validating(self) -> list[PredictedOutput]:
        """Readings of the other log."""
        one = self.validation
        return self._readings(one, validation_title(one.log)) if one else []

    def _readings(self, one: OutputErrorPrediction, title: str) -> list[PredictedOutput]:
        of_readings = zip(self.found.reading_units.items(), one.readings.T, one.innovations.T, strict=True)
        return [
            PredictedOutput(
                signal, title, unit, readings, readings - np.nan_to_num(errors), np.isfinite(errors)
            )
            for (signal, unit), readings, errors in of_readings
        ]

    @property
    def late(self) -> Lateness:
        """Delays that were taken off the signals of each log, s."""
        late = {drive.signal: self.found.late for drive in self.found.axis.drives}
        titles = [*(log.source for log in self.logs), *(one.log for one in self.validating[:1])]
        return [(title, late) for title in titles]

    @property
    def deviations(self) -> FloatArray:
        """Standard deviations of the physical parameters."""
        return self.found.physical_deviations

    @property
    def values(self) -> Mapping[str, float]:
        """Physical parameters, nan where the sensors do not see them."""
        return self.found.physical_parameters

    @staticmethod
    def settings(record: dict[str, Any]) -> list[tuple[str, str]]:
        """Name and value of each setting, in words."""
        force, noise = record["force"], record["noise"].items()
        return [
            ("method", _METHODS["oe"]),
            ("course of the force between samples", force["course"]),
            ("timing of the force", f"{_later(force['late_s'])}, {force['timing']}"),
            ("noise, rms", ", ".join(f"{name} {significant(n['std'])} {n['unit']}" for name, n in noise)),
            ("samples", str(record["samples"])),
            _condition(record),
        ]


def validation_title(source: str) -> str:
    """Title of a log that the parameters do not come from."""
    return f"{source} (validation)"


def _later(late: float) -> str:
    """When a force acts that was recorded late, by seconds.

    >>> _later(-125e-6), _later(0.0)
    ('acts 125 us after its record', 'acts when it was recorded')
    """
    if late == 0.0:
        return "acts when it was recorded"
    return f"acts {significant(abs(1e6 * late))} us {'before' if late > 0 else 'after'} its record"


def _condition(record: dict[str, Any]) -> tuple[str, str]:
    scaled, plain = (significant(record[name]) for name in ("condition_number_scaled", "condition_number"))
    return "condition number", f"{scaled} scaled, {plain} as it is"
