"""`symid tune`: cutoff frequency and sampling period of an axis and its sensors."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import click
from click import Choice, argument, option

from symid.axis import Axis, load_axis
from symid.cli.knowledge import fix_option, fixed_values
from symid.cli.log_options import late_of, log_options, read_log_of
from symid.cli.options import (
    ORDER,
    POSITIVE,
    dark_option,
    give_result,
    held_force,
    json_option,
    late_option,
    measured_option,
    named_numbers,
    parameter_file,
    parameter_option,
    plot_option,
    signal_list,
)
from symid.cli.outputs import SafeCommand
from symid.cli.simulate_command import (
    SECONDS,
    band_of,
    cascades_of,
    controller_options,
    runs_of,
    trajectory_options,
)
from symid.cli.terminal import tracked
from symid.codegen import model_of
from symid.identification import Preparation, measured_signals
from symid.report.figures import palette_of, plot_total_tuning, plot_tuning, save_figure
from symid.report.tables import print_total_tuning, print_tuning, total_record, tuning_record
from symid.simulation import Controller, Plant, Trajectory, plant_of
from symid.tuning import (
    TotalTuning,
    Tuning,
    exact_run,
    excited_band,
    identified_and_tuned,
    tune,
    tune_total,
    tuning_chirp,
    without_jumps,
)

_DEFAULTS = {"trajectory": "chirp", "band": "modes", "rate": 20000.0, "bandwidth": 10.0}
"""Defaults that differ from `symid simulate`; the band "modes" is the result of `excited_band`."""


@click.command(
    "tune",
    cls=SafeCommand,
    context_settings={"default_map": _DEFAULTS},
    epilog="Example: symid tune direct_2m1s --parameters P.json --measured q2,ddq1 --plot tuning.png",
)
@argument("axis")
@parameter_option("A priori values of the parameters, SI.")
@fix_option
@measured_option
@option(
    "--max-lowpass-error",
    type=POSITIVE,
    default=0.01,
    help="Largest error that the low-pass filter may make [35], in percent.",
)
@option(
    "--max-sampling-error",
    type=POSITIVE,
    default=1.0,
    help="Largest error that differences may make [37], in percent.",
)
@option("--order", type=ORDER, default=4, help="Order of one pass of the filter.")
@option(
    "--errors-of",
    "kind",
    type=Choice(["physical", "minimal"]),
    default="physical",
    help="Parameters whose errors are bounded in [37].",
)
@option(
    "--keep-jumps",
    is_flag=True,
    help="Keep Coulomb friction and other laws that jump at standstill; the paper leaves them out.",
)
@trajectory_options
@controller_options
@option(
    "--noise-from",
    metavar="LOG",
    help="Minimise the total error of bias and noise, with the motion, the noise and the parameters of a log.",
)
@option(
    "--noise",
    multiple=True,
    metavar="SIGNAL=STD",
    help="As --noise-from, with white noise of this standard deviation, SI; without a log, give it for each signal.",
)
@option(
    "--log-rate", type=POSITIVE, default=4000.0, help="With --noise alone: rate of the planned log, in Hz."
)
@option(
    "--held",
    multiple=True,
    metavar="SIGNAL",
    help="With --noise-from: force held from sample to sample, which acts half a sample late.",
)
@late_option
@log_options
@plot_option("the errors by frequency")
@dark_option
@json_option
def command(axis: str, file: str, json_file: str | None, **options: Any) -> None:
    """Cutoff frequency and sampling period for AXIS.

    Without noise: the lowest cutoff and the lowest sampling frequency that keep the systematic errors within bounds.
    The axis is simulated along a chirp of constant velocity through all its modes, or along any other trajectory,
    and identified from the simulation. With --noise-from or --noise: the cutoff and the decimation of the smallest
    total error.
    """
    declared = load_axis(axis)
    parameters = parameter_file(file, declared, fixed_values(options["fixed"], declared))
    if options["noise_from"] or options["noise"]:
        total = _total(axis, declared, parameters, options)
        record = total_record(total)
        draw, show = partial(plot_total_tuning, total), partial(print_total_tuning, total)
    else:
        result = _bounded(declared, parameters, options)
        record = tuning_record(result)
        draw, show = partial(plot_tuning, result), partial(print_tuning, result)
    if options["plot"]:
        save_figure(draw(palette_of(options["dark"])), options["plot"])
    give_result(record, json_file, lambda _: show())


def _bounded(declared: Axis, parameters: dict[str, float], options: dict[str, Any]) -> Tuning:
    simulated = declared if options["keep_jumps"] else without_jumps(declared)
    controller, trajectory = _run_of(declared, plant_of(simulated, parameters), options)
    return tune(
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


def _total(name: str, declared: Axis, parameters: dict[str, float], options: dict[str, Any]) -> TotalTuning:
    """Tune by the total error, with the motion of a log or along a trajectory."""
    given = named_numbers(options["noise"], "--noise")
    if not options["noise_from"]:
        model = model_of(name, signal_list(options["measured"]))
        controller, trajectory = _run_of(declared, plant_of(declared, parameters), options)
        runs = (exact_run(declared, parameters, trajectory, controller),)
        settings = Preparation(order=options["order"])
        rate, track = options["log_rate"], _tracked
        return tune_total(declared, model, parameters, runs, rate, given, preparation=settings, track=track)
    log = read_log_of(declared, options["noise_from"], options)
    model = model_of(name, measured_signals(declared, [log], signal_list(options["measured"])))
    held = held_force(options["held"], declared)
    settings = Preparation(order=options["order"], held=held, late=late_of(options))
    return identified_and_tuned(
        declared, model, log, nominal=parameters, noise=given, preparation=settings, track=_tracked
    )


_tracked = partial(tracked, what="errors by frequency")


def _run_of(
    axis: Axis, plant: Plant, options: dict[str, Any]
) -> tuple[Sequence[Controller], Trajectory | Sequence[Trajectory]]:
    """Controllers and trajectories; a chirp of constant velocity runs under the velocity loop of the paper."""
    low, high = excited_band(plant) if options["band"] == "modes" else band_of(options["band"])
    is_velocity = options["trajectory"] == "chirp" and options["amplitude_of"] == "velocity"
    if not is_velocity or options["open_loop"]:
        return runs_of(axis, plant, {**options, "band": f"{low:g},{high:g}"})
    limits = {name: options[name] for name in ("travel", "speed", "acceleration")}
    reference = tuning_chirp(plant, options["rate"], options["seconds"] or SECONDS, (low, high), **limits)
    return cascades_of(axis, plant, options), reference
