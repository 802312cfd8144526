"""`symid fleet`: review of the results of a batch."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import click
from click import Choice, argument, option

from symid.axis import load_axis
from symid.cli.options import give_result, json_option, page_of, report_option, signal_list
from symid.cli.outputs import SafeCommand
from symid.cli.terminal import working
from symid.codegen import GeneratedModel, model_of
from symid.errors import SettingError
from symid.fleet import FleetReview, JointIdentification, join_results, read_results, review_fleet, units_in
from symid.report.tables import fleet_record, print_fleet
from symid.signal_names import is_signal_name


@click.command("fleet", cls=SafeCommand, epilog="Example: symid fleet results.parquet --report fleet.html")
@argument("results", metavar="RESULTS.parquet")
@option(
    "--by",
    type=Choice(["axis", "folder"]),
    default="axis",
    help="Logs of one machine: all logs of an axis, or those in one folder.",
)
@option(
    "--order",
    type=Choice(["recorded", "name"]),
    default="recorded",
    help="Order of the charts: the times of the files, or the names of the logs where copying has lost the times.",
)
@option(
    "--status",
    "statuses",
    default="ok",
    metavar="NAMES",
    help="Logs whose parameters enter, by status, such as ok,biased.",
)
@option(
    "--without",
    metavar="NAMES",
    help="Parameters that differ from log to log by their nature, such as an unknown zero.",
)
@option(
    "--joint",
    is_flag=True,
    help="Join the logs of each axis into one estimate, from the factors that symid batch --joint has kept.",
)
@option(
    "--axis",
    "declared",
    multiple=True,
    metavar="AXIS",
    help="File of an axis in the results, for --joint, where its name does not find it.",
)
@report_option
@json_option
def command(results: str, **options: Any) -> None:
    """Review RESULTS of a batch: spread between runs, changes over time, outliers, effects."""
    table, statuses = read_results(results), signal_list(options["statuses"]) or ()
    page = page_of(options["report"])
    by_folder = options["by"] == "folder"
    with working("reviewing"):
        review = review_fleet(
            table,
            units=units_in(results),
            statuses=statuses,
            without=signal_list(options["without"]) or (),
            by_folder=by_folder,
            by_name=options["order"] == "name",
        )
        joined = None
        if options["joint"]:
            models = partial(_model, {load_axis(source).name: source for source in options["declared"]})
            joined = join_results(table, models, statuses=statuses, by_folder=by_folder)
    if page:
        write_review(review, page, joined)
    record = fleet_record(review, joined)
    give_result(record, options["json_file"], print_fleet)


def write_review(
    review: FleetReview, page: Path, joined: Mapping[str, JointIdentification] | None = None
) -> None:
    """Write the page of a review."""
    from symid.report.pages import write_fleet_html  # jinja2 is loaded only where a page is written

    write_fleet_html(review, page, joined)


def _model(files: Mapping[str, str], axis: str, sensors: tuple[str, ...]) -> GeneratedModel:
    """Model of an axis named in results. No file is run because a table names it: files come from the user."""
    if axis not in files and not is_signal_name(axis):
        raise SettingError(f"results name the axis {axis!r}, which is not a name: give its file with --axis")
    return model_of(files.get(axis, axis), sensors or None)
