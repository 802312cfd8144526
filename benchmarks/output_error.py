"""Maximum likelihood on the sampled axis (`--method oe`): the paper's axis at 250 Hz, spread, limits, a real bench.

(a) The paper's axis under a loop at the CNC's own 250 Hz, trapezoids, its force held. White noise adds to the force
in the axis and to the encoder that the loop reads; or, "in the record", to the log alone. Method 1 (wls) beside oe;
Table 10 of the paper has errors of 24 % for Ms and 92 % for Ks. (a') The loop at 8 kHz, where the log keeps single
samples of the force, or its mean over the interval.
(b) The spread of oe over 200 draws of the noise beside the Cramer-Rao bound, and how often its 95 % intervals hold the
truth. The bound is computed densely by its own code: mean and covariance of all readings given the logged force, by
differences; noise levels and initial state are unknown in it too. The first draws begin from an unknown start, the
others where the first draw ended. (c) Smoother trapezoids: what fades. (d) The real bench of data/flex_motor_bench,
every n-th sample kept: motor encoder alone and both encoders, the current as point samples and as mean over the new
interval, as a drive might log it. (e) Rough starts.

Usage: python -m benchmarks.output_error [--quick]
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

import symid
from benchmarks.cramer_rao import cramer_rao
from benchmarks.options import parser_of
from benchmarks.output_error_bench import print_bench, row
from benchmarks.paper_axis_logs import (
    LOUD,
    PAPER,
    QUIET,
    SMOOTH,
    direct,
    disturbed,
    machine,
    moves,
    noisy,
    recorded_with_noise,
    without_friction,
)
from symid.axis import Axis
from symid.identification import Preparation
from symid.output_error import OutputErrorIdentification, identify_output_error
from symid.output_error.error_model import ErrorModel
from symid.output_error.rough_starts import rigid_start, spread, with_heavy_bodies
from symid.simulation import Simulation, forward_dynamics, plant_of, simulate, tuned_cascade

DRAWS, UNKNOWN_START = 200, 5


def errors(found: Mapping[str, float], truth: Mapping[str, float]) -> dict[str, float]:
    """Errors in percent of the truth, of the parameters that are not zero."""
    return {name: 100 * (found.get(name, np.nan) / value - 1) for name, value in truth.items() if value}


def models(truth: Mapping[str, float]) -> tuple[Axis, symid.codegen.GeneratedModel]:
    """Axis with or without friction, and its model from the motor encoder."""
    if truth["Fsm"]:
        return direct(), symid.load_generated("direct_2m1s", ("q2",))
    axis = without_friction()
    return axis, symid.compiled(symid.derive(axis, ("q2",)))


def compared(log: symid.Log, truth: Mapping[str, float], *, held: bool = True) -> dict[str, dict[str, float]]:
    """Physical parameters by method 1, timing accounted for, and by oe."""
    axis, model = models(truth)
    late = {"Fm": -0.5 * log.sampling_period} if held else {}
    return {
        "wls": symid.identify(model, log, preparation=symid.Preparation(late=late)).physical_parameters,
        "oe": identify_output_error(axis, model, log, preparation=Preparation(held=held)).physical_parameters,
    }


def print_paper(quick: bool) -> None:
    """Part (a): errors at 250 Hz."""
    print("\n(a) paper's axis at 250 Hz, trapezoids: errors in % (Table 10: Ms 24, Fvs 93, Ks 92)")
    print(f"{'':44}" + "".join(f"{name:>9}" for name in PAPER))
    cases = [(SMOOTH, QUIET), (PAPER, QUIET), (SMOOTH, LOUD), (PAPER, LOUD)]
    for truth, noise in cases[:1] if quick else cases:
        logs = {"": disturbed(truth, noise, 0)}
        if not quick:
            logs[" in the record"] = recorded_with_noise(machine(truth, 250.0), noise, 0)
        for where, log in logs.items():
            for method, found in compared(log, truth).items():
                friction = "friction" if truth["Fsm"] else "no friction"
                label = f"{friction}, {noise[0]:g} N{where}, {1e9 * noise[1]:g} nm: {method}"
                row(label, errors(found, truth).values())


def recorded(run: Simulation, every: int, *, mean: bool) -> symid.Log:
    """Every n-th reading of a log, and the force there or its mean until the next."""
    n = run.forces.size // every
    forces = run.forces[: n * every].reshape(n, every)
    force = forces.mean(axis=1) if mean else forces[:, 0]
    signals = {"q2": run.log["q2"][: n * every : every], "Fm": force}
    return symid.Log.from_arrays(signals, sampling_period=every * run.log.sampling_period)


def print_fast_loop() -> None:
    """(a') A loop that is faster than the log."""
    print("\n(a') loop at 8 kHz that feeds back the encoder with 20 nm of noise: errors of oe in %")
    print(f"{'':44}" + "".join(f"{name:>9}" for name in PAPER) + f"{'force N':>9}{'q2 nm':>9}")
    axis = direct().with_signal("q2", noise=QUIET[1])
    controller = tuned_cascade(plant_of(axis, PAPER), "q2", bandwidth_hz=60.0)
    run = simulate(axis, PAPER, moves(8000.0), controller)
    chatter = float(np.std(np.diff(run.forces[:800]))) / np.sqrt(2)
    print(f"  force of the loop at rest: white part {chatter:.3g} N")
    model = symid.load_generated("direct_2m1s", ("q2",))
    for every in (2, 8, 32):
        for mean in (False, True):
            found = identify_output_error(
                direct(), model, recorded(run, every, mean=mean), preparation=Preparation(held=True)
            )
            how = "mean over the interval" if mean else "samples"
            values = [
                *errors(found.physical_parameters, PAPER).values(),
                found.noise["Fm"],
                1e9 * found.noise["q2"],
            ]
            row(f"log at {8000 / every:g} Hz, {how}, {found.status}", values)


def fits(
    truth: Mapping[str, float], noise: tuple[float, float], draws: int
) -> list[OutputErrorIdentification]:
    """Estimates from draws of the noise; after some of them the search begins where the first one ended."""
    axis, model = models(truth)
    clean, found = machine(truth, 250.0), []
    for seed in range(draws):
        log = noisy(clean, noise, seed)
        nominal = found[0].physical_parameters if seed >= UNKNOWN_START else None
        if nominal is None:
            found.append(identify_output_error(axis, model, log, preparation=Preparation(held=True)))
            continue
        fit = found[0].comparison.fit([log], [nominal])
        found.append(replace(found[0], logs=(log,), fit=fit))
    return found


def coverage(
    found: Sequence[OutputErrorIdentification], truth: Mapping[str, float], *, corrected: bool
) -> list[float]:
    """Percentage of 95 % intervals that hold the truth, by parameter."""
    names = [name for name, value in truth.items() if value]
    held = []
    for one in found:
        spread_ = dict(
            zip(
                one.physical_parameters,
                np.sqrt(np.diag(one.physical_covariance(corrected=corrected))),
                strict=True,
            )
        )
        held.append([abs(one.physical_parameters[n] - truth[n]) < 1.96 * spread_[n] for n in names])
    return [100 * float(x) for x in np.mean(held, axis=0)]


def print_spread(draws: int) -> None:
    """(b) Spread beside the bound."""
    print(
        f"\n(b) {draws} draws at 250 Hz beside the Cramer-Rao bound, without friction; the aim is 1.2 at most"
    )
    names = [name for name, value in SMOOTH.items() if value]
    print(f"{'':44}" + "".join(f"{name:>9}" for name in names))
    clean = machine(SMOOTH, 250.0)
    for noise in (QUIET, LOUD):
        found = fits(SMOOTH, noise, draws)
        deviations = np.array([list(errors(one.physical_parameters, SMOOTH).values()) for one in found])
        bound = list(cramer_rao(SMOOTH, clean["Fm"], noise, clean.sampling_period).values())
        label = f"{noise[0]:g} N, {1e9 * noise[1]:g} nm: "
        row(f"{label}bound %", bound, digits=4)
        row("  standard deviation %", deviations.std(axis=0, ddof=1), digits=4)
        row("  its ratio to the bound", deviations.std(axis=0, ddof=1) / bound)
        row(
            "  mean error / standard deviation of a mean",
            deviations.mean(axis=0) / deviations.std(axis=0) * len(found) ** 0.5,
        )
        for corrected in (False, True):
            kind = "corrected" if corrected else "classical"
            row(
                f"  coverage of 95 % intervals, {kind}, %",
                coverage(found, SMOOTH, corrected=corrected),
                digits=1,
            )


def print_smoother() -> None:
    """(c) What fades on smoother trapezoids."""
    print(
        "\n(c) standard deviation in % at 250 Hz, 1 N and 20 nm, against the jerk of the trapezoids (bound)"
    )
    names = [name for name, value in SMOOTH.items() if value]
    print(f"{'':44}" + "".join(f"{name:>9}" for name in names))
    for jerk in (2000.0, 1000.0, 500.0, 200.0, 100.0, 50.0, 20.0):
        log = machine(SMOOTH, 250.0, jerk)
        row(f"jerk {jerk:g} m/s^3", cramer_rao(SMOOTH, log["Fm"], QUIET, log.sampling_period).values())
    print(
        "  Above 100 %, a parameter cannot be told from zero: no estimator without bias does better on such a log."
    )


def print_starts() -> None:
    """(e) The rough start, rigid masses and friction, over rates and axes."""
    print("\n(e) from rough starts: parameters within 4 deviations or 2 % of the truth")
    good = total = 0
    for truth in (SMOOTH, PAPER):
        axis, model = models(truth)
        dynamics = forward_dynamics(axis)
        for rate in (200.0, 250.0, 400.0, 500.0, 1000.0):
            log = recorded_with_noise(machine(truth, rate), QUIET, 1)
            rough = rigid_start(model, dynamics, [log])
            known = (rough, with_heavy_bodies(dynamics, rough))
            starts = [start for values in known for start in spread(dynamics, values, rate)]
            fit = ErrorModel(model, dynamics, symid.Preparation(), "held").fit([log], starts)
            if fit is None:
                raise RuntimeError(f"no start at {rate:g} Hz")
            found = fit.search.parameters
            std = np.sqrt(np.diag(fit.linear.covariance))[: len(fit.search.seen)]
            apart = [
                abs(found[n] - truth[n]) < max(4 * s, 0.02 * abs(truth[n]))
                for n, s in zip(fit.search.seen, std, strict=True)
            ]
            good, total = good + all(apart), total + 1
            friction = "friction" if truth["Fsm"] else "no friction"
            row(
                f"{friction}, {rate:g} Hz: {'found' if all(apart) else 'MISSED'}",
                errors(found, truth).values(),
            )
    print(f"  {good} of {total}")


def main() -> None:
    quick = parser_of(__doc__, quick=False).parse_args().quick
    began = time.monotonic()
    print_paper(quick)
    if not quick:
        print_fast_loop()
    print_spread(8 if quick else DRAWS)
    if not quick:
        print_smoother()
    print_bench(quick)
    if not quick:
        print_starts()
    print(f"\n{time.monotonic() - began:.0f} s")


if __name__ == "__main__":
    main()
