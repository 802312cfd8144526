"""Data of one log for a joint identification: triangular factors, covariance and expected systematic errors."""

from dataclasses import dataclass

import numpy as np

from symid.arrays import FloatArray, read_only
from symid.errors import SettingError
from symid.estimation import TriangularFactor
from symid.identification import Identification
from symid.identification.deviations import Discrepancy


@dataclass(frozen=True, eq=False)
class LogFactors:
    """Data of one log for a joint identification."""

    log: str  # source of the log
    factors: tuple[TriangularFactor, ...]  # one for each equation
    # shape (n_parameters, n_parameters): covariance of the minimal parameters from this log alone, corrected
    # for the correlation of its residual; nan where this log does not determine them
    covariance: FloatArray
    # shape (n_parameters, n_parameters): squares of the systematic errors to be expected
    systematic: FloatArray
    # rows per independent sample of the residual, 1 for a white one. It is used if `covariance` has nan
    dependence: float = 1.0

    def __post_init__(self) -> None:
        if not self.factors:
            raise SettingError(f"{self.log}: no triangular factor: one for each equation is required")
        for name in ("covariance", "systematic"):
            matrix = np.array(getattr(self, name), dtype=np.float64)
            if matrix.shape != (self.factors[0].parameters,) * 2:
                raise SettingError(
                    f"{self.log}: {name} of shape {matrix.shape} for {self.factors[0].parameters} parameters: "
                    "it must be square with a row for each"
                )
            object.__setattr__(self, name, read_only(matrix))


def log_factors(identification: Identification) -> LogFactors:
    """Triangular factors of an identified log, from which it can be joined without being read again.

    Parameters
    ----------
    identification : Identification
        Identification from a single log.

    Raises
    ------
    SettingError
        If it was identified from several logs.

    Examples
    --------
    >>> from symid import identify, load_axis, load_generated, read_axis_log
    >>> from symid.axis import shipped_folder
    >>> file = shipped_folder("data") / "emps" / "DATA_EMPS.mat"
    >>> log = read_axis_log(load_axis("emps"), file, columns={"q": "qm"})
    >>> [factor.R.shape for factor in log_factors(identify(load_generated("emps"), log)).factors]
    [(5, 5)]
    """
    if len(identification.logs) != 1:
        raise SettingError(
            f"identified from {len(identification.logs)} logs: identify each log alone to join them"
        )
    count = identification.correlated.effective_samples
    dependence = max(1.0, max(identification.fit.rows) / count) if np.isfinite(count) and count > 0 else 1.0
    variances, by_segments = (
        np.diag(identification.covariance),
        0.0 if identification.scatter is None else np.diag(identification.scatter),
    )
    wider = np.sqrt(
        np.maximum(np.divide(by_segments, variances, out=np.ones_like(variances), where=variances > 0), 1.0)
    )
    errors = [_likely_change(discrepancy) for discrepancy in identification.discrepancies]
    if identification.bias is not None:
        errors.append(identification.bias.total)
    systematic = sum(
        (np.outer(error, error) for error in errors), start=np.zeros((variances.size, variances.size))
    )
    covariance = identification.covariance * np.outer(wider, wider)
    return LogFactors(identification.logs[0], identification.fit.factors, covariance, systematic, dependence)


def _likely_change(discrepancy: Discrepancy) -> FloatArray:
    """Change of the minimal parameters, as large as its variance states, signed as the clearest alternative."""
    noise = np.diag(discrepancy.covariance)
    clear = np.square(discrepancy.changes) / np.where(noise > 0, noise, np.inf)
    signs = np.sign(discrepancy.changes[np.argmax(clear.max(axis=1))])
    return np.asarray(signs * np.sqrt(discrepancy.variance(np.eye(noise.size))))
