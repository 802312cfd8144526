"""A diagnosis as a JSON record and as tables."""

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from rich.console import Console

from symid.diagnosis import Diagnosis, Experiment, ParameterChange, Simulator
from symid.diagnosis.findings import Stage, waterfall
from symid.report.tables.console import TextTable, plain, report_console
from symid.report.tables.motion_gap import motion_line, motion_rows, motions, unit_of_errors
from symid.report.tables.number_text import (
    MISSING,
    band,
    multiple,
    percent,
    probability,
    share,
    significant,
    times,
    with_deviation,
)
from symid.text import spoken

_MOST_ALTERNATIVES = 8


def diagnosis_record(diagnosis: Diagnosis) -> dict[str, Any]:
    """Record of `symid diagnose --json`; unknown numbers are nan. Signals and spectrum stay out: they are for plots."""
    simulated = {} if diagnosis.simulated is None else {"simulated": _simulated(diagnosis.simulated)}
    return {
        "axis": diagnosis.axis.name,
        "measured": list(diagnosis.measured),
        "logs": list(diagnosis.logs),
        "verdict": diagnosis.verdict,
        "sentence": diagnosis.sentence,
        "gap": asdict(diagnosis.gap),
        **({"drives": [asdict(drive.gap) for drive in diagnosis.drives]} if diagnosis.drives else {}),
        "waterfall": list(map(_stage, waterfall(diagnosis))),
        "location": [asdict(place) for place in diagnosis.location],
        "maps": {name: [asdict(cell) for cell in cells] for name, cells in diagnosis.maps.items()},
        "effects": [
            {
                **asdict(effect),
                "indistinguishable_from": [
                    {"effect": n, "at": at} for n, at in effect.indistinguishable_from
                ],
            }
            for effect in diagnosis.effects
        ],
        "alternatives": [asdict(cause) for cause in diagnosis.alternatives],
        "probabilities": dict(diagnosis.probabilities),
        "parameters": {change.name: _change(change) for change in diagnosis.parameters},
        "faults": list(diagnosis.faults),
        "assumptions": list(diagnosis.assumptions),
        "next_experiment": diagnosis.next_experiment,
        **({} if diagnosis.planned is None else {"experiment": _experiment(diagnosis.planned)}),
        **simulated,
    }


def _stage(stage: Stage) -> dict[str, Any]:
    return {
        "model": stage.model,
        "rms": None if stage.level is None else stage.level.rms,
        "relative": None if stage.level is None else stage.level.relative,
        "multiple_of_floor": stage.multiple,
        "removed": stage.removed,
        "removed_multiple_of_floor": stage.removed_multiple,
    }


def _change(change: ParameterChange) -> dict[str, Any]:
    return {
        "nominal": change.nominal,
        "reidentified": {"value": change.reidentified, "std": change.reidentified_std},
        "explained": {"value": change.explained, "std": change.explained_std},
        "unit": change.unit,
        "absorbed": change.absorbed,
        "at_bound": change.at_bound,
    }


def _experiment(planned: Experiment) -> dict[str, Any]:
    """The designed experiment: the causes that it distinguishes, with its probability, and its demands on the axis."""
    run = planned.simulated
    return {
        "causes": [{"effect": effect, "at": at} for effect, at in planned.causes],
        "motion": None if planned.trajectory is None else planned.trajectory.name,
        "seconds": None if planned.trajectory is None else planned.trajectory.duration,
        "probability": None if run is None else run.probability,
        "probability_if_right": None if run is None else [each.probability for each in run.separations],
        "further": [
            {"effect": effect, "at": at, "probability": None if math.isnan(p) else p}
            for (effect, at), p in planned.further.items()
        ],
        "demand": None if run is None else {**asdict(run.demand), "force": run.force},
        "message": planned.message,
    }


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
                "simulated": {name: asdict(p) for name, p in e.parameters.items()},
                "machine": e.machine and {name: asdict(p) for name, p in e.machine.items()},
                "differs": e.differs,
            }
            for e in simulator.effects
        ],
    }


def print_diagnosis(record: dict[str, Any], console: Console | None = None) -> None:
    """Print the record of `diagnosis_record`, the verdict first."""
    console = console or report_console()
    console.print(plain(record["sentence"], style="bold"))
    logs = ", ".join(record["logs"])
    console.print(f"{record['axis']} from {', '.join(record['measured'])}: {logs}", markup=False)
    for fault in record["faults"]:
        console.print(f"fault of the recording: {fault}", markup=False)
    gap = record["gap"]
    console.print("", _gap_table(record), closed_line(gap), sep="\n")
    if gap["reversal"] is not None:
        before, after = (significant(gap["reversal"][x]["rms"]) for x in ("reidentified", "explained"))
        unit = gap["unit"]
        console.print(f"within 50 ms of reversals: {before} {unit} re-identified, {after} {unit} explained")
    if gap["not_repeated"] is not None:
        rms, period = gap["not_repeated"]["level"]["rms"], significant(gap["not_repeated"]["period"], 3)
        size = f"{significant(rms)} {gap['unit']}"
        console.print(f"the motion repeats every {period} s: {size} of the error are new each time")
    for table in (
        _drives_table(record),
        *(_motion_table(motion, record) for motion in motions(record)),
        _location_table(record),
        _effects_table(record),
        _alternatives_table(record),
        _parameters_table(record),
        _simulated_table(record),
    ):
        if table.row_count:
            console.print("", table, sep="\n")
    console.print("")
    for motion in motions(record):
        console.print(motion_line(motion), markup=False)
    for assumption in record["assumptions"]:
        console.print(f"assumed: {assumption}", markup=False)
    console.print(f"next: {record['next_experiment']}", markup=False)


def closed_line(gap: dict[str, Any]) -> str:
    """Closed fraction of the gap as text, with its interval.

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


def _gap_table(record: dict[str, Any]) -> TextTable:
    gap = record["gap"]
    title = f"Error of {gap['signal']} up to {gap['band_hz']:.3g} Hz, on data that took no part in any choice"
    numbers = (f"rms [{gap['unit']}]", "of signal", "of floor", f"removed [{gap['unit']}]")
    table = TextTable(title, "model", *numbers, right=numbers)
    for stage in record["waterfall"]:
        if stage["rms"] is None:
            table.add(stage["model"], "none given", *[MISSING] * 3)
            continue
        size = (significant(stage["rms"]), percent(stage["relative"]), multiple(stage["multiple_of_floor"]))
        table.add(stage["model"], *size, significant(stage["removed"], 3))
    return table


def _drives_table(record: dict[str, Any]) -> TextTable:
    """The force error of each of several drives; empty for one."""
    models = ("nominal", "re-identified", "explained", "noise floor")
    table = TextTable("Force error of each drive, rms", "drive", *models, right=models)
    for gap in record.get("drives", ()):
        levels = (gap[key] for key in ("nominal", "reidentified", "explained", "noise_floor"))
        sizes = (MISSING if x is None else f"{significant(x['rms'])} {gap['unit']}" for x in levels)
        table.add(gap["signal"], *sizes)
    return table


def _motion_table(motion: dict[str, Any], record: dict[str, Any]) -> TextTable:
    """The simulated axis beside the measured motion next to a drive."""
    _, unit = unit_of_errors(motion)
    headings = ("position", "velocity", "tracking error", f"rms [{unit}]", f"at reversals [{unit}]")
    place = f" of {motion['signal']}" if "drives" in record else ""
    title = f"Fit of the simulated motion{place}, on the same data"
    table = TextTable(title, "model", *headings, right=headings)
    for model, *cells in motion_rows(motion, record):
        table.add(model, *cells)
    return table


def _location_table(record: dict[str, Any]) -> TextTable:
    share_of = "share of excess" if record["effects"] else "if a known effect"
    table = TextTable("Where it lies", "at", share_of, "band", "regime", right=(share_of,))
    for place in record["location"]:
        table.add(place["at"], share(place["share"]), band(*place["band_hz"]), place["regime"])
    return table


def _effects_table(record: dict[str, Any]) -> TextTable:
    numbers = ("probability", "removes", "leaves")
    table = TextTable("Effects found", "effect", "at", *numbers, "parameters", "or", right=numbers)
    gaps = {gap["signal"]: gap for gap in (record["gap"], *record.get("drives", ()))}
    for effect in record["effects"]:
        floor = gaps.get(effect["signal"], record["gap"])["noise_floor"]["rms"]
        values = effect["parameters"].items()
        parameters = ", ".join(f"{n} {with_deviation(p['value'], p['std'])} {p['unit']}" for n, p in values)
        others = ", ".join(spoken(o["effect"], o["at"]) for o in effect["indistinguishable_from"])
        if others:
            others += f" (one of them: {probability(effect['probability_with_ties'])})"
        sizes = (removes(effect["removes"]), times(effect["gap_after"]["rms"], floor))
        certainty = probability(effect["probability"])
        table.add(spoken(effect["effect"]), effect["at"], certainty, *sizes, parameters, others)
    return table


def removes(removed: Mapping[str, float]) -> str:
    """Share of the gap that an effect takes away, with its interval.

    >>> removes({"share": 0.934, "low": 0.91, "high": 0.95})
    '93 % (91 to 95 %)'
    """
    if not math.isfinite(removed["share"]):
        return MISSING
    low, high = (100 * removed[end] for end in ("low", "high"))
    return f"{share(removed['share'])} ({low:.0f} to {high:.0f} %)"


def _alternatives_table(record: dict[str, Any]) -> TextTable:
    considered = (f"{spoken(name)} {probability(value)}" for name, value in record["probabilities"].items())
    title = f"Considered: {', '.join(considered)}"
    numbers = ("probability", "gain in log-likelihood", f"leaves [{record['gap']['unit']}]")
    table = TextTable(title, "effect", "at", *numbers, right=numbers)
    for cause in record["alternatives"][:_MOST_ALTERNATIVES]:
        left = "screened" if cause["gap_after"] is None else significant(cause["gap_after"]["rms"])
        gain = significant(cause["log_likelihood"])
        table.add(spoken(cause["effect"]), cause["at"], probability(cause["probability"]), gain, left)
    return table


def _parameters_table(record: dict[str, Any]) -> TextTable:
    """Parameters; the column of the effects only where there are some."""
    several = bool(record["effects"])
    headings = ("nominal", "re-identified", *(["with effects"] if several else []))
    table = TextTable("Parameters", "", *headings, "unit", *(["remark"] if several else []), right=headings)
    for name, change in record["parameters"].items():
        stages = [change["reidentified"], change["explained"]][: 1 + several]
        values = [with_deviation(stage["value"], stage["std"]) for stage in stages]
        remark = "had absorbed the effects" if change["absorbed"] else ""
        if change.get("at_bound"):  # records of earlier versions lack it
            remark = "at its bound, not determined"
        table.add(name, significant(change["nominal"]), *values, change["unit"], *[remark] * several)
    return table


def _simulated_table(record: dict[str, Any]) -> TextTable:
    """Effects of the simulator beside those of the machine; empty without a simulator."""
    both = record.get("simulated", {"log": "", "parameters": {}, "effects": []})
    numbers = ("simulator", "machine")
    table = TextTable(f"The simulator ({both['log']})", "", *numbers, "unit", "remark", right=numbers)
    rows = [(n, p["simulated"], p["machine"], p["unit"], p["differs"]) for n, p in both["parameters"].items()]
    for effect in both["effects"]:
        place = f"{spoken(effect['effect'], effect['at'])}: "
        for name, p in effect["simulated"].items():
            machine = None if effect["machine"] is None else effect["machine"][name]
            rows.append((place + name, p, machine, p["unit"], effect["differs"]))
    for name, simulated, machine, unit, differs in rows:
        value = MISSING if machine is None else with_deviation(machine["value"], machine["std"])
        remark = "not in the machine" if machine is None else "differs" if differs else ""
        table.add(name, with_deviation(simulated["value"], simulated["std"]), value, unit, remark)
    return table
