"""`symid generate`: regressors from declarations."""

import sys

import click
from click import argument, option

from symid.cli.options import json_option, measured_option, signal_list, write_json
from symid.cli.outputs import SafeCommand
from symid.cli.terminal import say, tracked
from symid.codegen import write_stale
from symid.codegen.generation import plan


@click.command("generate", cls=SafeCommand, epilog="Example: symid generate direct_2m1s")
@argument("axes", nargs=-1, metavar="[AXIS ...]")
@measured_option
@option("--check", is_flag=True, help="Write nothing; exit with 1 and print a diff if anything is stale.")
@json_option
def command(axes: tuple[str, ...], measured: str | None, check: bool, json_file: str | None) -> None:
    """Write the generated modules and forward dynamics of each AXIS (of all axes in models/ by default).

    Modules that cannot be derived are named with the reason, the others are written, and the exit code is 1.
    """
    refused: list[tuple[str, str]] = []
    files = plan(
        axes,
        signal_list(measured),
        track=lambda names: tracked(names, "deriving axes"),
        refused=lambda path, error: refused.append((path.name, str(error))),
    )
    stale = [file for file in files if not file.is_current]
    if not check:
        write_stale(files)
    if json_file:
        write_json(
            {
                "checked": len(files),
                "stale" if check else "written": [file.path.name for file in stale],
                **({"refused": dict(refused)} if refused else {}),
            },
            json_file,
        )
    if json_file != "-":
        for file in stale:
            say(
                file.diff() if check else f"{'removed' if file.wanted is None else 'wrote'} {file.path.name}",
                end="" if check else "\n",
            )
        say(f"{len(files) - len(stale)} of {len(files)} files {'are' if check else 'were'} current")
    for name, reason in refused:
        click.echo(f"symid: {name} cannot be derived: {reason}", err=True)
    if refused or (check and stale):
        sys.exit(1)
