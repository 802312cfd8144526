"""`symid excite`: the reference for a first identification, within limits that the simulated axis keeps."""

from __future__ import annotations

import math
from typing import Any

import click

from symid.axis import Axis, load_axis
from symid.cli.knowledge import quantity
from symid.cli.number_types import POSITIVE
from symid.cli.options import (
    assignments,
    bandwidth_option,
    gain_option,
    give_result,
    json_option,
    measured_option,
    parameter_file,
    reference_file,
    shared,
    signal_list,
)
from symid.cli.outputs import Output, SafeCommand, overwrite_option
from symid.cli.progress import tracked
from symid.cli.saying import say
from symid.cli.simulate import cascade_of, with_imperfections
from symid.codegen import model_of
from symid.data import write_log
from symid.errors import SettingError
from symid.excitation import Design, IdentificationTrial, design
from symid.simulation import Limits, plant_of
from symid.units import Unit

_LIMITS = ("travel", "speed", "acceleration", "jerk")
"""In the order of derivatives."""
_REQUIRED = ("travel", "speed", "acceleration")

_run_options = shared(
    click.option("--seconds", type=POSITIVE, default=10.0, show_default=True, help="Duration."),
    click.option(
        "--rate", type=POSITIVE, default=4000.0, show_default=True, help="Rate of controller and log, in Hz."
    ),
    bandwidth_option,
    gain_option,
    click.option(
        "--seeds",
        type=click.IntRange(0, 100),
        default=2,
        show_default=True,
        help="Multisines with random phases for each band.",
    ),
)


@click.command(
    "excite",
    cls=SafeCommand,
    epilog="Example: symid excite rigid_1m --parameters P.json --noise q=1e-7 --noise F=1 "
    "--limits travel=0.4m,speed=1m/s,acceleration=8m/s^2,force=2kN -o reference.csv",
)
@click.argument("axis")
@click.option(
    "--parameters", "file", required=True, metavar="P.json", help="Rough values of the parameters, SI."
)
@click.option(
    "--noise", multiple=True, required=True, metavar="SIGNAL=STD", help="White noise of a signal, SI."
)
@click.option(
    "--limits",
    "limits_text",
    required=True,
    metavar="NAME=VALUE,...",
    help="travel, speed, acceleration, and jerk and force if you like: travel=0.4m,speed=1m/s,acceleration=8m/s^2.",
)
@measured_option
@_run_options
@click.option(
    "-o", "--output", required=True, metavar="LOG", type=Output("log"), help="Reference to write (.csv)."
)
@overwrite_option
@json_option
def command(axis: str, file: str, output: str, json_file: str | None, **options: Any) -> None:
    """Design the reference that identifies AXIS best.

    A few dozen jerk-limited moves, chirps and multisines are simulated under the controller, with the noise of the
    sensors, and identified; the one with the smallest worst relative deviation is written. Travel, speed, acceleration
    and force are those of the simulated axis, jerk is that of the reference.
    """
    reference_file(output)
    declared = with_imperfections(load_axis(axis), options)
    parameters = parameter_file(file, declared)
    limits, force = _limits(options["limits_text"], declared)
    controller = cascade_of(declared, plant_of(declared, parameters), {**options, "force_limit": math.inf})
    model = model_of(axis, signal_list(options["measured"]))
    experiment = IdentificationTrial(declared, model, parameters, controller, limits, force)
    found = design(
        experiment,
        options["seconds"],
        options["rate"],
        seeds=options["seeds"],
        track=lambda every: tracked(every, "references"),
    )
    write_log(found.best.trajectory.as_log(), output)
    give_result(_record(found, experiment, output), json_file, lambda _: _print(found, experiment, output))


def _limits(text: str, axis: Axis) -> tuple[Limits, float]:
    """Limits and largest force of a text such as ``travel=0.4m,speed=1m/s``."""
    given = assignments(tuple(text.split(",")), "--limits")
    if unknown := [name for name in given if name not in (*_LIMITS, "force")]:
        raise SettingError(f"--limits {unknown[0]} is not known: choose from {', '.join(_LIMITS)}, force")
    if missing := [name for name in _REQUIRED if name not in given]:
        raise SettingError(f"--limits lacks {', '.join(missing)}: give for example {missing[0]}=1")
    position = axis.signal_units[axis.controlled]
    units = {name: position / Unit.of("s") ** order for order, name in enumerate(_LIMITS)}
    units["force"] = axis.signal_units[axis.only_drive.signal]
    values = {name: quantity(value, units[name], f"--limits {name}") for name, value in given.items()}
    for name, value in values.items():
        if not value > 0.0:
            raise SettingError(f"--limits {name} is {value:g}: it must be positive")
    travel = values["travel"]
    limits = Limits(
        (-travel / 2, travel / 2), values["speed"], values["acceleration"], values.get("jerk", math.inf)
    )
    return limits, values.get("force", math.inf)


def _record(found: Design, experiment: IdentificationTrial, output: str) -> dict[str, Any]:
    every = {"designed": found.best, **found.defaults}
    return {
        "axis": experiment.axis.name,
        "reference": output,
        "name": found.best.trajectory.name,
        "seconds": found.best.trajectory.duration,
        "tried": found.tried,
        "limits": experiment.allowed,
        "expected": {
            name: one and {"deviations": one.deviations, "relative": one.relative, "reached": one.reached}
            for name, one in every.items()
        },
    }


def _print(found: Design, experiment: IdentificationTrial, output: str) -> None:
    best, allowed = found.best, experiment.allowed
    motion = best.trajectory
    low, high = motion.extremes.lowest, motion.extremes.highest
    say(f"{motion.name}: best of {found.tried} references of {motion.duration:g} s")
    limited = [
        f"{name} {best.reached[name]:.3g} of {limit:g}"
        for name, limit in allowed.items()
        if math.isfinite(limit)
    ]
    say(f"reaches {', '.join(limited)} (SI); from {low:.3g} to {high:.3g} about where it begins")
    every = {"designed": best, **found.defaults}
    say("expected relative deviation:")
    width = max(map(len, experiment.parameters))
    say("  " + " " * width + "".join(f"  {name:>18}" for name in every))
    for name in best.relative:
        cells = ("" if one is None else f"{100 * one.relative[name]:.3g} %" for one in every.values())
        say(f"  {name:<{width}}" + "".join(f"  {cell or 'not determined':>18}" for cell in cells))
    say(f"wrote {output}: columns t and reference at {1 / motion.sampling_period:g} Hz")
