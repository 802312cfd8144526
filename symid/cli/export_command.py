"""`symid export`: an identified axis for other programs."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
from click import Choice, argument, option

from symid.axis import Axis, load_axis
from symid.cli.knowledge import fix_option, fixed_values
from symid.cli.options import json_option, measured_option, parameter_file, signal_list, write_json
from symid.cli.outputs import Output, SafeCommand
from symid.cli.terminal import say
from symid.errors import EliminationError, SettingError
from symid.export import TEXT_TARGETS, Exported, c_source, parameter_record, write_fmu
from symid.files import as_json, is_finite_number, read_json, write_whole
from symid.parameter_entries import entries_of
from symid.symbolic import derive

_PROGRAMS = ", ".join(target.program for target in TEXT_TARGETS.values())


def _kind_of_file(options: Mapping[str, Any]) -> str:
    return "exported" if options["to"] in TEXT_TARGETS else str(options["to"])


@click.command(
    "export",
    cls=SafeCommand,
    epilog="Example: symid export direct_2m1s --parameters P.json --to c --measured q2,ddq1 -o axis.c",
)
@argument("axis")
@option(
    "--parameters",
    required=True,
    metavar="P.json",
    help="Physical parameters, or what `symid identify --json` or `symid diagnose --write-axis` wrote.",
)
@fix_option
@option(
    "--to",
    type=Choice(("c", "fmu", "json", *TEXT_TARGETS)),
    required=True,
    help=f"C99, unit for co-simulation (FMI), {_PROGRAMS}, or JSON.",
)
@option("--fmi", type=Choice(["2", "3"]), default="2", help="With --to fmu: FMI 2.0 or 3.0.")
@measured_option
@option(
    "-o", "--output", metavar="FILE", type=Output(_kind_of_file), help="Where to write [standard output]."
)
@json_option
def command(axis: str, **options: Any) -> None:
    """Write AXIS with its parameters for another program, and name what that program cannot express."""
    declared = load_axis(axis)
    values = parameter_file(options["parameters"], declared, fixed_values(options["fixed"], declared))
    exported = _exported(declared, values, options)
    written = _write(exported, options["output"]) if options["output"] else []
    if options["json_file"]:
        record = {"axis": declared.name, "to": options["to"], "files": written, "losses": exported.losses}
        write_json(record if written else {**record, "text": exported.files}, options["json_file"])
    if not written and options["json_file"] != "-":
        say(exported.whole, end="")
    for file in written if options["json_file"] != "-" else ():
        say(f"wrote {file}")
    for loss in exported.losses:
        say(f"lost: {loss}", err=True)


def _exported(declared: Axis, values: dict[str, float], options: dict[str, Any]) -> Exported:
    if target := TEXT_TARGETS.get(options["to"]):
        return target.write(declared, values)
    if options["to"] == "fmu":
        if not options["output"]:
            raise SettingError("an FMU is written to a file: give its name with -o FILE.fmu")
        return Exported({}, write_fmu(declared, values, options["output"], 3 if options["fmi"] == "3" else 2))
    identified = _identified(options["parameters"])
    measured = signal_list(options["measured"]) or identified["measured"]
    if options["to"] == "c":
        header = Path(options["output"]).stem if options["output"] else None
        try:
            return c_source(derive(declared, measured), values, header)
        except EliminationError as error:
            exported = c_source(declared, values, header)
            return replace(exported, losses=(*exported.losses, f"Regressor: {error}."))
    model = derive(declared, measured)
    record = parameter_record(model, values, identified["covariance"], identified["minimal"])
    return Exported({".json": as_json(record)}, ())


def _identified(file: str) -> dict[str, Any]:
    """Sensors, covariance and minimal parameters of a file of `symid identify --json`, as far as it has them."""
    record = read_json(file)
    measured, covariance, minimal = (record.get(name) for name in ("measured", "covariance", "minimal"))
    if not isinstance(measured, list) or not all(isinstance(name, str) for name in measured):
        measured = None
    if not isinstance(covariance, dict):
        covariance = None
    values = {
        name: entry.value for name, entry in entries_of(minimal).items() if is_finite_number(entry.value)
    }
    return {"measured": measured, "covariance": covariance, "minimal": values or None}


def _write(exported: Exported, output: str) -> list[str]:
    """Write the main file, and the others beside it; a unit is written already."""
    path = Path(output)
    if not exported.files:
        return [output]
    main, *others = exported.files
    if path.suffix in others:
        raise SettingError(
            f"{output} would be the file beside the main one: give a name that ends with {main}"
        )
    files = {path: exported.files[main]} | {path.with_suffix(s): exported.files[s] for s in others}
    for file, text in files.items():
        write_whole(file, text)
    return list(map(str, files))
