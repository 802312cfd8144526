"""A diagnosis as a JSON record and as tables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

from rich.console import Console
from rich.table import Table

from symid.diagnosis.experiment import Experiment
from symid.diagnosis.gap import Gap, Level, MapCell, Removed, Reversal
from symid.diagnosis.result import (
    Alternative,
    Diagnosis,
    EffectParameter,
    FoundEffect,
    ParameterChange,
    Simulator,
)
from symid.report.console import plain, report_console
from symid.report.motion_gap import motion_line, motion_record, motion_rows
from symid.report.numbers import (
    MISSING,
    band,
    multiple,
    percent,
    probability,
    share,
    significant,
    times,
    with_deviation,
    words,
)
from symid.report.waterfall import waterfall

_MOST_ALTERNATIVES = 8


def diagnosis_record(found: Diagnosis) -> dict[str, Any]:
    """Record of `symid diagnose --json`; unknown numbers are nan.

    Parameters
    ----------
    found : Diagnosis
        Its signals and spectrum stay out: they are for plots.
    """
    simulated = {} if found.simulated is None else {"simulated": _simulated(found.simulated)}
    return {
        "axis": found.axis.name,
        "measured": list(found.measured),
        "logs": list(found.logs),
        "verdict": found.verdict,
        "sentence": found.sentence,
        "gap": _gap(found.gap),
        "waterfall": _waterfall(found),
        "location": [
            {"at": place.at, "share": place.share, "band_hz": list(place.band_hz), "regime": place.regime}
            for place in found.location
        ],
        "maps": {name: [_cell(cell) for cell in cells] for name, cells in found.maps.items()},
        "effects": [_effect(effect) for effect in found.effects],
        "alternatives": [_alternative(other) for other in found.alternatives],
        "probabilities": dict(found.probabilities),
        "parameters": {change.name: _change(change) for change in found.parameters},
        "faults": list(found.faults),
        "assumptions": list(found.assumptions),
        "next_experiment": found.next_experiment,
        **({} if found.planned is None else {"experiment": _experiment(found.planned)}),
        **simulated,
    }


def _experiment(planned: Experiment) -> dict[str, Any]:
    """The next experiment as designed: between what it decides, how surely, and what it demands of the axis."""
    run = planned.simulated
    return {
        "causes": [{"effect": effect, "at": at} for effect, at in planned.causes],
        "motion": None if planned.trajectory is None else planned.trajectory.name,
        "seconds": None if planned.trajectory is None else planned.trajectory.duration,
        "probability": None if run is None else run.probability,
        "probability_if_right": None if run is None else [found.probability for found in run.separations],
        "demand": None if run is None else {**asdict(run.demand), "force": run.force},
        "message": planned.message,
    }


def _level(level: Level | None) -> dict[str, float] | None:
    return None if level is None else {"rms": level.rms, "relative": level.relative}


def _gap(gap: Gap) -> dict[str, Any]:
    return {
        "signal": gap.signal,
        "unit": gap.unit,
        "band_hz": gap.band_hz,
        "nominal": _level(gap.nominal),
        "reidentified": _level(gap.reidentified),
        "explained": _level(gap.explained),
        "noise_floor": _level(gap.noise_floor),
        "steps": [_level(step) for step in gap.steps],
        "closed_fraction": gap.closed_fraction,
        "closed_interval": list(gap.closed_interval),
        "unexplained_share": gap.unexplained_share,
        "reversal": None if gap.reversal is None else _reversal(gap.reversal),
        "motion": None if gap.motion is None else motion_record(gap.motion),
    }


def _reversal(reversal: Reversal) -> dict[str, Any]:
    return {"reidentified": _level(reversal.reidentified), "explained": _level(reversal.explained)}


def _waterfall(found: Diagnosis) -> list[dict[str, Any]]:
    return [
        {
            "model": stage.model,
            "rms": None if stage.level is None else stage.level.rms,
            "relative": None if stage.level is None else stage.level.relative,
            "multiple_of_floor": stage.multiple,
            "removed": stage.removed,
            "removed_multiple_of_floor": stage.removed_multiple,
        }
        for stage in waterfall(found)
    ]


def _cell(cell: MapCell) -> dict[str, Any]:
    return {
        "label": cell.label,
        "low": cell.low,
        "high": cell.high,
        "samples": cell.samples,
        "share": cell.share,
        "before": cell.before,
        "after": cell.after,
    }


def _effect(effect: FoundEffect) -> dict[str, Any]:
    return {
        "effect": effect.effect,
        "at": effect.at,
        "probability": effect.probability,
        "parameters": _values(effect.parameters),
        "gap_after": _level(effect.gap_after),
        "removes": _removed(effect.removes),
        "indistinguishable_from": _places(effect.indistinguishable_from),
    }


def _removed(removed: Removed) -> dict[str, float]:
    return {"share": removed.share, "low": removed.low, "high": removed.high}


def _values(parameters: Mapping[str, EffectParameter]) -> dict[str, Any]:
    return {name: {"value": p.value, "std": p.std, "unit": p.unit} for name, p in parameters.items()}


def _simulated(simulator: Simulator) -> dict[str, Any]:
    return {
        "log": simulator.log,
        "error_multiple_of_floor": simulator.error,
        "parameters": {
            p.name: {
                "simulated": {"value": p.simulated, "std": p.simulated_std},
                "machine": {"value": p.machine, "std": p.machine_std},
                "unit": p.unit,
                "differs": p.differs,
            }
            for p in simulator.parameters
        },
        "effects": [
            {
                "effect": e.effect,
                "at": e.at,
                "simulated": _values(e.parameters),
                "machine": None if e.machine is None else _values(e.machine),
                "differs": e.differs,
            }
            for e in simulator.effects
        ],
    }


def _places(effects: Iterable[tuple[str, str]]) -> list[dict[str, str]]:
    return [{"effect": effect, "at": at} for effect, at in effects]


def _alternative(other: Alternative) -> dict[str, Any]:
    return {
        "effect": other.effect,
        "at": other.at,
        "probability": other.probability,
        "log_likelihood": other.log_likelihood,
        "gap_after": _level(other.gap_after),
    }


def _change(change: ParameterChange) -> dict[str, Any]:
    return {
        "nominal": change.nominal,
        "reidentified": {"value": change.reidentified, "std": change.reidentified_std},
        "explained": {"value": change.explained, "std": change.explained_std},
        "unit": change.unit,
        "absorbed": change.absorbed,
    }


def print_diagnosis(record: dict[str, Any], console: Console | None = None) -> None:
    """Print the record of `diagnosis_record`, the verdict first."""
    console = console or report_console()
    console.print(plain(record["sentence"], style="bold"))
    console.print(
        f"{record['axis']} from {', '.join(record['measured'])}: {', '.join(record['logs'])}", markup=False
    )
    for fault in record["faults"]:
        console.print(f"fault of the recording: {fault}", markup=False)
    console.print(
        "", _gap_table(record), closed_line(record["gap"]), *_reversal_line(record["gap"]), sep="\n"
    )
    for make in (
        _motion_table,
        _location_table,
        _effects_table,
        _alternatives_table,
        _parameters_table,
        _simulated_table,
    ):
        table = make(record)
        if table.row_count:
            console.print("", table, sep="\n")
    console.print("")
    if record["gap"]["motion"] is not None:
        console.print(motion_line(record["gap"]["motion"]), markup=False)
    for assumption in record["assumptions"]:
        console.print(f"assumed: {assumption}", markup=False)
    console.print(f"next: {record['next_experiment']}", markup=False)


def closed_line(gap: dict[str, Any]) -> str:
    """Closed fraction of the gap as text, with its interval.

    Examples
    --------
    >>> closed_line({"closed_fraction": 0.964, "closed_interval": [0.941, 0.978]})
    '96 % (94 to 98 %) of the way from the re-identified model to the noise floor is closed'
    >>> closed_line({"closed_fraction": float("nan"), "closed_interval": [float("nan")] * 2})
    'the re-identified model is at the noise floor: nothing is left to close'
    """
    if not math.isfinite(gap["closed_fraction"]):
        return "the re-identified model is at the noise floor: nothing is left to close"
    low, high = (100 * end for end in gap["closed_interval"])
    closed = f"{share(gap['closed_fraction'])} ({low:.0f} to {high:.0f} %)"
    return f"{closed} of the way from the re-identified model to the noise floor is closed"


def _reversal_line(gap: dict[str, Any]) -> tuple[str, ...]:
    """The error near reversals; nothing where the log has none."""
    if gap["reversal"] is None:
        return ()
    before, after = (significant(gap["reversal"][x]["rms"]) for x in ("reidentified", "explained"))
    return (
        f"within 50 ms of reversals: {before} {gap['unit']} re-identified, {after} {gap['unit']} explained",
    )


def _table(title: str, left: tuple[str, ...], right: tuple[str, ...], last: tuple[str, ...] = ()) -> Table:
    table = Table(title=plain(title), title_justify="left", box=None, pad_edge=False)
    for heading in (*left, *right, *last):
        table.add_column(heading, justify="right" if heading in right else "left")
    return table


def _add(table: Table, *cells: str) -> None:
    """A row of plain text: names of logs and signals may look like markup."""
    table.add_row(*(plain(cell) for cell in cells))


def _gap_table(record: dict[str, Any]) -> Table:
    gap = record["gap"]
    title = f"Error of {gap['signal']} up to {gap['band_hz']:.3g} Hz, on data that took no part in any choice"
    table = _table(
        title, ("model",), (f"rms [{gap['unit']}]", "of signal", "of floor", f"removed [{gap['unit']}]")
    )
    for stage in record["waterfall"]:
        if stage["rms"] is None:
            _add(table, stage["model"], "none given", *[MISSING] * 3)
            continue
        size = (significant(stage["rms"]), percent(stage["relative"]), multiple(stage["multiple_of_floor"]))
        _add(table, stage["model"], *size, significant(stage["removed"], 3))
    return table


def _motion_table(record: dict[str, Any]) -> Table:
    """The simulated axis beside the measured motion; empty where it was not simulated."""
    found = record["gap"]["motion"]
    unit = "" if found is None else f"u{found['unit']}"
    headings = ("position", "velocity", "tracking error", f"rms [{unit}]", f"at reversals [{unit}]")
    table = _table("Fit of the simulated motion, on the same data", ("model",), headings)
    for model, *cells in [] if found is None else motion_rows(record):
        _add(table, model, *cells)
    return table


def _location_table(record: dict[str, Any]) -> Table:
    table = _table("Where it lies", ("at",), ("share of excess",), ("band", "regime"))
    for place in record["location"]:
        _add(table, place["at"], share(place["share"]), band(*place["band_hz"]), place["regime"])
    return table


def _effects_table(record: dict[str, Any]) -> Table:
    table = _table(
        "Effects found", ("effect", "at"), ("probability", "removes", "leaves"), ("parameters", "or")
    )
    floor = record["gap"]["noise_floor"]["rms"]
    for found in record["effects"]:
        parameters = ", ".join(
            f"{name} {with_deviation(p['value'], p['std'])} {p['unit']}"
            for name, p in found["parameters"].items()
        )
        others = ", ".join(f"{words(o['effect'])} at {o['at']}" for o in found["indistinguishable_from"])
        left = times(found["gap_after"]["rms"], floor)
        _add(
            table,
            words(found["effect"]),
            found["at"],
            probability(found["probability"]),
            removes(found["removes"]),
            left,
            parameters,
            others,
        )
    return table


def removes(removed: Mapping[str, float]) -> str:
    """Share of the gap that an effect takes away, with its interval.

    Examples
    --------
    >>> removes({"share": 0.934, "low": 0.91, "high": 0.95})
    '93 % (91 to 95 %)'
    """
    if not math.isfinite(removed["share"]):
        return MISSING
    low, high = (100 * removed[end] for end in ("low", "high"))
    return f"{share(removed['share'])} ({low:.0f} to {high:.0f} %)"


def _alternatives_table(record: dict[str, Any]) -> Table:
    title = "Considered: " + ", ".join(
        f"{words(name)} {probability(value)}" for name, value in record["probabilities"].items()
    )
    unit = record["gap"]["unit"]
    table = _table(title, ("effect", "at"), ("probability", "gain in log-likelihood", f"leaves [{unit}]"))
    for other in record["alternatives"][:_MOST_ALTERNATIVES]:
        left = "screened" if other["gap_after"] is None else significant(other["gap_after"]["rms"])
        gain = significant(other["log_likelihood"])
        _add(table, words(other["effect"]), other["at"], probability(other["probability"]), gain, left)
    return table


def _parameters_table(record: dict[str, Any]) -> Table:
    """Parameters; the column of the effects only where there are some."""
    several = bool(record["effects"])
    headings = ("nominal", "re-identified", *(["with effects"] if several else []))
    table = _table("Parameters", ("",), headings, ("unit", *(["remark"] if several else [])))
    for name, change in record["parameters"].items():
        stages = [change["reidentified"], change["explained"]][: 1 + several]
        values = [with_deviation(stage["value"], stage["std"]) for stage in stages]
        remark = ["had absorbed the effects" if change["absorbed"] else ""] if several else []
        _add(table, name, significant(change["nominal"]), *values, change["unit"], *remark)
    return table


def _simulated_table(record: dict[str, Any]) -> Table:
    """Effects of the simulator beside those of the machine; empty without a simulator."""
    own = record.get("simulated", {"log": "", "parameters": {}, "effects": []})
    table = _table(f"The simulator ({own['log']})", ("",), ("simulator", "machine"), ("unit", "remark"))
    rows = [
        (name, p["simulated"], p["machine"], p["unit"], p["differs"]) for name, p in own["parameters"].items()
    ]
    for found in own["effects"]:
        place = f"{words(found['effect'])} at {found['at']}: "
        for name, p in found["simulated"].items():
            machine = None if found["machine"] is None else found["machine"][name]
            rows.append((place + name, p, machine, p["unit"], found["differs"]))
    for name, simulated, machine, unit, differs in rows:
        value = MISSING if machine is None else with_deviation(machine["value"], machine["std"])
        remark = "the machine has it not" if machine is None else "differs" if differs else ""
        _add(table, name, with_deviation(simulated["value"], simulated["std"]), value, unit, remark)
    return table
