"""`symid diagnose`: why simulation and machine differ."""

from __future__ import annotations

from typing import Any

import click

from symid.axis import load_axis
from symid.cli.identify import log_options, read_log_of
from symid.cli.options import (
    assignments,
    json_option,
    measured_option,
    parameter_file,
    seconds_of,
    write_json,
)
from symid.cli.progress import working
from symid.diagnosis import diagnose
from symid.report.diagnosis import diagnosis_record, print_diagnosis


@click.command(
    "diagnose",
    epilog="Example: symid diagnose emps data/emps/DATA_EMPS.mat --column q=qm "
    "--validation data/emps/DATA_EMPS_PULSES.mat --report emps.html",
)
@click.argument("axis")
@click.argument("log")
@click.option(
    "--validation", metavar="LOG", help="Log on which the gap is measured [every third part of LOG]."
)
@click.option("--nominal", metavar="P.json", help="Parameter values of the simulation [identified].")
@measured_option
@log_options
@click.option("--held", multiple=True, metavar="SIGNAL", help="A force that is held from sample to sample.")
@click.option(
    "--late",
    multiple=True,
    metavar="SIGNAL=TIME",
    help="Time by which a signal was recorded late, such as q2=125us.",
)
@click.option("--report", metavar="OUT.html", help="Write a page that can be passed on.")
@json_option
def command(axis: str, log: str, **options: Any) -> None:
    """Find where the gap between AXIS and LOG lies, which unmodelled effect causes it, and how far it shrinks."""
    declared = load_axis(axis)
    run = read_log_of(declared, log, options)
    validation = read_log_of(declared, options["validation"], options) if options["validation"] else None
    nominal = parameter_file(options["nominal"], declared) if options["nominal"] else None
    late = {
        name: seconds_of(text, f"--late {name}")
        for name, text in assignments(options["late"], "--late").items()
    }
    for signal in options["held"]:
        late[signal] = late.get(signal, 0.0) - run.sampling_period / 2
    if options["report"]:
        from symid.report.html import html_path, write_html  # jinja2 is loaded only where a page is written

        page = html_path(options["report"])
    with working("diagnosing"):
        found = diagnose(declared, run, validation=validation, nominal=nominal, late=late)
    record = diagnosis_record(found)
    if options["report"]:
        write_html(found, page)
    if options["json_file"]:
        write_json(record, options["json_file"])
    if options["json_file"] != "-":
        print_diagnosis(record)
