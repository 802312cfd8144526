"""`symid identify`: parameters from logs."""

from __future__ import annotations

from typing import Any

import click

from symid.axis import Axis, load_axis
from symid.cli.options import (
    assignments,
    json_option,
    measured_option,
    number,
    parameter_file,
    seconds_of,
    shared,
    signal_list,
    write_json,
)
from symid.cli.progress import tracked
from symid.codegen import load_generated
from symid.data import Log
from symid.errors import SettingError
from symid.identification import Preparation, identify, measured_signals, predict, read_axis_log
from symid.report.identification import identification_record, print_identification

log_options = shared(
    click.option(
        "--column", multiple=True, metavar="SIGNAL=COLUMN", help="Column of a signal (t is the time)."
    ),
    click.option(
        "--unit", multiple=True, metavar="SIGNAL=UNIT", help="Unit of a signal's column, such as q2=mm."
    ),
    click.option(
        "--gain", multiple=True, metavar="SIGNAL=FACTOR", help="Factor applied to a signal, such as ql=-1."
    ),
)

preparation_options = shared(
    click.option(
        "--cutoff",
        metavar="HZ",
        help="Cutoff frequency of the zero-phase Butterworth filter [chosen from the log].",
    ),
    click.option("--order", default=4, show_default=True, help="Order of one pass of the filter."),
    click.option(
        "--filter",
        "filtered",
        type=click.Choice(["all", "motion"]),
        default="all",
        show_default=True,
        help="Whether the force passes the filter too.",
    ),
    click.option(
        "--decimation", type=int, metavar="N", help="One row for every N samples [chosen from the cutoff]."
    ),
    click.option(
        "--trim", metavar="N or BEGIN,END", help="Samples left out at the ends [three periods of the cutoff]."
    ),
    click.option(
        "--standstill",
        metavar="SPEED",
        help="Speed below which rows do not enter friction equations; 0 keeps all [1 % of the highest].",
    ),
    click.option(
        "--held",
        multiple=True,
        metavar="SIGNAL",
        help="A force that is held from sample to sample, so that it acts half a sample late.",
    ),
    click.option(
        "--late",
        multiple=True,
        metavar="SIGNAL=TIME",
        help="Time by which a signal was recorded late, such as q2=125us.",
    ),
)


@click.command("identify", epilog="Example: symid identify emps data/emps/DATA_EMPS.mat --column q=qm")
@click.argument("axis")
@click.argument("logs", nargs=-1, required=True, metavar="LOG [LOG ...]")
@click.option(
    "--method",
    type=click.Choice(["wls", "ols"]),
    default="wls",
    show_default=True,
    help="Weighted or ordinary least squares.",
)
@measured_option
@log_options
@preparation_options
@click.option(
    "--ddof",
    type=int,
    help="Subtracted from the rows in the residual's deviation [the number of parameters].",
)
@click.option(
    "--nominal",
    metavar="P.json",
    help="Nominal parameters, a start where the inverse map has no closed form.",
)
@click.option("--validation", metavar="LOG", help="Apply the parameters to another log too.")
@click.option(
    "--plot", metavar="FILE", help="Draw measured and predicted force and the residual (png, svg or pdf)."
)
@json_option
def command(axis: str, logs: tuple[str, ...], **options: Any) -> None:
    """Identify the parameters of AXIS from each LOG, from several LOGs jointly."""
    declared = load_axis(axis)
    runs = [read_log_of(declared, file, options) for file in tracked(logs, "reading logs")]
    model = load_generated(axis, measured_signals(declared, runs, signal_list(options["measured"])))
    found = identify(
        model,
        runs,
        method=options["method"],
        preparation=_preparation(declared, runs[0], options),
        ddof=options["ddof"],
        nominal=parameter_file(options["nominal"], declared) if options["nominal"] else None,
    )
    validation = None
    if options["validation"]:
        validation = predict(found, read_log_of(declared, options["validation"], options))
    if options["plot"]:
        from symid.report.plots import plot_identification  # matplotlib takes a second to load

        plot_identification(found, options["plot"], validation)
    record = identification_record(found, validation)
    if options["json_file"]:
        write_json(record, options["json_file"])
    if options["json_file"] != "-":
        print_identification(record)


def read_log_of(declared: Axis, file: str, options: dict[str, Any]) -> Log:
    """A log by the log options."""
    gains = {
        name: number(text, f"--gain {name}") for name, text in assignments(options["gain"], "--gain").items()
    }
    return read_axis_log(
        declared,
        file,
        measured=signal_list(options["measured"]),
        columns=assignments(options["column"], "--column"),
        units=assignments(options["unit"], "--unit"),
        gains=gains,
    )


def _preparation(declared: Axis, log: Log, options: dict[str, Any]) -> Preparation:
    late = {
        name: seconds_of(text, f"--late {name}")
        for name, text in assignments(options["late"], "--late").items()
    }
    for signal in options["held"] + ((declared.drive.signal,) if declared.drive.held else ()):
        late[signal] = late.get(signal, 0.0) - log.sampling_period / 2
    unknown = [name for name in late if name not in declared.signal_units]
    if unknown:
        raise SettingError(
            f"axis {declared.name!r} has no signal {unknown[0]!r}: choose from {', '.join(declared.signal_units)}"
        )
    return Preparation(
        cutoff_hz=None if options["cutoff"] is None else number(options["cutoff"], "--cutoff"),
        order=options["order"],
        filter_force=options["filtered"] == "all",
        decimation=options["decimation"],
        trim=_trim(options["trim"]),
        standstill=None if options["standstill"] is None else number(options["standstill"], "--standstill"),
        late=late,
    )


def _trim(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    parts = text.split(",")
    if len(parts) > 2 or not all(part.strip().isdigit() for part in parts):
        raise SettingError(f"--trim {text!r} is not N or BEGIN,END in samples: write for example --trim 49,0")
    begin, end = int(parts[0]), int(parts[-1])
    return begin, end
