"""Each kind of result as text, in a notebook, as a figure and as a page."""

import io
import textwrap
from collections.abc import Iterable
from functools import singledispatch
from pathlib import Path
from typing import Any

from rich.console import Console

from symid import __version__
from symid.axis import Axis, declared_lines, load_axis
from symid.codegen import GeneratedModel
from symid.data import Log
from symid.diagnosis import Diagnosis
from symid.errors import SettingError
from symid.files import write_whole
from symid.fleet import Batch, review_fleet, summary_of
from symid.identification import Identification, SharedIdentification, read_axis_log
from symid.output_error import OutputErrorIdentification
from symid.report.figures.drawn import Drawn, wide_and_narrow
from symid.report.figures.identification_figure import plot_identification
from symid.report.figures.overviews import batch_figure, diagnosis_figure, log_figure
from symid.report.figures.schematic import draw_schematic
from symid.report.figures.tuning_figure import plot_total_tuning, plot_tuning
from symid.report.pages.diagnosis_page import write_diagnosis_html
from symid.report.pages.fleet_page import write_fleet_html
from symid.report.pages.identification_page import write_identification_html
from symid.report.pages.page import html_path, page_templates
from symid.report.tables.console import ReportConsole
from symid.report.tables.derivation import print_derivation
from symid.report.tables.diagnosis import diagnosis_record, print_diagnosis
from symid.report.tables.fleet import print_batch
from symid.report.tables.identification import (
    identification_record,
    print_identification,
    print_shared,
    shared_record,
)
from symid.report.tables.output_error import output_error_record
from symid.report.tables.tuning import print_total_tuning, print_tuning
from symid.shown import Shown
from symid.symbolic import DerivedModel
from symid.tuning import TotalTuning, Tuning

_WIDTH = 120
_PRE = '<pre tabindex="0" style="line-height:1.3;overflow-x:auto">{code}</pre>'
"""Text that scrolls, also by the keyboard."""


@singledispatch
def show(result: object, console: Console) -> None:
    """Print a result on a console."""
    raise SettingError(f"a {type(result).__name__} cannot be printed")


@show.register
def _(axis: Axis, console: Console) -> None:
    console.print(f"[bold]{axis.name}[/bold]")
    for declared in declared_lines(axis):
        console.print(textwrap.indent(declared, "    "), markup=False)
    units = (f"{name} [{unit}]" for name, unit in axis.physical_parameters.items())
    console.print(f"parameters: {', '.join(units)}", markup=False)


@show.register
def _(log: Log, console: Console) -> None:
    console.print(log.headline, markup=False)
    for name, values in log.signals.items():
        console.print(f"    {name}: {values.min():.6g} to {values.max():.6g}", markup=False)
    for note in log.notes:
        console.print(f"note: {note}", markup=False)


@show.register
def _(model: GeneratedModel, console: Console) -> None:
    console.print(f"[bold]{model.axis}[/bold] measured by {', '.join(model.measured)}")
    console.print(f"equations of {', '.join(model.output_names)}", markup=False)
    for kind, units in (("minimal", model.minimal_units), ("physical", model.physical_units)):
        named = ", ".join(f"{name} [{unit}]" for name, unit in units.items())
        console.print(f"{kind} parameters: {named}", markup=False)
    for assumption in model.assumptions:
        console.print(f"assumed: {assumption}", markup=False)


show.register(DerivedModel, print_derivation)
show.register(Tuning, print_tuning)
show.register(TotalTuning, print_total_tuning)
show.register(Identification, lambda found, to: print_identification(identification_record(found), to))
show.register(SharedIdentification, lambda found, to: print_shared(shared_record(found), to))
show.register(
    OutputErrorIdentification, lambda found, to: print_identification(output_error_record(found), to)
)
show.register(Batch, lambda batch, to: print_batch(summary_of(batch), to))
show.register(Diagnosis, lambda found, to: print_diagnosis(diagnosis_record(found), to))


def as_text(result: object) -> str:
    """A result as the command line prints it, without the colours of a terminal."""
    console = _console()
    show(result, console)
    return console.export_text().rstrip("\n")


def as_html(result: object) -> str:
    """A result as an element of a page; all text is escaped."""
    console = _console()
    show(result, console)
    return console.export_html(code_format=_PRE, inline_styles=True)


def _console() -> Console:
    # In a notebook rich would display each line itself, in addition to the text that it returns.
    text: Any = {"file": io.StringIO(), "record": True, "width": _WIDTH, "soft_wrap": True}
    return ReportConsole(**text, highlight=False, force_jupyter=False)


@singledispatch
def figure(result: object, **settings: Any) -> Drawn:
    """Figure of a result, chosen by its type."""
    raise SettingError(f"a {type(result).__name__} cannot be drawn")


figure.register(Log, log_figure)
figure.register(DerivedModel, lambda model, **settings: figure(model.axis, **settings))
figure.register(GeneratedModel, lambda model, **settings: figure(load_axis(model.axis), **settings))
figure.register(OutputErrorIdentification, plot_identification)
figure.register(Tuning, plot_tuning)
figure.register(TotalTuning, plot_total_tuning)
figure.register(Batch, batch_figure)
figure.register(Diagnosis, diagnosis_figure)


@figure.register
def _(axis: Axis, *, narrow: bool = False, **settings: Any) -> Drawn:  # narrow as it is
    return draw_schematic(axis, **settings)


@figure.register
def _(
    result: Identification, *, axis: Axis | str | None = None, runs: Iterable[Any] = (), **settings: Any
) -> Drawn:
    declared = load_axis(axis) if isinstance(axis, str) else axis
    known = declared or result.axis
    logs = [run if known is None or isinstance(run, Log) else read_axis_log(known, run) for run in runs]
    return plot_identification(result, axis=declared, runs=logs, **settings)


@singledispatch
def write_page(result: Shown, path: str | Path) -> Path:
    """Write a page with text and figure of a result, and return its path."""
    page, name = html_path(path), result.headline
    template = page_templates().get_template("result.html")
    drawn = wide_and_narrow(lambda narrow: figure(result, narrow=narrow), "plot")
    write_whole(page, template.render(name=name, text=as_html(result), drawn=drawn, version=__version__))
    return page


write_page.register(Identification, write_identification_html)
write_page.register(OutputErrorIdentification, write_identification_html)
write_page.register(Diagnosis, write_diagnosis_html)


@write_page.register
def _(batch: Batch, path: str | Path) -> Path:
    return write_fleet_html(review_fleet(batch.table, units=batch.units), path)
