"""Review of a fleet from a table of results: by axis, by parameter, and over all axes."""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np
import polars as pl
import scipy

from symid.arrays import FloatArray
from symid.fleet.control_chart import ControlChart, control_chart
from symid.fleet.results import (
    Group,
    Units,
    checked_results,
    count_effects,
    groups,
    moments,
    numbers_in,
    parameter_names,
    without_repeats,
)
from symid.fleet.review_records import AxisReview, FleetReview, Outlier, ParameterReview
from symid.fleet.review_sentence import review_sentence
from symid.fleet.spread import judge_spread, robust_deviation, spread_between

_LEAST_OUTLYING = 3.5  # smallest robust z-score of an outlier (Iglewicz and Hoaglin 1993)
_FALSE_OUTLIERS = 0.05  # probability of any in a fleet without outliers


def review_fleet(
    table: pl.DataFrame,
    *,
    units: Units | None = None,
    statuses: Sequence[str] = ("ok",),
    without: Sequence[str] = (),
    by_folder: bool = False,
    by_name: bool = False,
) -> FleetReview:
    """Review the results of a batch.

    Parameters
    ----------
    table : polars.DataFrame
        One row per log with `log`, `axis`, `status`; `NAME` and `NAME_std` for each parameter; `recorded` (ISO) for
        charts over time; `effect` and `at` of a diagnosis.
    units : mapping, optional
        Units by axis, sensors and parameter, from `Batch.units` or `units_in`.
    statuses : sequence of str
        Statuses of the logs whose parameters are used.
    without : sequence of str
        Parameters that may differ from log to log, such as the unknown zero of a sensor.
    by_folder : bool
        Whether the folder of a log identifies its machine.
    by_name : bool
        Whether logs are ordered by name instead of `recorded`, the time of the file, which copying may have changed.

    Raises
    ------
    SettingError
        If the table has no column that all results have.

    Examples
    --------
    >>> noise = np.random.default_rng(5).standard_normal(30)
    >>> logs = [f"{i:02}.parquet" for i in range(30)]
    >>> mass = {"M": 20 + 0.1 * noise, "M_std": np.full(30, 0.1)}
    >>> review_fleet(pl.DataFrame({"log": logs, "axis": "rigid_1m", "status": "ok", **mass})).sentence
    '30 logs of rigid_1m, all ok. No parameter differs from run to run beyond the intervals.'
    """
    table = checked_results(table)
    if by_name:
        table = table.sort("log").drop("recorded", strict=False)
    names = [name for name in parameter_names(table) if name not in without]
    parts = groups(table, by_folder)
    axes = tuple(_axis_review(part, names, statuses, units or {}) for part in parts)
    counts = _counts(table, "status")
    effects = count_effects(
        (part.name, effect, at)
        for part in parts
        if {"effect", "at"} <= set(part.rows.columns)
        for effect, at in part.rows.select("effect", "at").iter_rows()
    )
    verdicts = _counts(table, "verdict")
    return FleetReview(table, axes, counts, verdicts, effects, review_sentence(axes, counts, effects))


def _axis_review(group: Group, names: Sequence[str], statuses: Sequence[str], units: Units) -> AxisReview:
    rows = group.rows.filter(pl.col("status").is_in(list(statuses)))
    group_units = units.get(group.axis, {}).get(",".join(group.sensors), {})
    known = [name for name in names if np.isfinite(numbers_in(rows, name)).any()]
    # A minimal parameter that equals a physical one has the same numbers under a second name and is left out.
    last = {numbers_in(rows, name).tobytes(): name for name in known}
    distinct = [
        name for name in without_repeats(known, group_units) if last[numbers_in(rows, name).tobytes()] == name
    ]
    parameters = tuple(
        one for one in (_parameter_review(rows, name, group_units) for name in distinct) if one is not None
    )
    return AxisReview(
        name=group.name,
        axis=group.axis,
        logs=group.rows.height,
        trusted=rows.height,
        statuses=_counts(group.rows, "status"),
        parameters=parameters,
        verdict=judge_spread({one.name: one.spread for one in parameters}),
    )


def _parameter_review(rows: pl.DataFrame, name: str, units: Mapping[str, str]) -> ParameterReview | None:
    """A parameter over the logs; None if no log has it."""
    values, deviations = numbers_in(rows, name), numbers_in(rows, f"{name}_std")
    known = np.isfinite(values)
    if not known.any():
        return None
    rows = rows.filter(pl.Series(known))
    values, deviations = values[known], deviations[known]
    chart = control_chart(values, deviations, moments(rows))
    counted = np.ones(values.size, dtype=bool)
    counted[chart.order[chart.isolated]] = False
    logs = tuple(map(str, rows["log"]))
    return ParameterReview(
        name=name,
        logs=logs,
        median=float(np.median(values)),
        spread=spread_between(values[counted], deviations[counted]),
        within=chart.between,
        chart=chart,
        outliers=_outliers(logs, values, deviations, chart),
        unit=units.get(name, ""),
    )


def _outliers(
    logs: Sequence[str], values: FloatArray, deviations: FloatArray, chart: ControlChart
) -> tuple[Outlier, ...]:
    """Values far from their level, measured by the scatter of the others and by their own interval."""
    if values.size < 5:
        return ()
    level = np.full(values.size, np.median(values))
    if chart.changes:
        level[chart.order] = chart.centre
    away = values - level
    scale = np.fmax(robust_deviation(away), deviations)
    with np.errstate(divide="ignore", invalid="ignore"):
        z = away / scale
    limit = max(_LEAST_OUTLYING, -float(scipy.special.ndtri(_FALSE_OUTLIERS / 2 / values.size)))
    far = [i for i in np.argsort(-np.abs(z)) if abs(z[i]) > limit]
    return tuple(Outlier(logs[i], float(values[i]), float(level[i]), float(z[i])) for i in far)


def _counts(rows: pl.DataFrame, column: str) -> dict[str, int]:
    """Number of rows by value of a column, the most frequent first; empty without the column."""
    if column not in rows.columns:
        return {}
    return dict(Counter(str(value) for value in rows[column] if value is not None).most_common())
