"""What the results of all methods of identification have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, runtime_checkable

from symid.arrays import FloatArray
from symid.identification.deviations.bias import Bias
from symid.identification.results.residuals import EquationResidual
from symid.identification.signals.axis_logs import LogLike


class LogPrediction(Protocol):
    """A log as identified parameters predict it."""

    @property
    def log(self) -> str:
        """Source of the log."""
        ...

    @property
    def residuals(self) -> tuple[EquationResidual, ...]:
        """How well each output is predicted."""
        ...


@runtime_checkable
class IdentificationResult(Protocol):
    """The result of a method of identification."""

    @property
    def status(self) -> str:
        """Either "ok", or what keeps the result from being complete."""
        ...

    @property
    def message(self) -> str:
        """Meaning of the status here and the cure; empty if all is well."""
        ...

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks for the user."""
        ...

    @property
    def parameters(self) -> Mapping[str, float]:
        """Physical parameters by name, SI; minimal ones if the method knows these alone."""
        ...

    @property
    def physical_parameters(self) -> Mapping[str, float]:
        """Physical parameters by name, SI; empty if there are none."""
        ...

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the minimal parameters; of those that groups of logs share, of the physical ones."""
        ...

    @property
    def standard_deviations(self) -> FloatArray:
        """Standard deviations of the same parameters, as they are printed."""
        ...

    @property
    def bias(self) -> Bias | None:
        """Expected error of the minimal parameters; None if it is not stated apart from the deviations."""
        ...

    def predict(self, log: LogLike) -> LogPrediction:
        """Another log as the parameters predict it."""
        ...
