"""`symid simulate`: a log of an axis under its controller."""

import math
from functools import partial
from pathlib import Path
from typing import Any

import click
import numpy as np
from click import Choice, IntRange, argument, option

from symid.axis import Axis, load_axis
from symid.cli.knowledge import fix_option, fixed_values
from symid.cli.options import (
    LIMIT,
    NOT_NEGATIVE,
    POSITIVE,
    bandwidth_option,
    cascade_gains,
    gain_option,
    give_result,
    json_option,
    named_numbers,
    named_values,
    number,
    parameter_file,
    parameter_option,
    require_signals,
    seconds_of,
    shared,
)
from symid.cli.outputs import Output, SafeCommand, overwrite_option
from symid.cli.terminal import say, tracked
from symid.data import WRITTEN_SUFFIXES, columns_in, read_log, write_log
from symid.errors import SettingError
from symid.files import written_path
from symid.simulation import (
    Cascade,
    Controller,
    OpenLoop,
    Plant,
    Trajectory,
    chirp,
    from_log,
    largest_within,
    plant_of,
    simulate,
    trapezoids,
    tuned_cascades,
    whole_periods,
)

SECONDS = 10.0
"""Duration of a chirp or multisine."""
_LINES = 21
"""Lines of a multisine."""

trajectory_options = shared(
    option(
        "--trajectory",
        default="trapezoids",
        metavar="KIND",
        help="trapezoids, chirp, multisine, or a log whose reference is followed.",
    ),
    option(
        "--seconds",
        type=POSITIVE,
        help="Duration [10; trapezoids: there and back once at each speed]; moves are repeated and cut to it.",
    ),
    option("--band", default="0.5,20", metavar="HZ,HZ", help="Frequencies of a chirp or multisine."),
    option(
        "--amplitude-of",
        type=Choice(["position", "velocity", "acceleration"]),
        default="velocity",
        help="Quantity of constant amplitude in a chirp; acceleration travels farthest, position least.",
    ),
    option(
        "--travel",
        type=POSITIVE,
        default=0.2,
        help="Longest move, or travel of a chirp or multisine, in m or rad.",
    ),
    option(
        "--speed",
        type=POSITIVE,
        default=0.5,
        help="Highest speed; trapezoids also run at a half and a fifth of it.",
    ),
    option("--acceleration", type=POSITIVE, default=5.0, help="Highest acceleration."),
    option("--jerk", type=POSITIVE, default=500.0, help="Highest jerk of trapezoids."),
    option("--dwell", type=NOT_NEGATIVE, default=0.2, help="Rest between trapezoids, in seconds."),
)

controller_options = shared(
    option("--rate", type=POSITIVE, default=8000.0, help="Rate of the controller, in Hz."),
    bandwidth_option,
    gain_option,
    option("--force-limit", type=LIMIT, default=math.inf, help="Largest force."),
    option("--open-loop", metavar="LOG", help="Apply the force of a log instead of controlling."),
)


@click.command(
    "simulate", cls=SafeCommand, epilog="Example: symid simulate rigid_1m --parameters P.json -o run.csv"
)
@argument("axis")
@parameter_option("Values of the physical parameters, SI.")
@fix_option
@option(
    "-o",
    "--output",
    required=True,
    metavar="LOG",
    type=Output("log"),
    help="Log to write (.csv or .parquet).",
)
@overwrite_option
@trajectory_options
@controller_options
@option("--log-rate", type=POSITIVE, help="Rate of the log, in Hz [that of the controller].")
@option("--noise", multiple=True, metavar="SIGNAL=STD", help="White noise of a signal, SI.")
@option("--resolution", multiple=True, metavar="SIGNAL=STEP", help="Step of a signal, SI.")
@option("--delay", multiple=True, metavar="SIGNAL=TIME", help="Delay of a sensor's reading, such as q=250us.")
@option("--seed", type=IntRange(0, 2**63), default=0, help="Seed of the noise.")
@option(
    "--start",
    type=Choice(["zero", "equilibrium"]),
    default="zero",
    show_default=True,
    help="State at the first sample: at rest at zero with all springs relaxed, or at rest at the first reference, "
    "weights held by springs and controllers.",
)
@json_option
def command(axis: str, file: str, output: str, json_file: str | None, **options: Any) -> None:
    """Simulate AXIS under its controller along a trajectory and write the log."""
    file_of_log = written_path("log", output, *WRITTEN_SUFFIXES)
    declared = with_imperfections(load_axis(axis), options)
    parameters = parameter_file(file, declared, fixed_values(options["fixed"], declared))
    plant = plant_of(declared, parameters)
    controllers, trajectories = runs_of(declared, plant, options)
    trajectory = trajectories[0]
    run = simulate(
        declared,
        parameters,
        trajectories,
        controllers,
        frequency_hz=options["log_rate"],
        seed=options["seed"],
        start="equilibrium" if options["start"] == "equilibrium" else None,
        progress=partial(tracked, what="parts of the simulation"),
    )
    write_log(run.log, file_of_log)
    record = {
        "axis": declared.name,
        "log": output,
        "samples": run.log.n_samples,
        "sampling_frequency_hz": run.log.sampling_frequency,
        "signals": {name: str(unit) for name, unit in declared.signal_units.items()},
        "largest_force": float(abs(run.forces).max()),
        "reference": {"seconds": trajectory.duration, **trajectory.extremes.reached},
    }
    duration, done = trajectory.duration, f"{run.log.n_samples} samples at {run.log.sampling_frequency:g} Hz"

    def show(_: object) -> None:
        if options["trajectory"] in ("chirp", "multisine") and not options["open_loop"]:
            say(_said_reach(declared, trajectory, options))
        say(f"wrote {output}: {done}, {duration:g} s")

    give_result(record, json_file, show)


def with_imperfections(axis: Axis, options: dict[str, Any]) -> Axis:
    """The axis with the noise, resolution and delay given as options."""
    noise, resolution = (
        named_numbers(options.get(name, ()), f"--{name}") for name in ("noise", "resolution")
    )
    delay = named_values(options.get("delay", ()), "--delay")
    signals = dict.fromkeys([*noise, *resolution, *delay])
    require_signals(axis, signals)
    for signal in signals:
        axis = axis.with_signal(
            signal,
            noise=noise.get(signal, 0.0),
            resolution=resolution.get(signal, 0.0),
            delay=seconds_of(delay.get(signal, "0"), f"--delay {signal}"),
        )
    return axis


def runs_of(
    axis: Axis, plant: Plant, options: dict[str, Any]
) -> tuple[tuple[Controller, ...], tuple[Trajectory, ...]]:
    """Controller and trajectory of each drive; in open loop, both come from the log of the forces.

    A log given as trajectory may have a reference for each drive.
    """
    if options["open_loop"]:
        # Loading its package takes an eighth of the time of a simulation.
        from symid.identification import read_axis_log

        log = read_axis_log(axis, options["open_loop"])
        path = from_log(log, next(iter(plant.sensors)))
        return tuple(OpenLoop(log[drive.signal]) for drive in axis.drives), (path,) * len(axis.drives)
    file = options["trajectory"]
    if not Path(file).suffix:
        trajectories = (_trajectory(options),) * len(axis.drives)
    else:
        unit = axis.reference_units[0]
        references = {
            f"reference_{d.signal}": u for d, u in zip(axis.drives, axis.reference_units, strict=True)
        }
        if not columns_in(file) & {"reference", *references}:
            raise SettingError(f"{file}: has no column to follow: call one reference, in {unit}")
        log = read_log(file, expected={"reference": unit, **references})
        trajectories = tuple(
            from_log(log, name if name in log.signals else "reference") for name in references
        )
    return cascades_of(axis, plant, options), trajectories


def cascades_of(axis: Axis, plant: Plant, options: dict[str, Any]) -> tuple[Cascade, ...]:
    """Cascade of the controller options for each drive."""
    tuned = tuned_cascades(plant, axis.controlled_signals, options["bandwidth"], options["force_limit"])
    return tuple(cascade.with_gains(**cascade_gains(options["gains"])) for cascade in tuned)


def _trajectory(options: dict[str, Any]) -> Trajectory:
    period, kind = 1.0 / options["rate"], options["trajectory"]
    if kind == "trapezoids":
        once = trapezoids(
            options["travel"],
            [options["speed"] / 5, options["speed"] / 2, options["speed"]],
            acceleration=options["acceleration"],
            jerk=options["jerk"],
            dwell=options["dwell"],
            sampling_period=period,
        )
        return once.lasting(options["seconds"]) if options["seconds"] else once
    low, high = band_of(options["band"])
    seconds = options["seconds"] or SECONDS
    if kind == "chirp":
        swept = {"quantity": options["amplitude_of"], "sweep": "logarithmic"}
        return largest_within(partial(chirp, low, high, seconds, sampling_period=period, **swept), options)
    if kind == "multisine":
        lines, rate = np.linspace(low, high, _LINES), options["rate"]
        accelerated = {"seconds": seconds, "rate": rate, "quantity": "acceleration"}
        return largest_within(partial(whole_periods, lines, **accelerated), options)
    raise SettingError(
        f"trajectory {kind!r} is not known: use trapezoids, chirp, multisine or the path of a log"
    )


def _said_reach(axis: Axis, trajectory: Trajectory, options: dict[str, Any]) -> str:
    """Text on the reached share of each limit, and the limit that binds."""
    unit = axis.reference_units[0]
    reached = trajectory.extremes.reached
    units = (str(unit), f"{unit}/s", f"{unit}/s^2")
    shown = zip(reached.items(), units, strict=True)
    parts = [f"{name} {value:.3g} of {options[name]:g} {unit}" for (name, value), unit in shown]
    tightest = max(reached, key=lambda name: reached[name] / options[name])
    hint = ""
    if tightest != "travel":
        cure = ", or --amplitude-of acceleration" if options["amplitude_of"] != "acceleration" else ""
        cure = cure if options["trajectory"] == "chirp" else ""
        hint = f"; {tightest} is the limit: for more travel raise it, lower --band{cure}"
    return f"the reference reaches {', '.join(parts)}{hint}"


def band_of(text: str) -> tuple[float, float]:
    """Two rising frequencies in Hz."""
    parts = [number(part, "--band") for part in text.split(",")]
    if len(parts) != 2 or not 0 < parts[0] < parts[1]:
        raise SettingError(f"--band {text!r} is not LOW,HIGH in Hz: write for example --band 0.5,20")
    return parts[0], parts[1]
