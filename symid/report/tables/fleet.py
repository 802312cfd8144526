"""The summary of a batch and the review of a fleet: JSON record and tables."""

import math
from collections.abc import Mapping
from datetime import datetime
from typing import Any

from rich.console import Console

from symid.fleet import AxisReview, FleetReview, JointIdentification, ParameterReview, TrendChange
from symid.report.tables.console import TextTable, plain, report_console
from symid.report.tables.number_text import MISSING, percent, probability, significant, with_deviation
from symid.text import spoken

_MOST_EFFECTS = 10
_MOST_LINES = 10
_MOST_OUTLIERS = 5
_LARGE = 3.0
"""Relative change above which no percentage is written."""


def fleet_record(
    review: FleetReview, joined: Mapping[str, JointIdentification] | None = None
) -> dict[str, Any]:
    """Record of `symid fleet --json`, with joint results by axis; unknown numbers are nan."""
    return {
        "sentence": review.sentence,
        "logs": review.table.height,
        "statuses": dict(review.statuses),
        "verdicts": dict(review.verdicts),
        "effects": [
            {"effect": count.effect, "at": count.at, "logs": count.logs, "axes": list(count.axes)}
            for count in review.effects
        ],
        "axes": [{**_axis(axis), "joint": _joint((joined or {}).get(axis.name))} for axis in review.axes],
    }


def _joint(joint: JointIdentification | None) -> dict[str, Any] | None:
    """Physical parameters that the logs share, the minimal ones where there are none; None if nothing was joined."""
    if joint is None:
        return None
    values, units = joint.minimal_parameters, joint.model.minimal_units
    deviations = joint.standard_deviations
    if joint.physical:
        values, units = joint.physical_parameters, joint.model.physical_units
        deviations = joint.physical_deviations
    return {
        "logs": len(joint.logs),
        "status": joint.status,
        "message": joint.message,
        "parameters": {
            name: {"value": value, "std": float(std), "unit": str(units[name])}
            for (name, value), std in zip(values.items(), deviations, strict=True)
        },
        "disagreement_probability": joint.disagreement_probability,
    }


def _axis(axis: AxisReview) -> dict[str, Any]:
    return {
        "name": axis.name,
        "axis": axis.axis,
        "logs": axis.logs,
        "used": axis.trusted,
        "statuses": dict(axis.statuses),
        "differs": axis.verdict.differs,
        "differs_in": list(axis.verdict.parameters),
        "verdict": axis.verdict.sentence,
        "parameters": {parameter.name: _parameter(parameter, axis) for parameter in axis.parameters},
    }


def _parameter(parameter: ParameterReview, axis: AxisReview) -> dict[str, Any]:
    spread = parameter.spread
    return {
        "logs": len(parameter.logs),
        "unit": parameter.unit,
        "median": parameter.median,
        "mean": spread.mean,
        "mean_std": spread.mean_std,
        "between": spread.between,
        "between_interval": list(spread.between_interval),
        "between_within_segments": parameter.within,
        "promised": spread.promised,
        "relative_between": spread.relative_between,
        "relative_promised": spread.relative_promised,
        "Q": spread.statistic,
        "probability": spread.probability,
        "probability_adjusted": axis.verdict.probabilities.get(parameter.name, math.nan),
        "differs": parameter.name in axis.verdict.parameters,
        "changes": [change_record(change) for change in parameter.chart.changes],
        "outliers": [
            {"log": far.log, "value": far.value, "level": far.level, "z": far.z} for far in parameter.outliers
        ],
        "outside_limits": [parameter.logs[place] for place in parameter.chart.order[parameter.chart.outside]],
    }


def change_record(change: TrendChange) -> dict[str, Any]:
    """A change as a record; times in ISO."""
    times = {name: getattr(change, name) for name in ("when", "earliest", "latest")}
    return {
        "kind": change.kind,
        **{name: t.isoformat() if isinstance(t, datetime) else t for name, t in times.items()},
        "size": change.size,
        "std": change.std,
        "interval": list(change.interval),
        "relative": change.relative,
        "before": change.before,
        "after": change.after,
        "sentence": change_sentence(change),
    }


def time_of_run(when: datetime | float) -> str:
    """A time of a run as reports write it; the number of the log where times are not known.

    >>> time_of_run(datetime(2026, 3, 1, 6, 30)), time_of_run(12.0)
    ('2026-03-01 06:30', 'log 13')
    """
    return f"{when:%Y-%m-%d %H:%M}" if isinstance(when, datetime) else f"log {when + 1:.0f}"


def change_sentence(change: TrendChange) -> str:
    """A change in words: parameter, time and size.

    >>> change_sentence(TrendChange("step", 29, 29.0, 28.0, 30.0, 0.5, 0.05, (0.4, 0.6), 4.0, 4.5))
    'steps by +12.5 % (+10 to +15 %) at log 30, between log 29 and log 31'
    """
    if abs(change.before) > 2 * change.std and abs(change.relative) < _LARGE:
        low, high = sorted(100 * end / abs(change.before) for end in change.interval)
        size = f"{100 * change.relative:+.3g} % ({low:+.3g} to {high:+.3g} %)"
    else:
        size = f"{change.size:+.3g} ({change.interval[0]:+.3g} to {change.interval[1]:+.3g})"
    when, earliest, latest = map(time_of_run, (change.when, change.earliest, change.latest))
    if change.kind == "drift":
        return f"drifts by {size} from {earliest} to {latest}"
    return f"steps by {size} at {when}, between {earliest} and {latest}"


def print_fleet(record: dict[str, Any], console: Console | None = None) -> None:
    """Print the record of `fleet_record`: the sentence, then axis by axis."""
    console = console or report_console()
    console.print(plain(record["sentence"], style="bold"))
    if record["effects"]:
        console.print("", _effects_table(record), sep="\n")
    for axis in record["axes"]:
        counts = ", ".join(f"{count} {spoken(name)}" for name, count in axis["statuses"].items())
        console.print("", plain(f"{axis['name']}: {axis['logs']} logs ({counts})", style="bold"), sep="\n")
        if not axis["parameters"]:
            console.print("no log has parameters to compare", markup=False)
            continue
        console.print(axis["verdict"], markup=False)
        console.print(_parameters_table(axis))
        if axis["joint"]:
            console.print(_joint_table(axis["joint"]))
        for line in _events(axis):
            console.print(line, markup=False)


def _effects_table(record: dict[str, Any]) -> TextTable:
    table = TextTable("Effects found", "effect", "at", "logs", "axes", "which", right=("logs", "axes"))
    for count in record["effects"][:_MOST_EFFECTS]:
        counts = (str(count["logs"]), str(len(count["axes"])))
        table.add(spoken(count["effect"]), count["at"], *counts, ", ".join(count["axes"][:4]))
    return table


def _parameters_table(axis: dict[str, Any]) -> TextTable:
    numbers = ("logs", "median", "between runs", "promised", "p")
    table = TextTable("", "", *numbers, "unit", "", right=numbers)
    for name, parameter in axis["parameters"].items():
        table.add(
            name,
            str(parameter["logs"]),
            with_deviation(parameter["median"], parameter["mean_std"]),
            spread_size(parameter, "between"),
            spread_size(parameter, "promised"),
            probability(parameter["probability_adjusted"]),
            parameter["unit"],
            "differs" if parameter["differs"] else "",
        )
    return table


def _joint_table(joint: dict[str, Any]) -> TextTable:
    disagreement = probability(joint["disagreement_probability"])
    trouble = "" if joint["status"] == "ok" else f", {spoken(joint['status'])}: {joint['message']}"
    title = f"Joined from {joint['logs']} logs (p that they share these parameters: {disagreement}{trouble})"
    table = TextTable(title, "", "joint", "unit", right=("joint",))
    for name, parameter in joint["parameters"].items():
        table.add(name, with_deviation(parameter["value"], parameter["std"]), parameter["unit"])
    return table


def spread_size(parameter: dict[str, Any], which: str) -> str:
    """A standard deviation for each unit of the mean, as the parameter itself where the mean may be 0."""
    if not math.isfinite(parameter[which]):
        return MISSING
    if abs(parameter["mean"]) > 2 * math.hypot(parameter["between"], parameter["promised"]):
        return percent(parameter[f"relative_{which}"], 2)
    return significant(parameter[which], 2)


def _events(axis: dict[str, Any]) -> list[str]:
    """Changes and outliers, one per line."""
    lines = []
    for name, parameter in axis["parameters"].items():
        lines += [f"{name} {change['sentence']}" for change in parameter["changes"]]
        far = parameter["outliers"]
        if far:
            shown = ", ".join(
                f"{outlier['log']} ({outlier['z']:+.3g} sigma)" for outlier in far[:_MOST_OUTLIERS]
            )
            more = f" and {len(far) - _MOST_OUTLIERS} more" if len(far) > _MOST_OUTLIERS else ""
            lines.append(f"{name} is an outlier in {shown}{more}")
    return lines


def print_batch(record: dict[str, Any], console: Console | None = None) -> None:
    """Print the summary of `symid.fleet.batch_of`."""
    console = console or report_console()
    reused = f", {record['reused']} of them as they were" if record["reused"] else ""
    console.print(f"{record['logs']} logs{reused}", highlight=False)
    console.print(_counts("Status", record["status"]))
    for axis, parameters in record["parameters"].items():
        if parameters:
            console.print(_parameters(axis, parameters))
    if "effects" in record:
        console.print(_counts("Verdict", {spoken(name): n for name, n in record["verdicts"].items()}))
    if record.get("effects"):
        effects = TextTable("Effects", "", "at", "logs", "axes", right=("logs",))
        for e in record["effects"]:
            axes = ", ".join(f"{axis} {n}" for axis, n in e["axes"].items())
            effects.add(spoken(e["effect"]), e["at"], str(e["logs"]), axes)
        console.print(effects)
    for trouble in record["not_ok"][:_MOST_LINES]:
        console.print(plain(f"{trouble['log']}: {trouble['status']}: {trouble['message']}"))
    if (more := record["logs"] - record["status"].get("ok", 0) - _MOST_LINES) > 0:
        console.print(f"and {more} more that are not ok: see the column message")
    if record["former_table"]:
        console.print(plain(f"the former table held other logs too: it is kept as {record['former_table']}"))
    if record["output"]:
        console.print(plain(f"rows: {', '.join(record['output'])}"))


def _counts(title: str, logs: dict[str, int]) -> TextTable:
    table = TextTable(title, "", "logs", right=("logs",))
    for name, count in logs.items():
        table.add(name, str(count))
    return table


def _parameters(axis: str, parameters: list[dict[str, Any]]) -> TextTable:
    numbers = ("logs", "median", "spread", "deviation of one log")
    title = f"Parameters of {axis} over the logs that are ok"
    table = TextTable(title, "", "sensors", *numbers, "unit", right=numbers)
    for p in parameters:
        if p["repeats"]:
            continue
        std = MISSING if p["std"] is None else significant(p["std"])
        sizes = (str(p["logs"]), significant(p["median"], 6), significant(p["spread"]), std)
        table.add(p["name"], p["measured"], *sizes, p["unit"])
    return table
