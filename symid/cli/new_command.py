"""`symid new`: a commented axis file to edit."""

from keyword import iskeyword
from pathlib import Path

import click
from click import IntRange, argument, option

from symid.axis import load_axis, shipped_folder, sketch, sketch_source
from symid.cli.options import give_result, json_option
from symid.cli.outputs import SafeCommand
from symid.cli.terminal import say
from symid.errors import SettingError
from symid.files import write_whole
from symid.signal_names import is_signal_name


@click.command(
    "new",
    cls=SafeCommand,
    epilog="Example: symid new my_axis --bodies 3 --structure --accelerometer structure",
)
@argument("axis")
@option("--bodies", type=IntRange(max=100), default=2, help="Bodies in a row, the structure included.")
@option("--springs", type=IntRange(max=100), help="Springs: one less than bodies, or as many [one less].")
@option("--structure/--no-structure", default=False, help="Whether the first body is a flexible structure.")
@option("--rotary/--linear", default=False, help="Whether bodies turn.")
@option("--coulomb/--no-coulomb", default=True, help="Whether the motor has Coulomb friction.")
@option(
    "--encoder", "encoders", multiple=True, metavar="BODY", help="A body with an encoder besides the motor."
)
@option(
    "--accelerometer", "accelerometers", multiple=True, metavar="BODY", help="A body with an accelerometer."
)
@option(
    "--drives",
    type=IntRange(1, 20),
    default=1,
    help="Drives, each with a motor and its encoder: 2 for a gantry.",
)
@json_option
def command(
    axis: str,
    bodies: int,
    springs: int | None,
    structure: bool,
    rotary: bool,
    coulomb: bool,
    encoders: tuple[str, ...],
    accelerometers: tuple[str, ...],
    drives: int,
    json_file: str | None,
) -> None:
    """Write the file of a new AXIS: models/AXIS.py for a name, or the given path that ends with .py."""
    path = Path(axis) if axis.endswith(".py") else Path("models") / f"{axis}.py"
    named = axis if not axis.endswith(".py") else path.stem  # a name is not a path
    if not is_signal_name(named) or iskeyword(named):
        raise SettingError(
            f"{axis!r} cannot name an axis: use letters, digits and underscores, a letter first"
        )
    if not axis.endswith(".py") and (shipped_folder("models") / f"{axis}.py").exists():
        raise SettingError(
            f"{axis!r} names an axis that comes with symid, which a file of models would hide: choose another name"
        )
    if path.exists():
        raise SettingError(f"axis file {str(path)!r} exists: choose another name, or delete it first")
    sketched = sketch(
        path.stem,
        bodies,
        springs,
        structure=structure,
        rotary=rotary,
        coulomb=coulomb,
        encoders=encoders,
        accelerometers=accelerometers,
        drives=drives,
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, sketch_source(sketched))
    load_axis(str(path))
    record = {"axis": sketched.name, "file": str(path)}
    give_result(record, json_file, lambda _: say(f"wrote {path}: edit it, then symid show {axis}"))
