"""`symid tune`: cutoff frequency and sampling period of an axis and its sensors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import click

from symid.axis import Axis, load_axis
from symid.cli.options import json_option, measured_option, parameter_file, signal_list, write_json
from symid.cli.progress import tracked
from symid.cli.simulate import band_of, cascade_of, controller_options, run_of, trajectory_options
from symid.report.tuning import plot_tuning, print_tuning, tuning_record
from symid.simulation import Controller, Plant, Trajectory, plant_of
from symid.tuning import excited_band, tune, tuning_chirp, without_jumps

_DEFAULTS = {"trajectory": "chirp", "band": "modes", "rate": 20000.0, "bandwidth": 10.0}
"""Where this command differs from `symid simulate`; the band "modes" is that of `excited_band`."""


@click.command(
    "tune",
    context_settings={"default_map": _DEFAULTS},
    epilog="Example: symid tune direct_2m1s --parameters P.json --measured q2,ddq1 --plot tuning.png",
)
@click.argument("axis")
@click.option(
    "--parameters", "file", required=True, metavar="P.json", help="A priori values of the parameters, SI."
)
@measured_option
@click.option(
    "--max-lowpass-error",
    default=0.01,
    show_default=True,
    help="Largest error that the low-pass filter may make [35], in percent.",
)
@click.option(
    "--max-sampling-error",
    default=1.0,
    show_default=True,
    help="Largest error that differences may make [37], in percent.",
)
@click.option("--order", default=4, show_default=True, help="Order of one pass of the filter.")
@click.option(
    "--errors-of",
    "kind",
    type=click.Choice(["physical", "minimal"]),
    default="physical",
    show_default=True,
    help="Parameters whose errors are bounded in [37].",
)
@click.option(
    "--keep-jumps",
    is_flag=True,
    help="Keep Coulomb friction and other laws that jump at standstill; the paper leaves them out.",
)
@trajectory_options
@controller_options
@click.option("--plot", metavar="FILE", help="Draw the errors by frequency (png, svg or pdf).")
@json_option
def command(axis: str, file: str, json_file: str | None, **options: Any) -> None:
    """Lowest cutoff and lowest sampling frequency that keep the systematic errors of AXIS within bounds.

    The axis is simulated without noise along a chirp of constant velocity through all its modes, or along any
    other trajectory, and identified from the simulation.
    """
    declared = load_axis(axis)
    parameters = parameter_file(file, declared)
    simulated = declared if options["keep_jumps"] else without_jumps(declared)
    controller, trajectory = _run_of(declared, plant_of(simulated, parameters), options)
    found = tune(
        declared,
        parameters,
        signal_list(options["measured"]),
        trajectory=trajectory,
        controller=controller,
        max_lowpass_error=options["max_lowpass_error"],
        max_sampling_error=options["max_sampling_error"],
        order=options["order"],
        keep_jumps=options["keep_jumps"],
        kind=options["kind"],
        track=_tracked,
    )
    record = tuning_record(found)
    if options["plot"]:
        plot_tuning(found, options["plot"])
    if json_file:
        write_json(record, json_file)
    if json_file != "-":
        print_tuning(found)


def _tracked(frequencies: Sequence[float]) -> Iterator[float]:
    return tracked(frequencies, "errors by frequency")


def _run_of(axis: Axis, plant: Plant, options: dict[str, Any]) -> tuple[Controller, Trajectory]:
    """Controller and trajectory; a chirp has constant velocity here, as the velocity loop of the paper gets."""
    low, high = excited_band(plant) if options["band"] == "modes" else band_of(options["band"])
    if options["trajectory"] != "chirp" or options["open_loop"]:
        return run_of(axis, plant, {**options, "band": f"{low:g},{high:g}"})
    limits = {name: options[name] for name in ("travel", "speed", "acceleration")}
    reference = tuning_chirp(plant, options["rate"], options["seconds"], (low, high), **limits)
    return cascade_of(axis, plant, options), reference
