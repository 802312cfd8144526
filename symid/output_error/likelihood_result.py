"""Result of an identification by maximum likelihood."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import polars as pl

from symid.arrays import FloatArray
from symid.axis import Axis
from symid.codegen import GeneratedModel
from symid.data import Log, in_memory
from symid.errors import SettingError
from symid.identification.parameters import jacobian
from symid.identification.results import frame_of, headline_of
from symid.identification.signals import LogLike, log_of
from symid.output_error.error_model import ErrorModel
from symid.output_error.likelihood_fit import LikelihoodFit
from symid.output_error.predicted_log import OutputErrorPrediction
from symid.output_error.prediction_error import PredictionError
from symid.shown import Shown

LikelihoodStatus = Literal[
    "ok", "no_start", "not_converged", "not_physical", "undetermined", "recording", "timing", "poor_fit"
]


@dataclass(frozen=True, eq=False, repr=False)
class OutputErrorIdentification(Shown):
    """Parameters of an axis by maximum likelihood on the exactly sampled axis."""

    axis: Axis
    """The declared axis."""
    model: GeneratedModel
    """Names, units and maps of the parameters."""
    logs: tuple[Log, ...]
    """Logs that they were identified from."""
    comparison: ErrorModel
    """Model that the logs were compared with."""
    fit: LikelihoodFit | None
    """None if there was no start at which the axis could be evaluated."""
    status: LikelihoodStatus
    """Either "ok", or what keeps the result from being complete."""
    message: str
    """Meaning of the status here and the cure."""
    notes: tuple[str, ...]
    """Remarks for the user."""
    lacking: FloatArray | float = 0.0
    """Squares of what effects that the model lacks may have moved, as least squares sees them in the same logs; shape
    (n_physical,)."""

    @property
    def headline(self) -> str:
        """Status and parameters."""
        values, units = self.physical_parameters, self.model.physical_units
        deviations = self.physical_deviations if values else np.empty(0)
        return headline_of(self.model, self.status, values, deviations, units)

    def to_frame(self) -> pl.DataFrame:
        """A polars data frame of the parameters, as that of an `Identification`."""
        columns = (
            ("minimal", self.minimal_parameters, self.standard_deviations, self.model.minimal_units),
            ("physical", self.physical_parameters, self.physical_deviations, self.model.physical_units),
        )
        return frame_of(columns if self.fit is not None else ())

    @property
    def physical_parameters(self) -> dict[str, float]:
        """Physical parameters by name, SI; nan for those that the sensors do not see."""
        if self.fit is None:
            return {}
        values = self.fit.search.parameters
        return {
            name: values[name] if name in self.fit.search.seen else math.nan
            for name in self.model.physical_units
        }

    @property
    def minimal_parameters(self) -> dict[str, float]:
        """Minimal parameters by name, SI."""
        if self.fit is None:
            return {}
        values = self.model.minimal_parameters(*self._all_values)
        return dict(zip(self.model.minimal_units, map(float, values), strict=True))

    @property
    def parameters(self) -> dict[str, float]:
        """Physical parameters by name, SI: the same as `physical_parameters`."""
        return self.physical_parameters

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the minimal parameters, as deviations are printed, (n_minimal, n_minimal)."""
        return self.minimal_covariance(corrected=True)

    @property
    def standard_deviations(self) -> FloatArray:
        """Standard deviations of the minimal parameters, as they are printed."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def bias(self) -> None:
        """None: the deviations hold the expected shift by noise in the record of the forces."""
        return

    def predict(self, log: LogLike) -> OutputErrorPrediction:
        """The readings of another log that parameters, noise and timing predict; SettingError without parameters."""
        if self.fit is None:
            raise SettingError(f"there are no parameters to predict with: {self.message}")
        log = in_memory(log_of(self.axis, log, self.model.measured))
        search, nuisance = self.fit.search, self.fit.search.nuisance[0]
        error = self.comparison.error(log, late=self.late)
        if not error.is_settled:
            error, nuisance = error.updated(search.parameters, nuisance)
        return error.prediction(log, search.parameters, nuisance)

    @property
    def reading_units(self) -> dict[str, str]:
        """Unit of each sensor used, by its signal."""
        return {signal: str(self.axis.signal_units[signal]) for signal in self.model.measured}

    @property
    def predictions(self) -> tuple[OutputErrorPrediction, ...]:
        """One-step predictions of each log."""
        if self.fit is None:
            return ()
        search = self.fit.search
        parts = zip(self.logs, search.errors, search.nuisance, strict=True)
        return tuple(error.prediction(log, search.parameters, nuisance) for log, error, nuisance in parts)

    @property
    def noise(self) -> dict[str, float]:
        """Standard deviations of the noise of the force and of each reading in the first log, SI."""
        return {} if self.fit is None else self.fit.noise

    @property
    def late(self) -> float:
        """Seconds by which the force of the first log is taken to be recorded late."""
        if self.fit is None:
            return 0.0
        error = self.fit.search.errors[0]
        return error.run.late * error.run.period if isinstance(error, PredictionError) else 0.0

    @property
    def physical_deviations(self) -> FloatArray:
        """Standard deviations of the physical parameters, as they are printed."""
        return np.asarray(np.sqrt(np.diag(self.physical_covariance(corrected=True))))

    def physical_covariance(self, *, corrected: bool) -> FloatArray:
        """Covariance of the physical parameters, classical or as deviations are printed, (n_physical, n_physical)."""
        names = list(self.model.physical_units)
        whole = np.full((len(names), len(names)), np.nan)
        if self.fit is not None:
            places = [names.index(name) for name in self.fit.search.seen]
            covariance = self.fit.covariance if corrected else self.fit.linear.covariance
            whole[np.ix_(places, places)] = covariance[: len(places), : len(places)]
        return whole + np.diag(np.broadcast_to(self.lacking, len(names))) if corrected else whole

    def minimal_covariance(self, *, corrected: bool) -> FloatArray:
        """Covariance of the minimal parameters, (n_minimal, n_minimal)."""
        slopes = jacobian(self.model, np.array(self._all_values))
        physical = self.physical_covariance(corrected=corrected)
        unseen = np.isnan(np.diag(physical)) & ~slopes.any(axis=0)
        physical[unseen], physical[:, unseen] = 0.0, 0.0
        return np.asarray(slopes @ physical @ slopes.T)

    @property
    def _all_values(self) -> list[float]:
        assert self.fit is not None
        return [self.fit.search.parameters[name] for name in self.model.physical_units]
