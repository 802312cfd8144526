"""`symid import`: a look at a foreign log."""

import sys
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import click
import numpy as np
from click import argument, option

from symid.axis import Axis, load_axis
from symid.cli.asking import Known, asked, asked_file
from symid.cli.options import POSITIVE, dark_option, give_result, json_option, number, plot_option, write_json
from symid.cli.outputs import Output, SafeCommand
from symid.cli.terminal import with_options
from symid.data import ForeignColumn, Layout, Table, foreign_columns, open_table
from symid.data.formats import layout_found
from symid.data.quality import inspect_clock, inspect_finite
from symid.errors import LogError, SettingError
from symid.identification import LogMapping, guessed_mapping, stated_period
from symid.identification.signals import for_sensor
from symid.report.figures import palette_of
from symid.report.tables import TextTable, report_console
from symid.units import to_si


@dataclass(frozen=True)
class ForeignFile:
    """Guesses about a foreign file."""

    layout: Layout | None
    table: Table
    columns: tuple[ForeignColumn, ...]
    period: float | None
    left_out: dict[str, str]  # reasons by the headers of columns that hold no numbers


@click.command(
    "import",
    cls=SafeCommand,
    epilog="Example: symid import trace.csv --axis rigid_1m --rated 850 -o mapping.json",
)
@argument("log")
@option("--axis", metavar="AXIS", help="Guess which column is which signal of this axis.")
@option("--column", multiple=True, metavar="SIGNAL=COLUMN", help="Column of a signal whose guess is wrong.")
@option(
    "--unit",
    multiple=True,
    metavar="SIGNAL=UNIT",
    help="Unit of a signal's column, such as q='5000 counts/mm'.",
)
@option("--rate", type=POSITIVE, metavar="HZ", help="Sampling rate of a file without a column of the time.")
@option("--encoding", metavar="NAME", help="Encoding of a text file, such as cp932 or gbk.")
@option(
    "--gain", metavar="FACTOR", help="Force per unit of the drive's column, such as N per A, or F=FACTOR."
)
@option("--rated", type=POSITIVE, help="Force or torque that 100 % stands for.")
@option(
    "-o",
    "--output",
    metavar="FILE.json",
    type=Output("mapping"),
    help="Write the mapping, for --mapping of other commands.",
)
@plot_option("the columns over time")
@option(
    "--ask/--no-ask",
    default=None,
    help="Ask for what the file does not say [where standard input is a terminal].",
)
@dark_option
@json_option
def command(log: str, **options: Any) -> None:
    """Look at the foreign LOG: guess its layout, columns, units and sampling, and say why. Nothing is used unseen."""
    for name in ("output", "column", "unit", "ask"):
        if options[name] and not options["axis"]:
            option = "-o" if name == "output" else f"--{name}"
            raise SettingError(f"{option} needs --axis: a mapping names the signals of an axis")
    if options["output"] == options["json_file"] == "-":
        raise SettingError(
            "-o - and --json - would both be written to the standard output: give one of them a file"
        )
    declared = load_axis(options["axis"]) if options["axis"] else None
    options["gain"] = _factor(options["gain"], declared)
    look = _read_foreign(Path(log), options["encoding"])
    known = Known.of(options)
    if declared and _may_ask(options):
        _show_columns(log, look, declared, numbered=True)
        known = asked(declared, look.columns, lambda known: _mapping(look, declared, known), known)
        options["output"] = options["output"] or asked_file(Path(log))
    elif "-" not in (options["output"], options["json_file"]):
        _show_columns(log, look, declared)
    look = replace(look, period=1 / known.rate) if known.rate else look
    mapping = _mapping(look, declared, known) if declared else None
    if options["plot"]:
        from symid.report.figures import plot_foreign  # matplotlib takes a second to load

        palette = palette_of(options["dark"])
        plot_foreign(look.table, look.columns, look.period, options["plot"], palette)
    if mapping and options["output"]:
        write_json(with_options(mapping.as_record), options["output"])
    record = {
        "log": log,
        "layout": asdict(look.layout) if look.layout else None,
        "sampling_period": look.period,
        "columns": [asdict(column) for column in look.columns],
        "mapping": mapping.as_record if mapping else None,
    }
    if options["output"] != "-":
        give_result(record, options["json_file"], lambda _: _show_mapping(log, look, mapping, options))
    elif options["json_file"]:
        write_json(with_options(record), options["json_file"])


def _factor(text: str | None, axis: Axis | None) -> float | None:
    """The factor of the drive in a text such as ``F=85``; other commands also accept factors of readings."""
    if text is None:
        return None
    signal, _, factor = text.rpartition("=")
    if signal and axis and signal not in [drive.signal for drive in axis.drives]:
        raise SettingError(
            f"--gain {text}: only that of a drive is asked here; give it to the command that uses the mapping, or "
            f"a unit such as --unit {signal}='5000 counts/mm'"
        )
    return number(factor, "--gain")


def _may_ask(options: dict[str, Any]) -> bool:
    """Whether a person can answer, or questions were requested."""
    if options["ask"] is None:
        streams = (sys.stdin, sys.stdout)
        return "-" not in (options["output"], options["json_file"]) and all(
            stream is not None and stream.isatty() for stream in streams
        )
    return bool(options["ask"])


def _read_foreign(path: Path, encoding: str | None) -> ForeignFile:
    """Layout, columns and the stated sampling period."""
    layout = layout_found(path, encoding)
    if encoding and layout is None:
        raise SettingError(f"--encoding {encoding}: {path} is not plain text: leave it out")
    table = open_table(path, layout)
    if not table.headers:
        raise LogError(f"{path}: holds no columns of numbers: save each signal as a vector")
    columns = foreign_columns(table)
    described = {column.header for column in columns}
    left_out = {
        header: values if isinstance(values, str) else "has no values"
        for header, values in zip(table.headers, table.beginning(), strict=True)
        if header and header not in described
    }
    period = stated_period(path, layout) if layout else None
    return ForeignFile(layout, table, columns, period, left_out)


def _mapping(look: ForeignFile, axis: Axis, known: Known) -> LogMapping:
    return guessed_mapping(
        axis,
        look.columns,
        left_out=look.left_out,
        named=known.named,
        units=known.units,
        layout=look.layout,
        sampling_period=1 / known.rate if known.rate else look.period,
        gain=known.gain,
        rated=known.rated,
    )


def _show_columns(log: str, look: ForeignFile, axis: Axis | None, *, numbered: bool = False) -> None:
    console = report_console()
    if look.layout:
        of = look.layout
        header = (
            f"{of.above} lines above the header, {of.below} between it and the values"
            if of.named
            else f"{of.above} lines above the values, no names"
        )
        layout = f"{of.encoding}, separator {of.separator!r}, decimal {of.decimal!r}"
        pairs = ", every second comma is a decimal mark" * (of.separator == of.decimal)
        console.print(f"{log}: {layout}{pairs}, {header}", markup=False)
    shown = TextTable("", *[""] * numbered, "column", "seems to be", "unit", "because")
    for place, column in enumerate((_in_view_of(axis, column) for column in look.columns), start=1):
        what = f"{'commanded ' * column.setpoint}{column.quantity or '?'}"
        unit = (column.unit or "?") + " (guessed)" * (column.unit is not None and not column.stated)
        shown.add(*[str(place)] * numbered, column.header, what, unit, column.reason)
    console.print(shown)
    for header, reason in look.left_out.items():
        console.print(f"left out: {header!r} {reason}", markup=False)


def _in_view_of(axis: Axis | None, column: ForeignColumn) -> ForeignColumn:
    """The column; a position too long for metres may be an angle, and is one on an axis whose positions are angles."""
    if column.stated or column.unit != "mm":
        return column
    if axis is None:
        return replace(column, unit="mm or deg")
    units = {axis.signal_units[sensor.signal] for sensor in axis.sensors if sensor.quantity == "position"}
    return for_sensor(column, "", units.pop()) if len(units) == 1 else column


def _show_mapping(log: str, look: ForeignFile, mapping: LogMapping | None, options: dict[str, Any]) -> None:
    console = report_console()
    if mapping is None:
        console.print("\nThese are guesses. With --axis AXIS they become a mapping.")
        return
    if mapping.guesses:
        console.print(f"\nGuessed for {options['axis']}, check each:")
    for guess in mapping.guesses:
        console.print(f"    {with_options(guess)}", markup=False)
    for lack in mapping.missing:
        console.print(f"Missing: {with_options(lack)}", markup=False)
    faults = _uneven(look, mapping)
    for fault in faults:
        console.print(f"Sampling: {with_options(fault)}", markup=False)
    if options["output"]:
        check = "check each guess, delete those that you confirm, then" if mapping.guesses else "use it with"
        check = "give the missing options here, or to" if mapping.missing else check
        console.print(
            f"\nwrote {options['output']}: {check}\n    symid identify "
            f"{options['axis']} {log} --mapping {options['output']}" + " --resample own" * bool(faults),
            markup=False,
        )


def _uneven(look: ForeignFile, mapping: LogMapping) -> list[str]:
    """Reasons why a log is to be resampled: its clock, and values that are missing within it."""
    columns = dict(zip(look.table.headers, look.table.beginning(), strict=True))
    times = columns.get(mapping.columns.get("t", ""))
    if times is None or isinstance(times, str):
        return []
    seconds = times * to_si(mapping.units.get("t", "s"))
    faults = list(inspect_clock(seconds[np.isfinite(seconds)]).faults)
    for signal, name in mapping.columns.items():
        if isinstance(values := columns[name], str):
            continue
        if not np.isfinite(values[:-1]).all():  # a last row that is not complete is left out
            faults += inspect_finite(seconds, {signal: values})
    return [fault for fault in faults if "resample" in fault]
