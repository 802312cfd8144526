"""`symid demo`: the main job on a shipped real log."""

import click
from click import option

from symid.axis import load_axis, shipped_folder
from symid.cli.options import json_option, write_json
from symid.cli.outputs import Output, SafeCommand
from symid.cli.terminal import say, with_options, working
from symid.codegen import load_generated
from symid.diagnosis import diagnose
from symid.identification import Preparation, identify_by_least_squares, predict, read_axis_log
from symid.report.pages import html_path, write_diagnosis_html
from symid.report.tables import diagnosis_record, identification_record, print_diagnosis, print_identification

PUBLISHED_RECIPE = Preparation(
    cutoff_hz=100.0, filter_force=False, decimation=10, trim=(49, 0), standstill=0.0, difference_order=2
)
"""Settings of the report of Janot, Gautier and Brunot (2019); its deviations divide by the number of rows less one."""


@click.command("demo", cls=SafeCommand, epilog="Example: symid demo --report emps_report.html")
@option(
    "--report",
    metavar="OUT.html",
    type=Output("html"),
    default="emps_report.html",
    help="The page that is written.",
)
@json_option
def command(report: str, json_file: str | None) -> None:
    """Identify the EMPS axis from its real log with the published recipe, diagnose its gap, and write a report."""
    page = html_path(report)
    axis = load_axis("emps")
    folder = shipped_folder("data") / "emps"
    files = (folder / name for name in ("DATA_EMPS.mat", "DATA_EMPS_PULSES.mat"))
    log, pulses = (read_axis_log(axis, file, columns={"q": "qm"}) for file in files)
    identification = identify_by_least_squares(
        load_generated("emps"), log, preparation=PUBLISHED_RECIPE, ddof=1
    )
    with working("diagnosing"):
        diagnosis = diagnose(axis, log, validation=pulses, nominal=identification.physical_parameters)
    write_diagnosis_html(diagnosis, page, with_options)
    identified = with_options(identification_record(identification, predict(identification, pulses)))
    gap = with_options(diagnosis_record(diagnosis))
    if json_file:
        write_json({"identification": identified, "diagnosis": gap, "report": str(page)}, json_file)
    if json_file != "-":
        print_identification(identified)
        say("")
        print_diagnosis(gap)
        say(f"\nreport: {page.resolve()}")
