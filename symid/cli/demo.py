"""`symid demo`: the main job on a shipped real log."""

from __future__ import annotations

import click

from symid.axis import load_axis, shipped_folder
from symid.cli.options import json_option, write_json
from symid.codegen import load_generated
from symid.identification import Preparation, identify, predict, read_axis_log
from symid.report.identification import identification_record, print_identification

PUBLISHED_RECIPE = Preparation(
    cutoff_hz=100.0, filter_force=False, decimation=10, trim=(49, 0), standstill=0.0
)
"""Of the report of Janot, Gautier and Brunot (2019); its deviations divide by the number of rows less one."""


@click.command("demo", epilog="Example: symid demo")
@json_option
def command(json_file: str | None) -> None:
    """Identify the EMPS axis from its real log with the published recipe, and apply the result to the second log."""
    axis = load_axis("emps")
    folder = shipped_folder("data") / "emps"
    log, other = (
        read_axis_log(axis, folder / name, columns={"q": "qm"})
        for name in ("DATA_EMPS.mat", "DATA_EMPS_PULSES.mat")
    )
    found = identify(load_generated("emps"), log, preparation=PUBLISHED_RECIPE, ddof=1)
    record = identification_record(found, predict(found, other))
    if json_file:
        write_json(record, json_file)
    if json_file != "-":
        print_identification(record)
