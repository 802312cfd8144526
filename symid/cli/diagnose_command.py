"""`symid diagnose`: why simulation and machine differ."""

import shlex
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
from click import argument, option

from symid.axis import axis_path, load_axis, write_axis
from symid.cli.excite_command import references_log
from symid.cli.knowledge import fix_option, fixed_values
from symid.cli.log_options import known_late, log_options, read_log_of
from symid.cli.options import (
    cascade_gains,
    gain_option,
    give_result,
    held_force,
    held_option,
    json_option,
    late_option,
    measured_option,
    named_numbers,
    page_of,
    parameter_file,
    report_option,
    write_json,
)
from symid.cli.outputs import Output, SafeCommand, overwrite_option
from symid.cli.terminal import say, with_options, working
from symid.data import WRITTEN_SUFFIXES, write_log
from symid.diagnosis import Diagnosis, diagnose, diagnose_against, explained_axis, next_experiment_of
from symid.errors import SettingError
from symid.files import written_path
from symid.report.tables import diagnosis_record, print_diagnosis
from symid.simulation import ClosedLoop

_LIMITS = ("lowest", "highest", "speed", "acceleration", "jerk", "force", "seconds")


@click.command(
    "diagnose",
    cls=SafeCommand,
    epilog="Example: symid diagnose emps data/emps/DATA_EMPS.mat --column q=qm "
    "--validation data/emps/DATA_EMPS_PULSES.mat --report emps.html",
)
@argument("axis")
@argument("logs", metavar="LOG...", nargs=-1, required=True)
@option(
    "--validation",
    metavar="LOG",
    help="Log on which the gap is measured [the last of several LOGs, every third part of one].",
)
@option("--nominal", metavar="P.json", help="Parameter values of the simulation [identified].")
@option(
    "--simulated",
    metavar="SIM",
    help="Log of your own simulator under the same reference, against which the machine is diagnosed.",
)
@measured_option
@log_options
@fix_option
@held_option
@late_option
@gain_option
@option(
    "--next-experiment",
    "experiment",
    metavar="FILE.csv",
    type=Output("log"),
    help="Write the reference that best distinguishes the cause found from its strongest rival.",
)
@option(
    "--limit",
    "limits",
    multiple=True,
    metavar="NAME=VALUE",
    help="Limit of the next experiment, SI: lowest, highest (position), speed, acceleration, jerk, force, "
    "seconds [those seen in LOG].",
)
@option(
    "--write-axis",
    metavar="FILE.py",
    type=Output("axis"),
    help="Write the axis with the effects found, and their values beside it in FILE.json.",
)
@report_option
@overwrite_option
@json_option
def command(axis: str, logs: tuple[str, ...], **options: Any) -> None:
    """Find where the gap between AXIS and LOGs lies, which unmodelled effect causes it, and how far it shrinks."""
    declared = load_axis(axis)
    if options["fixed"]:
        declared = declared.with_known(fixed_values(options["fixed"], declared))
    runs = [read_log_of(declared, log, options) for log in logs]
    validation = read_log_of(declared, options["validation"], options) if options["validation"] else None
    nominal = parameter_file(options["nominal"], declared) if options["nominal"] else None
    late, held = known_late(declared, options), held_force(options["held"], declared)
    recorded: dict[str, Any] = {"late": late, "held": held}
    if gains := cascade_gains(options["gains"]):
        recorded["controller"] = ClosedLoop.with_gains(declared, gains).controller
    simulated = read_log_of(declared, options["simulated"], options) if options["simulated"] else None
    if simulated and len(runs) > 1:
        raise SettingError(f"--simulated takes one log of the machine, not {len(runs)}: give one LOG")
    if simulated and nominal:
        raise SettingError("--nominal and --simulated both define the simulation: give one of them")
    limits = named_numbers(options["limits"], "--limit", _LIMITS)
    reference = options["experiment"]
    experiment = written_path("reference", reference, *WRITTEN_SUFFIXES) if reference else None
    page, written = page_of(options["report"]), options["write_axis"] and axis_path(options["write_axis"])
    with working("diagnosing"):
        if simulated:
            result = diagnose_against(declared, runs[0], simulated, validation=validation, **recorded)
        else:
            result = diagnose(declared, runs, validation=validation, nominal=nominal, **recorded)
    if experiment:
        result = _with_experiment(result, limits, experiment)
    if page:
        from symid.report.pages import (
            write_diagnosis_html,  # bokeh and jinja2 are loaded only where a page is written
        )

        write_diagnosis_html(result, page, with_options, shlex.join(["symid", *sys.argv[1:]]))
    give_result(diagnosis_record(result), options["json_file"], print_diagnosis)
    if written:
        _write_axis(result, written)


def _write_axis(result: Diagnosis, file: Path) -> None:
    """The axis with the effects found, and values of its parameters; as it is where only values were off."""
    if not result.effects and result.verdict not in ("no_gap", "parameters"):
        raise SettingError(
            f"--write-axis {file}: the gap is not explained ({result.verdict}), so there is no axis to write"
        )
    explained = explained_axis(result)
    write_axis(explained.axis, file, f"{result.axis.name} with what a diagnosis found.")
    values = file.with_suffix(".json")
    write_json(explained.values, str(values))
    say(f"wrote {file}, and its values to {values}", err=True)
    for sentence in explained.left_out:
        say(sentence, err=True)
    if tied := [change.name for change in result.parameters if not change.is_determined]:
        say(f"{', '.join(tied)}: the log determines combinations only, other values fit as well", err=True)


def _with_experiment(result: Diagnosis, limits: dict[str, float], file: Path) -> Diagnosis:
    """The diagnosis with the next experiment in words; its reference is written where there is one."""
    with working("planning the next experiment"):
        planned = next_experiment_of(result, **limits)
    if planned.trajectory is None:
        return replace(result, next_experiment=planned.text, planned=planned)
    write_log(references_log(result.axis, planned.paths), file)
    return replace(result, next_experiment=f"{planned.text} Its reference is in {file}.", planned=planned)
