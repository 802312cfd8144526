"""How often do 95 % intervals hold the true parameters? Classical against corrected standard deviations.

One mass with viscous and Coulomb friction follows a smooth trajectory; force and encoder noise are added to
what a perfect machine would log. Two ways of filtering: "output raw" as several identification packages do
(position low-passed forward and backward, differentiated by central differences, force only decimated), and
"both sides" (the same low-pass and decimation over every column and the force).

Usage: python benchmarks/interval_coverage.py [--runs 200] [--seconds 10]
"""

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy import signal, stats

from symid.estimation.corrected_covariance import corrected_covariance
from symid.estimation.least_squares import estimate
from symid.estimation.triangular import triangular_factors

RATE = 1000.0
TRUE = np.array([95.0, 200.0, 20.0])  # M [kg], Fv [N s/m], Fc [N]
FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Case:
    """One setting of the table: noises [N], [m], cutoff [Hz], decimation, which sides are filtered."""

    force: float
    encoder: float
    cutoff: float
    decimation: int
    both_sides: bool


def trajectory(seconds: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Position, velocity, acceleration of a sum of three sines, stroke about 0.2 m."""
    t = np.arange(int(seconds * RATE)) / RATE
    parts = ((0.08, 0.37, 0.0), (0.03, 1.1, 1.0), (0.006, 2.9, 2.0))  # amplitude [m], frequency [Hz], phase
    phases = [2.0 * np.pi * f * t + phase for _, f, phase in parts]
    rates = [2.0 * np.pi * f for _, f, _ in parts]
    q = sum(a * np.sin(x) for (a, _, _), x in zip(parts, phases, strict=True))
    v = sum(a * w * np.cos(x) for (a, _, _), w, x in zip(parts, rates, phases, strict=True))
    acceleration = sum(-a * w * w * np.sin(x) for (a, _, _), w, x in zip(parts, rates, phases, strict=True))
    return np.asarray(q), np.asarray(v), np.asarray(acceleration)


def observation(q: FloatArray, force: FloatArray, case: Case) -> tuple[FloatArray, FloatArray]:
    """W of shape (1, n, 3) and y of shape (1, n) as a package would make them from a log."""
    sos = signal.butter(4, case.cutoff, fs=RATE, output="sos")
    low_pass: Callable[[FloatArray], FloatArray] = lambda x: signal.sosfiltfilt(sos, x)  # noqa: E731
    filtered = low_pass(q)
    velocity = np.gradient(filtered, 1.0 / RATE)
    columns = [np.gradient(velocity, 1.0 / RATE), velocity, np.sign(velocity)]
    if case.both_sides:
        # the other columns have been through the filter already, as the position that they come from
        columns[2], force = low_pass(np.sign(velocity)), low_pass(force)
    edge = int(2.0 * RATE / case.cutoff)
    kept = [column[edge:-edge] for column in (*columns, force)]
    if case.decimation > 1:
        kept = [signal.decimate(column, case.decimation) for column in kept]
    *W, y = kept
    return np.stack(W)[None].transpose(0, 2, 1), y[None]


def monte_carlo(case: Case, runs: int, seconds: float, rng: np.random.Generator) -> dict[str, FloatArray]:
    """Estimates, classical and corrected standard deviations, half-widths of 95 %, of all runs."""
    q, v, acceleration = trajectory(seconds)
    force = np.stack([acceleration, v, np.sign(v)], axis=1) @ TRUE
    record: dict[str, list[FloatArray]] = {
        "X": [],
        "classical": [],
        "corrected": [],
        "half": [],
        "lag1": [],
        "persists": [],
    }
    for _ in range(runs):
        W, y = observation(
            q + case.encoder * rng.standard_normal(len(q)),
            force + case.force * rng.standard_normal(len(q)),
            case,
        )
        fit = estimate(triangular_factors(W, y))
        corrected = corrected_covariance(W, y, fit)
        rho = y[0] - W[0] @ fit.parameters
        record["X"].append(fit.parameters)
        record["classical"].append(fit.standard_deviations)
        record["corrected"].append(corrected.standard_deviations)
        t = stats.t.ppf(0.975, corrected.degrees_of_freedom)
        record["half"].append(t * corrected.standard_deviations)
        record["persists"].append(np.array(corrected.status == "correlation_persists", dtype=np.float64))
        record["lag1"].append(np.array(rho[1:] @ rho[:-1] / (rho @ rho)))
    return {name: np.array(values) for name, values in record.items()}


def cases() -> Iterator[Case]:
    """All settings of the table."""
    settings = ((20.0, 1), (20.0, 10), (60.0, 1), (60.0, 10), (10.0, 20))
    for both, (force, encoder), (cutoff, decimation) in product(
        (False, True), ((5.0, 0.0), (1.0, 5e-6)), settings
    ):
        yield Case(force, encoder, cutoff, decimation, both)


def coverage(X: FloatArray, half: FloatArray) -> FloatArray:
    """Share of runs [%] in which each true parameter lies within X +- half."""
    return 100.0 * np.mean(np.abs(X - TRUE) <= half, axis=0)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--seconds", type=float, default=10.0)
    options = parser.parse_args()
    print("coverage of nominal 95 % intervals (M, Fv, Fc) in %; ratio of claimed to true deviation of M")
    print(
        "'about mean': the same intervals around the mean of all estimates, that is, with the bias taken out"
    )
    print(
        "'persists': share of runs whose residual's correlation did not die out (status correlation_persists)"
    )
    print(
        f"{'noise':15}{'cutoff/dec':>11} {'filtered':11}{'lag 1':>6}{'bias/std (M,Fv,Fc)':>20}"
        f"{'classical':>15}"
        f"{'corrected':>15}{'about mean':>15}{'ratio class.':>13}{'ratio corr.':>12}{'persists':>9}"
    )
    for case in cases():
        r = monte_carlo(case, options.runs, options.seconds, np.random.default_rng(20261121))
        X, true_std = r["X"], r["X"].std(axis=0, ddof=1)
        triples = [
            " ".join(f"{value:4.0f}" for value in values)
            for values in (
                coverage(X, 1.96 * r["classical"]),
                coverage(X, r["half"]),
                coverage(X - X.mean(axis=0) + TRUE, r["half"]),
            )
        ]
        bias = " ".join(f"{value:5.1f}" for value in (X.mean(axis=0) - TRUE) / true_std)
        ratios = [np.median(r[name][:, 0]) / true_std[0] for name in ("classical", "corrected")]
        print(
            f"{case.force:g} N, {case.encoder * 1e6:g} um".ljust(15)
            + f"{case.cutoff:g}/{case.decimation}".rjust(11)
            + f" {'both sides' if case.both_sides else 'output raw':11}{r['lag1'].mean():6.2f}{bias:>20}"
            + "".join(f"{triple:>15}" for triple in triples)
            + f"{ratios[0]:13.2f}{ratios[1]:12.2f}{100.0 * r['persists'].mean():8.0f}%"
        )


if __name__ == "__main__":
    main()
