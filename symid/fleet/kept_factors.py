"""Triangular factors of logs as text in a table of results, and joint estimates from such a table."""

import base64
from collections.abc import Callable, Sequence

import numpy as np
import polars as pl

from symid.codegen import GeneratedModel
from symid.errors import SettingError
from symid.estimation import TriangularFactor
from symid.fleet.factors import LogFactors
from symid.fleet.joint_estimate import JointIdentification, identify_jointly
from symid.fleet.results import UNKNOWN_AXIS, groups
from symid.fleet.row import FACTORS


def packed(factors: LogFactors) -> str:
    """Factors as text: all numbers as little-endian doubles in base 64.

    >>> factor = TriangularFactor.empty(1).update(np.array([[3.0], [4.0]]), np.array([3.0, 4.0]))
    >>> text = packed(LogFactors("a", (factor,), np.eye(1), np.zeros((1, 1))))
    >>> len(text), unpacked("a", text).factors[0].rows
    (108, 2)
    """
    head = [factors.dependence, float(len(factors.factors)), float(factors.factors[0].parameters)]
    rows = [float(factor.rows) for factor in factors.factors]
    matrices = [*(factor.R for factor in factors.factors), factors.covariance, factors.systematic]
    numbers = np.concatenate([np.array(head + rows), *(matrix.ravel() for matrix in matrices)])
    return base64.b64encode(numbers.astype("<f8").tobytes()).decode()


def unpacked(log: str, text: str) -> LogFactors:
    """Factors of a log from the text of `packed`; SettingError for any other text."""
    try:
        numbers = np.frombuffer(base64.b64decode(text, validate=True), "<f8")
        n, p = int(numbers[1]), int(numbers[2])
        if min(n, p) < 1 or 3 + n + n * (p + 1) ** 2 + 2 * p * p != numbers.size:
            raise ValueError("another length")
        sizes = (3, n, *[(p + 1) ** 2] * n, p * p, p * p)
        head, rows, *factors, covariance, systematic = np.split(numbers, np.cumsum(sizes)[:-1])
        Rs = [R.reshape(p + 1, p + 1) for R in factors]
        factors_of_log = tuple(TriangularFactor(R, int(count)) for R, count in zip(Rs, rows, strict=True))
        return LogFactors(
            log, factors_of_log, covariance.reshape(p, p), systematic.reshape(p, p), float(head[0])
        )
    except (ValueError, IndexError, OverflowError) as error:
        raise SettingError(f"{log}: its factors are damaged: make the batch with `joint` again") from error


def join_results(
    table: pl.DataFrame,
    model_of: Callable[[str, tuple[str, ...]], GeneratedModel],
    *,
    statuses: Sequence[str] = ("ok",),
    by_folder: bool = False,
) -> dict[str, JointIdentification]:
    """Joint identification of each axis in a table of results, without reading logs.

    Parameters
    ----------
    table : polars.DataFrame
        Results of a batch with `joint`.
    model_of : callable
        Returns the model of an axis and its sensors with which the logs were identified.
    statuses, by_folder
        As in `review_fleet`; axes are named as there.

    Raises
    ------
    SettingError
        If the table contains no factors, or those of an axis cannot be joined.
    """
    if FACTORS not in table.columns:
        raise SettingError("the results hold no factors to join: make the batch with `joint`")
    joined = {}
    for part in groups(table, by_folder):
        rows = part.rows.filter(pl.col("status").is_in(list(statuses)), pl.col(FACTORS).is_not_null())
        logs = [unpacked(str(log), text) for log, text in rows.select("log", FACTORS).iter_rows()]
        if logs and part.axis != UNKNOWN_AXIS:
            joined[part.name] = identify_jointly(model_of(part.axis, part.sensors), logs)
    return joined
