"""`symid excite`: the reference for a first identification, within limits that the simulated axis keeps."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import click
import numpy as np
from click import Choice, IntRange, argument, option

from symid.axis import Axis, load_axis
from symid.cli.knowledge import fix_option, fixed_values, quantity
from symid.cli.options import (
    POSITIVE,
    bandwidth_option,
    gain_option,
    give_result,
    json_option,
    measured_option,
    named_values,
    parameter_file,
    parameter_option,
    shared,
    signal_list,
)
from symid.cli.outputs import Output, SafeCommand, overwrite_option
from symid.cli.simulate_command import cascades_of, with_imperfections
from symid.cli.terminal import say, tracked
from symid.codegen import model_of
from symid.data import REFERENCE, WRITTEN_SUFFIXES, Log, write_log
from symid.errors import SettingError
from symid.excitation import FINAL_RUNS, LEAST_RUNS, Design, IdentificationTrial, design
from symid.files import written_path
from symid.simulation import Limits, Trajectory, plant_of
from symid.units import Unit

_LIMITS = ("travel", "speed", "acceleration", "jerk")
"""In the order of derivatives."""
_REQUIRED = ("travel", "speed", "acceleration")

_run_options = shared(
    option("--seconds", type=POSITIVE, default=10.0, help="Duration."),
    option("--rate", type=POSITIVE, default=4000.0, help="Rate of controller and log, in Hz."),
    bandwidth_option,
    gain_option,
    option(
        "--method",
        type=Choice(["wls", "iv"]),
        default="wls",
        help="How the log will be identified: iv is free of the bias of encoder noise and takes several times as long.",
    ),
    option("--seeds", type=IntRange(0, 100), default=2, help="Multisines with random phases for each band."),
    option(
        "--runs",
        type=IntRange(LEAST_RUNS, 10_000),
        default=FINAL_RUNS,
        help="Simulated identifications for the expected errors of the chosen reference; a fifth for the defaults.",
    ),
)


@click.command(
    "excite",
    cls=SafeCommand,
    epilog="Example: symid excite rigid_1m --parameters P.json --noise q=1e-7 --noise F=1 "
    "--limits travel=0.4m,speed=1m/s,acceleration=8m/s^2,force=2kN -o reference.csv",
)
@argument("axis")
@parameter_option("Rough values of the parameters, SI.")
@fix_option
@option(
    "--noise",
    multiple=True,
    metavar="SIGNAL=STD",
    help="White noise of a signal, SI [as the axis declares it].",
)
@option(
    "--limits",
    "limits_text",
    required=True,
    metavar="NAME=VALUE,...",
    help="travel, speed, acceleration, and jerk and force if you like: travel=0.4m,speed=1m/s,acceleration=8m/s^2; "
    "apart, of several drives: by how much their positions may differ.",
)
@measured_option
@_run_options
@option("-o", "--output", required=True, metavar="LOG", type=Output("log"), help="Reference to write (.csv).")
@overwrite_option
@json_option
def command(axis: str, file: str, output: str, json_file: str | None, **options: Any) -> None:
    """Design the reference that identifies AXIS best.

    A few dozen jerk-limited moves, chirps and multisines are simulated under the controller, with the noise of the
    sensors, and identified; the one with the smallest worst relative deviation is written. Travel, speed, acceleration
    and force are those of the simulated axis, jerk is that of the reference. Several drives share one reference, unless
    --limits apart=... says by how much they may differ: each then has its own column.
    """
    written_path("reference", output, *WRITTEN_SUFFIXES)
    declared = with_imperfections(load_axis(axis), options)
    if known := fixed_values(options["fixed"], declared):
        declared = declared.with_known(known)
    parameters = parameter_file(file, declared)
    limits, force, apart = _limits(options["limits_text"], declared)
    controllers = cascades_of(declared, plant_of(declared, parameters), {**options, "force_limit": math.inf})
    model = model_of(
        declared if known else axis, signal_list(options["measured"]) or _noisy_sensors(declared)
    )
    method = options["method"]
    experiment = IdentificationTrial(declared, model, parameters, controllers, limits, force, apart, method)
    designed = design(
        experiment,
        options["seconds"],
        options["rate"],
        seeds=options["seeds"],
        runs=options["runs"],
        track=lambda every: tracked(every, "references"),
    )
    write_log(references_log(declared, designed.best.references), output)
    give_result(
        _record(designed, experiment, output), json_file, lambda _: _print(designed, experiment, output)
    )


def _noisy_sensors(axis: Axis) -> list[str]:
    """Sensors whose noise is known: the log is identified by them."""
    noisy = [sensor.signal for sensor in axis.sensors if sensor.noise > 0.0]
    if noisy:
        return noisy
    signals = [*(sensor.signal for sensor in axis.sensors), axis.drives[0].signal]
    raise SettingError(
        f"no sensor of axis {axis.name!r} has noise: give --noise {signals[0]}=STD, also of {signals[-1]}"
    )


def references_log(axis: Axis, paths: Sequence[Trajectory]) -> Log:
    """Commanded positions: one column where all drives share it, else one for each but the first."""
    log = paths[0].as_log()
    columns = {
        f"{REFERENCE}_{drive.signal}": path.position
        for drive, path in zip(axis.drives, paths, strict=True)
        if not np.array_equal(path.position, paths[0].position)
    }
    return replace(log, signals={**log.signals, **columns})


def _limits(text: str, axis: Axis) -> tuple[Limits, float, float | None]:
    """Limits, largest force and distance of drives of a text such as ``travel=0.4m,speed=1m/s``."""
    beyond = ("force", "apart") if len(axis.drives) > 1 else ("force",)
    given = named_values(tuple(text.split(",")), "--limits", (*_LIMITS, *beyond))
    if missing := [name for name in _REQUIRED if name not in given]:
        raise SettingError(f"--limits lacks {', '.join(missing)}: give for example {missing[0]}=1")
    position = axis.reference_units[0]
    moved = dict.fromkeys(map(str, axis.reference_units))
    if len(moved) > 1:
        raise SettingError(
            f"the drives of axis {axis.name!r} move in {' and '.join(moved)}: --limits holds for all drives, "
            "design a reference for each alone"
        )
    units = {name: position / Unit.of("s") ** order for order, name in enumerate(_LIMITS)}
    units |= {"force": axis.signal_units[axis.drives[0].signal], "apart": position}
    values = {name: quantity(value, units[name], f"--limits {name}") for name, value in given.items()}
    for name, value in values.items():
        if not value > 0.0:
            raise SettingError(f"--limits {name} is {value:g}: it must be positive")
    travel = values["travel"]
    jerk = values.get("jerk", math.inf)
    limits = Limits((-travel / 2, travel / 2), values["speed"], values["acceleration"], jerk)
    return limits, values.get("force", math.inf), values.get("apart")


def _record(designed: Design, experiment: IdentificationTrial, output: str) -> dict[str, Any]:
    references = {"designed": designed.best, **designed.defaults}
    return {
        "axis": experiment.axis.name,
        "measured": list(experiment.model.measured),
        "reference": output,
        "name": designed.best.trajectory.name,
        "seconds": designed.best.trajectory.duration,
        "tried": designed.tried,
        "limits": experiment.allowed,
        "undetermined": list(designed.best.undetermined),
        "expected": {
            name: expected
            and {
                "deviations": expected.deviations,
                "relative": expected.relative,
                "reached": expected.reached,
            }
            for name, expected in references.items()
        },
    }


def _print(designed: Design, experiment: IdentificationTrial, output: str) -> None:
    best, allowed = designed.best, experiment.allowed
    motion = best.trajectory
    low, high = motion.extremes.lowest, motion.extremes.highest
    say(f"{motion.name}: best of {designed.tried} references of {motion.duration:g} s")
    limited = [
        f"{name} {best.reached[name]:.3g} of {limit:g}"
        for name, limit in allowed.items()
        if math.isfinite(limit)
    ]
    say(f"reaches {', '.join(limited)} (SI); from {low:.3g} to {high:.3g} relative to its start")
    references = {"designed": best, **designed.defaults}
    say("expected relative deviation:")
    width = max(map(len, experiment.parameters))
    say("  " + " " * width + "".join(f"  {name:>18}" for name in references))
    for name in best.relative:
        cells = (
            "" if expected is None else f"{100 * expected.relative[name]:.3g} %"
            for expected in references.values()
        )
        say(f"  {name:<{width}}" + "".join(f"  {cell or 'not determined':>18}" for cell in cells))
    if best.undetermined:
        say(
            f"this does not determine {', '.join(best.undetermined)}, whose errors exceed their values: measure more, "
            "give what is known (--fix), or allow more time, travel, speed or acceleration"
        )
    columns = " and ".join(("t", *references_log(experiment.axis, best.references).signals))
    say(f"wrote {output}: columns {columns} at {1 / motion.sampling_period:g} Hz")
