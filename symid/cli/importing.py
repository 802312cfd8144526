"""`symid import`: a look at a foreign log."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import click

from symid.axis import load_axis
from symid.cli.number_types import POSITIVE, Number
from symid.cli.options import dark_option, give_result, json_option, write_json
from symid.cli.outputs import Output, SafeCommand
from symid.data import ForeignColumn, Layout, Table, foreign_columns, guessed_layout, open_table
from symid.data.formats import SUFFIXES, suffix_of
from symid.data.formats.scope_text import writer_of
from symid.errors import SettingError
from symid.identification import LogMapping, guessed_mapping, stated_period
from symid.report.colours import palette_of
from symid.report.console import TextTable, report_console


@dataclass(frozen=True)
class ForeignFile:
    """Guesses about a foreign file."""

    layout: Layout | None
    table: Table
    columns: tuple[ForeignColumn, ...]
    period: float | None


@click.command(
    "import",
    cls=SafeCommand,
    epilog="Example: symid import trace.csv --axis rigid_1m --rated 850 -o mapping.json",
)
@click.argument("log")
@click.option("--axis", metavar="AXIS", help="Guess which column is which signal of this axis.")
@click.option(
    "--rate", type=POSITIVE, metavar="HZ", help="Sampling rate of a file without a column of the time."
)
@click.option("--gain", type=Number(-math.inf), help="Force per unit of the drive's column, such as N per A.")
@click.option("--rated", type=POSITIVE, help="Force or torque that 100 % stands for.")
@click.option(
    "-o",
    "--output",
    metavar="FILE.json",
    type=Output("json"),
    help="Write the mapping, for --mapping of other commands.",
)
@click.option(
    "--plot", metavar="FILE", type=Output("picture"), help="Draw the columns over time (png, svg or pdf)."
)
@dark_option
@json_option
def command(log: str, **options: Any) -> None:
    """Look at the foreign LOG: guess its layout, columns, units and sampling, and say why. Nothing is used unseen."""
    if options["output"] and not options["axis"]:
        raise SettingError("-o needs --axis: a mapping names the signals of an axis")
    declared = load_axis(options["axis"]) if options["axis"] else None
    look = _look(Path(log), options["rate"])
    mapping = None
    if declared:
        mapping = guessed_mapping(
            declared,
            look.columns,
            layout=look.layout,
            sampling_period=look.period,
            gain=options["gain"],
            rated=options["rated"],
        )
    if options["plot"]:
        from symid.report.foreign import plot_foreign  # matplotlib takes a second to load

        palette = palette_of(options["dark"])
        plot_foreign(look.table, look.columns, look.period, options["plot"], palette)
    if mapping and options["output"]:
        write_json(mapping.as_record, options["output"])
    give_result(
        _record(log, look, mapping), options["json_file"], lambda _: _show(log, look, mapping, options)
    )


def _look(path: Path, rate: float | None) -> ForeignFile:
    """Layout, columns and the sampling period that is given or stated."""
    text = path.is_file() and (suffix_of(path) == ".csv" or suffix_of(path) not in SUFFIXES)
    layout = guessed_layout(path) if text and writer_of(path) is None else None
    if rate is not None and rate <= 0:
        raise SettingError(f"--rate is {rate:g}: it must be positive")
    table = open_table(path, layout)
    period = 1 / rate if rate else (stated_period(path, layout) if layout else None)
    return ForeignFile(layout, table, foreign_columns(table), period)


def _record(log: str, look: ForeignFile, mapping: LogMapping | None) -> dict[str, Any]:
    return {
        "log": log,
        "layout": asdict(look.layout) if look.layout else None,
        "sampling_period": look.period,
        "columns": [asdict(column) for column in look.columns],
        "mapping": mapping.as_record if mapping else None,
    }


def _show(log: str, look: ForeignFile, mapping: LogMapping | None, options: dict[str, Any]) -> None:
    console = report_console()
    if look.layout:
        of = look.layout
        header = (
            f"{of.above} lines above the header, {of.below} between it and the values"
            if of.named
            else f"{of.above} lines above the values, no names"
        )
        layout = f"{of.encoding}, separator {of.separator!r}, decimal {of.decimal!r}"
        console.print(f"{log}: {layout}, {header}", markup=False)
    shown = TextTable("", "column", "seems to be", "unit", "because")
    for column in look.columns:
        what = f"{'commanded ' * column.setpoint}{column.quantity or '?'}"
        unit = (column.unit or "?") + " (guessed)" * (column.unit is not None and not column.stated)
        shown.add(column.header, what, unit, column.reason)
    console.print(shown)
    if mapping is None:
        console.print("\nThese are guesses. With --axis AXIS they become a mapping.")
        return
    console.print(f"\nGuessed for {options['axis']}, check each:")
    for guess in mapping.guesses:
        console.print(f"    {guess}", markup=False)
    for lack in mapping.missing:
        console.print(f"Missing: {lack}", markup=False)
    if options["output"]:
        console.print(
            f"\nwrote {options['output']}: check it, delete the guesses that are right, then\n    symid identify "
            f"{options['axis']} {log} --mapping {options['output']}",
            markup=False,
        )
