"""`symid show`: what follows from a declaration."""

import click

from symid.axis import load_axis
from symid.cli.options import dark_option, give_result, json_option, measured_option, plot_option, signal_list
from symid.cli.outputs import SafeCommand
from symid.report.figures import palette_of
from symid.report.tables import derivation_record, print_derivation
from symid.symbolic import derive


@click.command("show", cls=SafeCommand, epilog="Example: symid show direct_2m1s --measured q2,ddq1")
@click.argument("axis")
@measured_option
@plot_option("the schematic of the axis")
@dark_option
@json_option
def command(axis: str, measured: str | None, plot: str | None, dark: bool, json_file: str | None) -> None:
    """Show the equations of motion, the eliminated model, the regressor and the parameter maps of AXIS."""
    declared = load_axis(axis)
    if plot:
        from symid.report.figures import (
            draw_schematic,
            save_figure,  # matplotlib takes a second to load
        )

        save_figure(draw_schematic(declared, palette_of(dark)), plot)
    model = derive(declared, signal_list(measured))
    give_result(derivation_record(model), json_file, lambda _: print_derivation(model))
