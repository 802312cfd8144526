"""`symid batch`: many logs, one row each."""

import sys
from typing import Any

import click
from click import Choice, IntRange, argument, option

from symid.axis import Axis, axis_of, load_axis
from symid.cli.fleet_command import write_review
from symid.cli.identify_command import loop_options
from symid.cli.knowledge import bounds_of, fixed_values, knowledge_options, known_of_tables, priors_of
from symid.cli.log_options import (
    column_settings,
    late_of,
    log_options,
    notes_on_guesses,
    preparation_of,
    preparation_options,
)
from symid.cli.options import (
    POSITIVE,
    bytes_of,
    cascade_gains,
    give_result,
    json_option,
    measured_option,
    page_of,
    parameter_file,
    shared,
    signal_list,
)
from symid.cli.outputs import Output, SafeCommand
from symid.cli.terminal import say, tracked, working
from symid.fleet import MOST_SECONDS, BatchSettings, Interrupted, identify_batch, review_fleet, summary_of
from symid.report.tables import print_batch
from symid.verbs import METHODS

batch_options = shared(
    option(
        "-o",
        "--output",
        required=True,
        multiple=True,
        metavar="RESULTS",
        type=Output("results"),
        help="Table to write, .parquet or .csv; give it twice for both.",
    ),
    option(
        "--also",
        multiple=True,
        metavar="AXIS",
        help="Another axis; a log is of the first whose signals it has.",
    ),
    option("--jobs", type=IntRange(max=4096), metavar="N", help="Processes [as many as there are cores]."),
    option(
        "--scheduler", metavar="ADDRESS", help="Dask scheduler of a cluster, such as tcp://10.0.0.1:8786."
    ),
    option(
        "--memory",
        default="1GB",
        metavar="SIZE",
        help="Memory for a log in each process; a longer CSV or Parquet file is identified in blocks (wls and ols).",
    ),
    option(
        "--timeout",
        type=POSITIVE,
        default=MOST_SECONDS,
        metavar="SECONDS",
        help="Longest time for a log; a worker that takes longer is ended. A cluster has its own limits.",
    ),
    option(
        "--joint",
        is_flag=True,
        help="Keep what symid fleet --joint needs to join the logs of an axis, some hundred numbers each.",
    ),
    option(
        "--known",
        multiple=True,
        metavar="TABLE.csv",
        help="Values that differ from log to log, such as the payload: a column log, and one for each parameter.",
    ),
    option("--report", metavar="OUT.html", type=Output("html"), help="Write the page of symid fleet too."),
    option("--diagnose", is_flag=True, help="Diagnose each log too, which takes seconds per log."),
)


@click.command(
    "batch", cls=SafeCommand, epilog="Example: symid batch emps logs/ -o results.parquet --column q=qm"
)
@argument("axis")
@argument("logs", nargs=-1, required=True, metavar="LOG ...")
@batch_options
@option("--method", type=Choice(list(METHODS)), default="wls", help="As in symid identify.")
@measured_option
@log_options
@preparation_options
@knowledge_options
@loop_options
@option("--ddof", type=IntRange(0, 10**6), help="As in symid identify.")
@option("--nominal", metavar="P.json", help="Nominal parameters: a start, and the simulation to diagnose.")
@json_option
def command(axis: str, logs: tuple[str, ...], json_file: str | None, **options: Any) -> None:
    """Identify AXIS from each LOG alone, in parallel: one row per log.

    LOG is a file, a folder or a pattern. A log that cannot be used becomes a row with the reason. Stopped at any time,
    the same command continues: finished logs are done again only if the log, the axis or the settings changed.
    """
    notes_on_guesses(options)
    page = page_of(options["report"])
    axes = _axes((axis, *options["also"]), options["fixed"])
    units = {name: unit for axis_given in axes for name, unit in axis_of(axis_given).parameter_units.items()}
    try:
        batch = identify_batch(
            axes,
            logs,
            output=options["output"],
            settings=_settings(axes, options),
            known=known_of_tables(options["known"], units),
            jobs=options["jobs"],
            scheduler=options["scheduler"],
            track=lambda rows, total: tracked(rows, "logs", total),
        )
    except Interrupted as stop:
        say(f"symid: {stop}", err=True)
        sys.exit(130)
    if page:
        with working("reviewing"):
            write_review(review_fleet(batch.table, units=batch.units), page)
    give_result(summary_of(batch), json_file, print_batch)


def _axes(names: tuple[str, ...], fixed: tuple[str, ...]) -> tuple[str | Axis, ...]:
    """Axes with the values of ``--fix``; each value applies to the first axis that has the parameter."""
    if not fixed:
        return names
    declared = [load_axis(name) for name in names]
    for value in fixed:
        name = value.partition("=")[0]
        place = next((i for i, axis in enumerate(declared) if name in axis.parameter_units), 0)
        declared[place] = declared[place].with_known(fixed_values((value,), declared[place]))
    return tuple(declared)


def _settings(axes: tuple[str | Axis, ...], options: dict[str, Any]) -> BatchSettings:
    first = axis_of(axes[0])
    return BatchSettings(
        method=options["method"],
        measured=signal_list(options["measured"]),
        preparation=preparation_of(options, late_of(options)),
        held=options["held"],
        ddof=options["ddof"],
        nominal=parameter_file(options["nominal"], first) if options["nominal"] else None,
        bounds=bounds_of(options["bounds"], first),
        prior=priors_of(options["prior"], first),
        controller=cascade_gains(options["gains"]),
        rate_hz=options["rate"],
        diagnose=options["diagnose"],
        joint=options["joint"],
        memory=bytes_of(options["memory"]),
        seconds=options["timeout"],
        **column_settings(options),
    )
