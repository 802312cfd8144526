"""Result of an identification from groups of logs with different known values."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import scipy

from symid.arrays import FloatArray
from symid.axis import Axis
from symid.codegen import model_of
from symid.data import Log, LongLog
from symid.errors import SettingError
from symid.identification.results.identification_result import Identification, headline_of
from symid.identification.results.predicted_output import OutputPrediction, predicted_output
from symid.identification.signals.axis_logs import LogLike
from symid.shown import Shown


@dataclass(frozen=True, eq=False, repr=False)
class SharedIdentification(Shown):
    """Physical parameters that groups of logs share."""

    axis: Axis
    """The declared axis."""
    groups: tuple[Identification, ...]
    """One for each set of known values."""
    known: tuple[Mapping[str, float], ...]
    """The known values of each group, SI."""
    physical_units: Mapping[str, str]
    """Unit of each parameter."""
    values: FloatArray
    """Values of the parameters; nan where they are not determined; shape (n_physical,)."""
    covariance: FloatArray
    """Their covariance, nan where they are not determined."""
    disagreement: float
    """Chi-square of the disagreement between the groups."""
    relations: int
    """Its degrees of freedom."""
    status: str
    """Either "ok", or what keeps the result from being complete."""
    message: str
    """Meaning of the status; empty for "ok"."""
    constraint_notes: tuple[str, ...] = ()
    """Effect of bounds and priors on the result."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Effect of bounds and priors on the result, and notes on the groups of logs."""
        return tuple(
            dict.fromkeys((*self.constraint_notes, *(n for group in self.groups for n in group.notes)))
        )

    @property
    def physical_parameters(self) -> dict[str, float]:
        """Physical parameters by name, SI."""
        return dict(zip(self.physical_units, map(float, self.values), strict=True))

    @property
    def parameters(self) -> dict[str, float]:
        """Physical parameters by name, SI: the same as `physical_parameters`."""
        return self.physical_parameters

    @property
    def bias(self) -> None:
        """None: each of the groups has its own."""
        return

    @property
    def standard_deviations(self) -> FloatArray:
        """Standard deviations of the physical parameters, SI, shape (n_physical,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    def predict(self, log: LogLike, known: Mapping[str, float] | None = None) -> OutputPrediction:
        """The output that the parameters predict on another log.

        Parameters
        ----------
        log : Log, path-like, data frame or mapping
            A log that took no part in it.
        known : mapping of str to float, optional
            Its known values, SI; needed for all but the logs of the identification, unless they agree in them.

        Raises
        ------
        LogError, SettingError
            If the log does not have a signal, or its known values or parameters are missing.
        """
        if self.status == "no_physical_parameters" or not np.all(np.isfinite(self.values)):
            raise SettingError(f"there are no parameters to predict with: {self.message}")
        axis = self.axis.with_known(self._known_of(log) if known is None else known)
        model = model_of(axis, self.groups[0].model.measured)
        fit = replace(self.groups[0].fit, solution=np.asarray(model.minimal_parameters(*self.values)))
        return predicted_output(model, fit, self.groups[0].observations[0].preparation, log, axis)

    def _known_of(self, log: LogLike) -> Mapping[str, float]:
        """Known values of a log of the identification, or of any log if there is one group."""
        source = log.source if isinstance(log, (Log, LongLog)) else log
        for group, values in zip(self.groups, self.known, strict=True):
            if len(self.groups) == 1 or source in group.logs:
                return values
        raise SettingError(
            f"{source} has no known {', '.join(self.known[0])}: give predict(log, known={{...}})"
        )

    @property
    def probability(self) -> float:
        """Probability of a disagreement at least this large under the model; nan without degrees of freedom."""
        return (
            float(scipy.special.chdtrc(self.relations, self.disagreement))
            if self.relations > 0
            else float("nan")
        )

    @property
    def headline(self) -> str:
        """Status and parameters in one line."""
        model = self.groups[0].model
        return headline_of(
            model, self.status, self.physical_parameters, self.standard_deviations, self.physical_units
        )
