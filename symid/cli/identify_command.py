"""`symid identify`: parameters from logs."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

import click
from click import Choice, IntRange, argument, option

from symid.axis import Axis, load_axis
from symid.cli.knowledge import (
    bounds_of,
    fixed_values,
    knowledge_options,
    known_by_log,
    known_option,
    priors_of,
)
from symid.cli.log_options import (
    known_late,
    log_options,
    log_settings,
    notes_on_guesses,
    preparation_of,
    preparation_options,
    read_log_of,
)
from symid.cli.options import (
    POSITIVE,
    bytes_of,
    cascade_gains,
    dark_option,
    gain_option,
    give_result,
    held_force,
    json_option,
    measured_option,
    page_of,
    parameter_file,
    plot_option,
    report_option,
    shared,
    signal_list,
)
from symid.cli.outputs import SafeCommand
from symid.cli.terminal import tracked, with_options, working
from symid.data import AnyLog, first_block
from symid.errors import SettingError
from symid.identification import (
    Identification,
    Preparation,
    identify_with_known,
    measured_signals,
    open_axis_log,
)
from symid.report.figures import palette_of
from symid.report.tables import identification_record, print_identification, print_shared, shared_record
from symid.verbs import METHODS, identify

if TYPE_CHECKING:
    from symid.output_error import OutputErrorIdentification

loop_options = shared(
    gain_option,
    option("--rate", type=POSITIVE, metavar="HZ", help="Rate of the controller [at least 1 kHz]."),
)


@click.command(
    "identify", cls=SafeCommand, epilog="Example: symid identify emps data/emps/DATA_EMPS.mat --column q=qm"
)
@argument("axis")
@argument("logs", nargs=-1, required=True, metavar="LOG [LOG ...]")
@option(
    "--method",
    type=Choice(list(METHODS)),
    default="wls",
    help="Weighted or ordinary least squares, instrumental variables, or output error (maximum likelihood).",
)
@measured_option
@log_options
@preparation_options
@knowledge_options
@known_option
@loop_options
@option(
    "--ddof",
    type=IntRange(0, 10**6),
    help="Subtracted from the rows in the residual's deviation [the number of parameters].",
)
@option(
    "--nominal",
    metavar="P.json",
    help="Nominal parameters, a start where the inverse map has no closed form.",
)
@option(
    "--memory",
    default="1GB",
    metavar="SIZE",
    help="Memory for a log; a longer CSV or Parquet file is identified in blocks (wls and ols).",
)
@option("--validation", metavar="LOG", help="Apply the parameters to another log too.")
@plot_option("model and measurement, residual, frequency response and confidence ellipses")
@report_option
@dark_option
@json_option
def command(axis: str, logs: tuple[str, ...], **options: Any) -> None:
    """Identify the parameters of AXIS from one LOG, or from several LOGs jointly."""
    declared = load_axis(axis)
    page_of(options["report"])  # its name is checked before the logs are read
    runs = [_opened(declared, file, options) for file in tracked(logs, "reading logs")]
    signals = measured_signals(declared, runs, signal_list(options["measured"]))
    validating = read_log_of(declared, options["validation"], options) if options["validation"] else None
    fixed = fixed_values(options["fixed"], declared)
    known = declared.with_known(fixed) if fixed else declared
    if options["known"]:
        _by_known_values(known, logs, runs, signals, options)
        return
    result = _identified(axis, runs, signals, fixed, options)
    # output error may have no start to begin at
    validation: Any = result.predict(validating) if validating and result.fit is not None else None
    if options["method"] == "oe":
        from symid.report.tables import output_error_record  # takes 0.3 s to load

        record = output_error_record(cast("OutputErrorIdentification", result), validation)
    else:
        record = identification_record(cast("Identification", result), validation)
    drawn = list(map(first_block, runs))
    drawn += [validating] if validating and validation is not None else []
    if options["plot"]:
        from symid.report.figures import (
            plot_identification,  # matplotlib takes a second to load
            save_figure,
        )

        palette = palette_of(options["dark"])
        figure = plot_identification(result, validation, axis=known, runs=drawn, palette=palette)
        save_figure(figure, options["plot"])
    if options["report"]:
        from symid.report.pages import write_identification_html  # as above

        write_identification_html(
            result,
            options["report"],
            validation,
            axis=known,
            runs=drawn,
            command=shlex.join(["symid", *sys.argv[1:]]),
            reword=with_options,
        )
    give_result(record, options["json_file"], print_identification)


def _by_known_values(
    declared: Axis,
    logs: Sequence[str],
    runs: Sequence[AnyLog],
    signals: tuple[str, ...],
    options: dict[str, Any],
) -> None:
    """Identify from logs with values known for each, and print the result."""
    for name in ("validation", "plot", "report"):
        if options[name]:
            raise SettingError(f"--known and --{name} do not go together: leave one of them out")
    if options["method"] != "wls":
        raise SettingError(f"--known and --method {options['method']} do not go together: take wls")
    result = identify_with_known(
        declared,
        runs,
        known_by_log(options["known"], declared, logs),
        signals,
        preparation=_preparation(declared, options),
        nominal=parameter_file(options["nominal"], declared) if options["nominal"] else None,
        bounds=bounds_of(options["bounds"], declared),
        prior=priors_of(options["prior"], declared),
    )
    give_result(shared_record(result), options["json_file"], print_shared)


def _identified(
    axis: str,
    runs: Sequence[AnyLog],
    signals: Sequence[str],
    fixed: dict[str, float],
    options: dict[str, Any],
) -> Identification | OutputErrorIdentification:
    declared, method = load_axis(axis), options["method"]
    unknown = declared.with_known(fixed) if fixed else declared
    loop = None
    if method == "iv" or (method == "oe" and options["gains"]):
        from symid.simulation import ClosedLoop  # takes 0.1 s to load

        loop = ClosedLoop.with_gains(declared, cascade_gains(options["gains"]), options["rate"])
    with working("simulating") if method in ("iv", "oe") else nullcontext():
        result: Identification | OutputErrorIdentification = identify(
            axis,
            runs,
            measured=signals,
            method=method,
            preparation=_preparation(declared, options),
            ddof=options["ddof"],
            nominal=parameter_file(options["nominal"], unknown) if options["nominal"] else None,
            fixed=fixed,
            bounds=bounds_of(options["bounds"], unknown),
            prior=priors_of(options["prior"], unknown),
            loop=loop,
        )
    return result


def _preparation(declared: Axis, options: dict[str, Any]) -> Preparation:
    late, held = known_late(declared, options), held_force(options["held"], declared)
    return replace(preparation_of(options, late), held=held)


def _opened(declared: Axis, file: str, options: dict[str, Any]) -> AnyLog:
    """A log by the log options, in memory if it fits or if the method needs it there."""
    memory = bytes_of(options["memory"])
    whole = options["method"] in ("iv", "oe")
    log = open_axis_log(declared, file, memory=memory, whole=whole, **log_settings(declared, options))
    return replace(log, notes=(*log.notes, *notes_on_guesses(options)))
