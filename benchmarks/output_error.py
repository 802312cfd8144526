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

from __future__ import annotations

import argparse
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, signal

import symid
from benchmarks.motor_bench import read
from symid.axis import Axis
from symid.output_error import OutputErrorIdentification, identify_output_error
from symid.output_error.error_model import ErrorModel
from symid.output_error.rough_starts import rigid_start, spread, with_heavy_bodies
from symid.simulation import (
    Cascade,
    Command,
    Simulation,
    Trajectory,
    forward_dynamics,
    plant_of,
    simulate,
    trapezoids,
    tuned_cascade,
)

FloatArray = NDArray[np.float64]

PAPER = {"Ms": 3899.0, "Fvs": 3949.17, "Ks": 1e9, "Mm": 362.58, "Fvm": 88.6, "Fsm": 146.0}
SMOOTH = PAPER | {"Fsm": 0.0}
QUIET, LOUD = (1.0, 20e-9), (5.0, 100e-9)
"""Noise of the logged force, N, and of the encoder, m: a drive's current loop and a linear scale; five times that."""
DRAWS, UNKNOWN_START = 200, 5


def direct() -> Axis:
    """The paper's axis, direct_2m1s."""
    return symid.load_axis("direct_2m1s")


def without_friction() -> Axis:
    """The paper's axis without Coulomb friction, as in the paper's own simulations."""
    axis = direct()
    return axis.without(*(e for e in axis.elements if isinstance(e, symid.CoulombFriction)))


def moves(rate: float, jerk: float = 2000.0) -> Trajectory:
    """Trapezoids there and back at three speeds."""
    return trapezoids(
        [0.3], [0.1, 0.25, 0.5], acceleration=10.0, jerk=jerk, dwell=0.2, sampling_period=1 / rate
    )


def machine(truth: Mapping[str, float], rate: float, jerk: float = 2000.0) -> symid.Log:
    """Trapezoids of the paper's axis under a cascade at a rate, without noise."""
    controller = tuned_cascade(plant_of(direct(), truth), "q2", bandwidth_hz=6.0)
    return simulate(direct(), truth, moves(rate, jerk), controller).log


@dataclass(frozen=True)
class Disturbed(Cascade):
    """A cascade whose force acts with a disturbance that the log does not hold."""

    disturbance: FloatArray = field(default_factory=lambda: np.zeros(1))

    def force(
        self, command: Command, measured: Mapping[str, float], state: FloatArray, period: float
    ) -> tuple[float, FloatArray]:
        """Force that acts until the next sample."""
        sent, state = super().force(command, measured, state, period)
        return sent + float(self.disturbance[command.index]), state


def disturbed(truth: Mapping[str, float], noise: tuple[float, float], seed: int) -> symid.Log:
    """A log at 250 Hz of a loop that feeds back encoder noise, its force differing from the sent one by white noise."""
    reference = moves(250.0)
    added = noise[0] * np.random.default_rng(seed).standard_normal(reference.n_samples)
    axis = direct().with_signal("q2", noise=noise[1])
    gains = tuned_cascade(plant_of(axis, truth), "q2", bandwidth_hz=6.0)
    controller = Disturbed(**vars(gains), disturbance=added)
    run = simulate(axis, truth, reference, controller, seed=seed)
    signals = {"q2": run.log["q2"], "Fm": run.forces - added}
    return symid.Log.from_arrays(signals, sampling_period=1 / 250.0)


def recorded_with_noise(log: symid.Log, noise: tuple[float, float], seed: int) -> symid.Log:
    """The log with white noise on the records of force and encoder: the axis does not feel it."""
    random = np.random.default_rng(seed)
    signals = {
        name: log[name] + std * random.standard_normal(log.n_samples)
        for name, std in zip(("Fm", "q2"), noise, strict=True)
    }
    return symid.Log.from_arrays(signals, sampling_period=log.sampling_period)


def noisy(log: symid.Log, noise: tuple[float, float], seed: int) -> symid.Log:
    """The log of the same force when white noise adds to it in the axis (without friction) and to the encoder."""
    random = np.random.default_rng(seed)
    impulse, _ = responses(SMOOTH, log.n_samples, log.sampling_period)
    moved = signal.lfilter(
        np.append(0.0, impulse[:-1]), 1.0, noise[0] * random.standard_normal(log.n_samples)
    )
    q2 = log["q2"] + moved + noise[1] * random.standard_normal(log.n_samples)
    return symid.Log.from_arrays({"q2": q2, "Fm": log["Fm"]}, sampling_period=log.sampling_period)


def errors(found: Mapping[str, float], truth: Mapping[str, float]) -> dict[str, float]:
    """Errors in percent of the truth, of the parameters that are not zero."""
    return {name: 100 * (found.get(name, np.nan) / value - 1) for name, value in truth.items() if value}


def row(label: str, values: Iterable[float], width: int = 9, digits: int = 2) -> None:
    """Print a label and numbers."""
    print(f"{label:44}" + "".join(f"{value:{width}.{digits}f}" for value in values), flush=True)


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
        "oe": identify_output_error(axis, model, log, held=held).physical_parameters,
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
            found = identify_output_error(direct(), model, recorded(run, every, mean=mean), held=True)
            how = "mean over the interval" if mean else "samples"
            values = [
                *errors(found.physical_parameters, PAPER).values(),
                found.noise["Fm"],
                1e9 * found.noise["q2"],
            ]
            row(f"log at {8000 / every:g} Hz, {how}, {found.status}", values)


def responses(p: Mapping[str, float], n: int, period: float) -> tuple[FloatArray, FloatArray]:
    """Position after a force held over one interval, and after each initial state, without Coulomb friction."""
    Ms, Fvs, Ks, Mm, Fvm = (p[name] for name in ("Ms", "Fvs", "Ks", "Mm", "Fvm"))
    generator = np.zeros((5, 5))  # q1, q2, their speeds, force: [3] and [4] of the paper
    generator[0, 2] = generator[1, 3] = 1.0
    generator[2] = [-Ks / Ms, 0.0, -Fvs / Ms, Fvm / Ms, -1 / Ms]
    generator[3] = [Ks / Ms, 0.0, Fvs / Ms, -Fvm * (1 / Ms + 1 / Mm), 1 / Ms + 1 / Mm]
    whole = linalg.expm(generator * period)
    impulse, free, state = np.zeros(n), np.zeros((n, 4)), np.eye(4)
    for k in range(n):
        free[k] = state[1]
        impulse[k] = state[1] @ whole[:4, 4]
        state = whole[:4, :4] @ state
    return impulse, free


def moments(
    p: Mapping[str, float], force: FloatArray, noise: FloatArray, period: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mean and covariance of the second differences of the readings, and the effect of the initial state on them.

    The logged force is held, and white noise adds to it. Differences hold the same information, as the rigid motion's
    first state is unknown; without them the covariance is that of a random walk, beyond the reach of 16 digits.
    """
    n, twice = force.size, np.array([1.0, -2.0, 1.0])
    impulse, free = responses(p, n, period)
    first = signal.lfilter(twice, 1.0, np.append(0.0, impulse[:-1]))
    covariance = np.outer(first, first)  # G G', G being lower triangular and Toeplitz
    for k in range(1, n):
        covariance[k, 1:] += covariance[k - 1, :-1]
    read = linalg.toeplitz(np.concatenate([[6.0, -4.0, 1.0], np.zeros(n - 5)]))
    mean = signal.lfilter(first, 1.0, force)
    return mean[2:], noise[0] ** 2 * covariance[2:, 2:] + noise[1] ** 2 * read, np.diff(free, 2, axis=0)


def cramer_rao(
    truth: Mapping[str, float], force: FloatArray, noise: tuple[float, float], period: float
) -> dict[str, float]:
    """Least standard deviations in percent; initial state and both noise levels are unknown too."""
    names = [name for name, value in truth.items() if value]
    levels = np.array(noise)
    _, S, free = moments(truth, force, levels, period)
    factor = linalg.cholesky(S, lower=True)
    slopes: list[FloatArray] = []
    spreads: list[FloatArray] = []
    for i in range(len(names) + 2):
        sides = []
        for step in (1e-4, -1e-4):
            moved, loud = dict(truth), levels.copy()
            if i < len(names):
                moved[names[i]] *= 1 + step
            else:
                loud[i - len(names)] *= 1 + step
            sides.append(moments(moved, force, loud, period))
        slopes.append(linalg.solve_triangular(factor, (sides[0][0] - sides[1][0]) / 2e-4, lower=True))
        change = linalg.solve_triangular(factor, (sides[0][1] - sides[1][1]) / 2e-4, lower=True)
        spreads.append(linalg.solve_triangular(factor, change.T, lower=True))
    white = linalg.solve_triangular(factor, free, lower=True)
    start = linalg.orth(white / np.maximum(np.linalg.norm(white, axis=0), 1e-9), rcond=1e-6)
    means = np.stack(slopes, axis=1)
    means -= start @ (start.T @ means)
    information = means.T @ means
    information += 0.5 * np.array([[np.sum(a * b) for b in spreads] for a in spreads])
    bound = np.sqrt(np.diag(np.linalg.inv(information)))
    return {name: 100 * float(std) for name, std in zip(names, bound, strict=False)}


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
            found.append(identify_output_error(axis, model, log, held=True))
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


def kept(log: symid.Log, every: int, *, mean: bool) -> symid.Log:
    """Every n-th sample; the current there, or its mean over the samples until the next one kept."""
    n = log.n_samples // every
    current = log["iq"][: n * every].reshape(n, every)
    signals = {name: log[name][: n * every : every] for name in ("qm", "ql")}
    signals["iq"] = current.mean(axis=1) if mean else current[:, 0]
    return symid.Log.from_arrays(signals, sampling_period=every * log.sampling_period)


def bench_frequencies(p: Mapping[str, float]) -> list[float]:
    """Antiresonance and resonance, Hz."""
    if not p or not all(p[name] > 0 for name in ("Jm", "Jl", "Kt")):
        return [np.nan, np.nan]
    anti, resonance = p["Kt"] / p["Jl"], p["Kt"] * (1 / p["Jl"] + 1 / p["Jm"])
    return [float(np.sqrt(w) / (2 * np.pi)) for w in (anti, resonance)]


def print_bench(quick: bool) -> None:
    """(d) The real bench, decimated."""
    print(
        "\n(d) real flexible motor bench, log A, every n-th sample kept (inertias in 1e-3 A s^2/rad, Kt in A/rad)"
    )
    print(f"{'':44}" + "".join(f"{name:>9}" for name in ("Jm", "Jl", "Kt", "antires", "res Hz")))
    log = read("A")
    for measured in (("qm",), ("qm", "ql")):
        axis, model = symid.load_axis("motor_bench"), symid.load_generated("motor_bench", measured)
        for every in (10,) if quick else (1, 2, 5, 10, 12, 14):
            for mean in (False,) if quick or every == 1 else (False, True):
                part = kept(log, every, mean=mean)
                late = {"iq": -0.5 * part.sampling_period} if mean else {}
                found = {
                    "wls": symid.identify(model, part, preparation=symid.Preparation(late=late)),
                    "oe": identify_output_error(axis, model, part, held=True if mean else None),
                }
                how = ", mean current" if mean else ""
                for method, one in found.items():
                    p = one.physical_parameters
                    values = [1e3 * p["Jm"], 1e3 * p["Jl"], p["Kt"]] if p else [np.nan] * 3
                    label = f"{'+'.join(measured)} n={every} {2500 / every:g} Hz{how}: {method} {one.status}"
                    row(label, [*values, *bench_frequencies(p)])


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
    """Run the benchmark and print its parts."""
    parser = argparse.ArgumentParser(description="Output error at low rates.")
    parser.add_argument(
        "--quick", action="store_true", help="the first row of (a), few draws, one row of (d)"
    )
    quick = parser.parse_args().quick
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
