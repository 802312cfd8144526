"""`symid fleet`: what the results of a batch say of a fleet."""

from __future__ import annotations

from typing import Any

import click

from symid.cli.options import json_option, signal_list, write_json
from symid.cli.progress import working
from symid.fleet import review_fleet
from symid.fleet.results import read_results
from symid.report.fleet import fleet_record, print_fleet


@click.command("fleet", epilog="Example: symid fleet results.parquet --report fleet.html")
@click.argument("results", metavar="RESULTS.parquet")
@click.option(
    "--by",
    type=click.Choice(["axis", "folder"]),
    default="axis",
    show_default=True,
    help="What one machine is: all logs of an axis, or those in one folder.",
)
@click.option(
    "--order",
    type=click.Choice(["recorded", "name"]),
    default="recorded",
    show_default=True,
    help="Order of the charts: the times of the files, or the names of the logs where copying has lost the times.",
)
@click.option(
    "--status",
    "statuses",
    default="ok",
    show_default=True,
    metavar="NAMES",
    help="Logs whose parameters enter, by status, such as ok,biased.",
)
@click.option(
    "--without",
    metavar="NAMES",
    help="Parameters that differ from log to log by their nature, such as an unknown zero.",
)
@click.option("--report", metavar="OUT.html", help="Write a page that can be passed on.")
@json_option
def command(results: str, **options: Any) -> None:
    """Review RESULTS of a batch: spread between runs, changes over time, outliers, effects."""
    table = read_results(results)
    if options["report"]:
        from symid.report.fleet_page import write_fleet_html  # jinja2 is loaded only where a page is written
        from symid.report.html import html_path

        page = html_path(options["report"])
    with working("reviewing"):
        found = review_fleet(
            table,
            statuses=signal_list(options["statuses"]) or (),
            without=signal_list(options["without"]) or (),
            by_folder=options["by"] == "folder",
            by_name=options["order"] == "name",
        )
    if options["report"]:
        write_fleet_html(found, page)
    record = fleet_record(found)
    if options["json_file"]:
        write_json(record, options["json_file"])
    if options["json_file"] != "-":
        print_fleet(record)
