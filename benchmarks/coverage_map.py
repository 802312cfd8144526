"""Coverage of 95 % intervals, and whether a result reports the bias that reduces it.

For each row an axis is simulated once; noise is then drawn and identified many times. The rows differ in sensors,
method, sampling rate, cutoff (chosen from the log, or given), decimation, filtering of the force, and noise of force
and encoder (white, or the steps of an encoder). For minimal and physical parameters together the map prints the lowest
and highest coverage of the intervals, classical and corrected (Student's t with the degrees of freedom of the result),
the true bias in standard deviations, the share of draws whose result reports a dominating bias, and the rate of false
alarms of timing. A parameter counts as biased if the mean of all draws is off by more than a tenth of the standard
deviation beyond its own uncertainty (3 standard errors). Parameters that are both minimal and physical count once.

Then the force of the same logs is shifted by one sample: it prints how often this is detected, the error of the
estimated shift, and the coverage before and after the proposed remedy. Finally, least squares and instrumental
variables are compared on a flexible axis with noisy encoders.

Usage: python -m benchmarks.coverage_map [--runs 200] [--quick]
OPENBLAS_NUM_THREADS=1 halves the time, since the matrices are too small for threads.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats

import symid
from benchmarks.coverage_cases import (
    ENGINE_RATE,
    VALUES,
    Case,
    FloatArray,
    cases,
    controller_of,
    names_of,
    noisy_log,
    preparation_of,
    timing_cases,
    true_values,
)
from benchmarks.options import parser_of
from symid.codegen import GeneratedModel
from symid.identification import Identification
from symid.instrumental import identify_by_instruments
from symid.simulation import ClosedLoop


@dataclass(frozen=True, eq=False)
class Draw:
    """Result of one identification for all parameters, minimal and then physical."""

    values: FloatArray
    classical: FloatArray
    deviations: FloatArray
    degrees_of_freedom: float
    bias_dominates: FloatArray
    timing_samples: float
    timing_suggested: float
    timing_seen: bool
    status: str


def wls(model: GeneratedModel, log: symid.Log, preparation: symid.Preparation, axis: str) -> Identification:
    return symid.identify(model, log, preparation=preparation, nominal=VALUES[axis])


def iv(model: GeneratedModel, log: symid.Log, preparation: symid.Preparation, axis: str) -> Identification:
    """Instrumental variables, under the controller with which the log was made."""
    loop = ClosedLoop(symid.load_axis(axis), controller=controller_of(axis))
    return identify_by_instruments(model, log, loop, preparation=preparation, nominal=VALUES[axis])


METHODS: Mapping[str, Callable[[GeneratedModel, symid.Log, symid.Preparation, str], Identification]] = {
    "wls": wls,
    "iv": iv,
}


def identified(case: Case, log: symid.Log, preparation: symid.Preparation) -> Draw:
    model = symid.load_generated(case.axis, case.measured)
    found = METHODS[case.method](model, log, preparation, case.axis)
    return draw_of(found)


def draw_of(found: Identification) -> Draw:
    """Values, deviations and statements of a result, about the minimal and then the physical parameters.

    The simulated axis is the model, so that its deviations need not cover lacking effects.
    """
    found = replace(found, discrepancies=())
    physical, bias = found.physical[0], found.bias
    deviations = physical.propagated_deviations(found.covariance)
    dominated = np.zeros(found.fit.solution.size + physical.parameters.size)
    if bias is not None:
        shares = (
            bias.dominates(found.standard_deviations),
            bias.mapped(physical.sensitivity).dominates(deviations),
        )
        dominated[list(shares[0])] = 1.0
        dominated[[found.fit.solution.size + i for i in shares[1]]] = 1.0
    timing = found.timing
    return Draw(
        np.concatenate([found.fit.parameters, physical.parameters]),
        np.concatenate([found.fit.standard_deviations, physical.propagated_deviations(found.fit.covariance)]),
        np.concatenate([found.standard_deviations, deviations]),
        found.correlated.degrees_of_freedom,
        dominated,
        timing.samples if timing is not None else math.nan,
        timing.suggested if timing is not None else math.nan,
        timing is not None and timing.is_significant,
        found.status,
    )


@dataclass(frozen=True, eq=False)
class Row:
    """Statistics of all draws of a case, for each parameter."""

    case: Case
    names: tuple[str, ...]
    classical: FloatArray
    corrected: FloatArray
    bias: FloatArray
    stated: FloatArray
    false_alarms: float
    draws: int

    @property
    def is_biased(self) -> NDArray[np.bool_]:
        """Whether the bias exceeds a tenth of the deviation by more than the uncertainty of its estimate."""
        return np.abs(self.bias) > 0.1 + 3 / math.sqrt(self.draws)


def measured_row(case: Case, runs: int) -> Row:
    random, truth = np.random.default_rng(20261121), true_values(case)
    once = np.unique(truth, return_index=True)[1]
    draws = [identified(case, noisy_log(case, random), preparation_of(case)) for _ in range(runs)]
    errors = np.array([draw.values for draw in draws]) - truth
    return Row(
        case,
        names=tuple(names_of(case)[i] for i in once),
        classical=coverage(errors, np.array([1.96 * draw.classical for draw in draws]))[once],
        corrected=coverage(errors, half_widths(draws))[once],
        bias=(errors.mean(axis=0) / errors.std(axis=0, ddof=1))[once],
        stated=np.mean([draw.bias_dominates for draw in draws], axis=0)[once],
        false_alarms=float(np.mean([draw.timing_seen for draw in draws])),
        draws=runs,
    )


def half_widths(draws: list[Draw]) -> FloatArray:
    """Of the corrected 95 % intervals."""
    return np.array([stats.t.ppf(0.975, draw.degrees_of_freedom) * draw.deviations for draw in draws])


def coverage(errors: FloatArray, half: FloatArray) -> FloatArray:
    """Share of draws whose interval holds the true value, for each parameter."""
    return np.asarray(np.mean(np.abs(errors) <= half, axis=0))


def span(values: FloatArray) -> str:
    """Lowest and highest, in percent."""
    return f"{100 * values.min():4.0f}-{100 * values.max():.0f}"


def print_map(measured: Iterable[Row]) -> None:
    """Print the rows as they come, and what they come to."""
    rows = []
    print(f"{'case':62}{'classical':>10}{'corrected':>10}{'largest bias':>13}{'stated':>9}{'timing':>8}")
    for row in measured:
        rows.append(row)
        worst = row.bias[np.argmax(np.abs(row.bias))]
        print(
            f"{row.case!s:62}{span(row.classical):>10}{span(row.corrected):>10}{worst:12.2f}s{span(row.stated):>9}"
            f"{100 * row.false_alarms:7.1f}%",
            flush=True,
        )
    biased = np.concatenate([row.is_biased for row in rows])
    stated = np.concatenate([row.stated for row in rows]) > 0.5
    covered = np.concatenate([row.corrected for row in rows])
    print("\nparameters of all rows          record says that bias dominates   says nothing")
    for name, chosen in (("biased by more than a tenth", biased), ("not so", ~biased)):
        print(f"{name:32}{np.count_nonzero(chosen & stated):31d}{np.count_nonzero(chosen & ~stated):15d}")
    quiet = covered[~stated]
    inside = np.count_nonzero((quiet >= 0.93) & (quiet <= 0.97))
    draws = rows[0].draws
    low, high = (bound / draws for bound in stats.binom.interval(0.99, draws, 0.95))
    expected = np.count_nonzero((quiet >= low) & (quiet <= high))
    print(
        f"where it says nothing, corrected intervals cover {span(quiet)} %, median {100 * np.median(quiet):.1f} %; "
        f"{inside} of {quiet.size} lie in 93 to 97 %, {expected} where 99 of 100 exact intervals would "
        f"({100 * low:.1f} to {100 * high:.1f} %); the others, and all that are biased:"
    )
    for row in rows:
        for i, name in enumerate(row.names):
            off = row.is_biased[i] or not low <= row.corrected[i] <= high
            if off and row.stated[i] <= 0.5:
                print(
                    f"    {row.case}: {name} covered {100 * row.corrected[i]:.0f} %, bias {row.bias[i]:.2f}"
                )
    alarms = np.array([row.false_alarms for row in rows])
    print(f"a wrong timing was seen in {100 * alarms.mean():.2f} % of the logs, none of which has one")


def timing_row(case: Case, runs: int) -> tuple[float, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Share of logs whose status names the timing, its errors in samples, and coverage of all parameters as recorded,
    after the remedy, and of the same logs never moved."""
    found: dict[str, list[Draw]] = {"as recorded": [], "remedied": [], "never moved": []}
    random = np.random.default_rng(20261121)
    force = symid.load_axis(case.axis).drive.signal
    for _ in range(runs):
        state = random.bit_generator.state
        log, given = noisy_log(case, random), preparation_of(case)
        random.bit_generator.state = state
        draw = identified(case, log, given)
        late = given.late.get(force, 0.0) + draw.timing_suggested
        found["as recorded"].append(draw)
        found["remedied"].append(identified(case, log, replace(given, late={force: late})))
        found["never moved"].append(identified(case, noisy_log(replace(case, moved=0), random), given))
    truth = true_values(case)
    shares = [
        coverage(np.array([draw.values for draw in draws]) - truth, half_widths(draws))
        for draws in found.values()
    ]
    first = found["as recorded"]
    seen = float(np.mean([draw.timing_seen and draw.status != "ok" for draw in first]))
    return seen, np.array([draw.timing_samples - case.moved for draw in first]), *shares


def print_timing(quick: bool, runs: int) -> None:
    print(
        f"\n{'force moved by a sample':62}{'status':>8}{'rms, max':>14}{'coverage':>11}{'remedied':>10}{'unmoved':>9}"
    )
    for case in timing_cases(quick):
        seen, errors, before, after, unmoved = timing_row(case, runs)
        sizes = f"{np.sqrt(np.mean(errors**2)):.3f}, {np.abs(errors).max():.3f}"
        print(
            f"{f'{case}, {case.moved:+d}':62}{100 * seen:7.0f}%{sizes:>14}{span(before):>11}{span(after):>10}"
            f"{span(unmoved):>9}",
            flush=True,
        )


def print_methods(runs: int) -> None:
    """Print what noisy encoders do to least squares and to instrumental variables on a flexible axis."""
    noise = (("Fm", 2.0), ("qm", 1.2e-4), ("ql", 1.2e-4))
    case = Case("ballscrew_2m1s", ("qm", "ql"), "wls", ENGINE_RATE, 60.0, None, noise)
    print(f"\nbias in standard deviations and coverage in %: {case}")
    for method in METHODS:
        row = measured_row(replace(case, method=method), runs)
        cells = sorted(zip(row.names, row.bias, row.corrected, strict=True))
        print(f"{method:8}" + "  ".join(f"{n} {b:6.2f} {100 * c:3.0f}" for n, b, c in cells), flush=True)


def main() -> None:
    options = parser_of(__doc__, runs=200, quick=False).parse_args()
    print(f"nominal 95 % intervals, {options.runs} draws a row; coverage in %, bias in standard deviations\n")
    print_map(measured_row(case, options.runs) for case in cases(options.quick))
    print_timing(options.quick, options.runs // 2)
    if not options.quick:
        print_methods(options.runs // 2)


if __name__ == "__main__":
    main()
