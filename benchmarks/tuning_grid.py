"""Total error of the setting that `tune_total` chooses from a log, and of the best fixed setting in hindsight.

A cell is an axis with a set of sensors, a level of noise and a sampling rate. One noisy log of the cell is all that
the tuning sees, with nominal values that are 15 % off: noise and parameters are estimated from it. A setting has the
total error that `TotalErrors` gives with the true parameters: the root mean square over draws of noise and parameters
of the relative errors (beyond 100 % they count as 100 %; parameters that every setting loses do not count). So have
all settings of a fine grid, of which the best is the hindsight; the automatic choice of `symid identify`; and a
constant 50 Hz, as other tools have.

The best of a hundred settings on a few draws is partly luck: it is chosen on some draws, and all settings are then
judged on others, which neither the choice nor the tuning has seen. Beside it stands the ratio to the least of all on
the eight draws of the first choice.

The axis runs along trapezoids under a cascade of 30 Hz, of which the tuning knows nothing, and whose force is held
between its samples; the noise is that of the record, the controller does not feel it.

Usage: python -m benchmarks.tuning_grid [--quick]
"""

import time
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.options import parser_of
from symid import Axis, Log, Preparation, load_axis, load_generated
from symid.arrays import FloatArray
from symid.identification import identify_by_least_squares
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade
from symid.tuning import identified_and_tuned
from symid.tuning.total_errors import TotalErrors, with_noise

VALUES = {
    "rigid_1m": {"M": 100.0, "Fv": 80.0, "Fs": 40.0},
    "direct_2m1s": {"Ms": 1700.0, "Fvs": 24000.0, "Ks": 1.3e8, "Mm": 460.0, "Fvm": 104.0, "Fsm": 98.0},
    "ballscrew_2m1s": {
        "Mm": 80.0, "Fvm": 120.0, "Fsm": 50.0, "Kt": 6e6, "Ft": 700.0, "Ml": 200.0, "Fvl": 150.0,
    },
}  # fmt: skip
SENSORS = (
    ("rigid_1m", ("q",)),
    ("direct_2m1s", ("q2",)),
    ("ballscrew_2m1s", ("qm",)),
    ("ballscrew_2m1s", ("qm", "ql")),
)
NOISES = ((1e-8, 0.5), (1e-7, 2.0), (1e-6, 10.0))
"""Standard deviations of positions (m) and of the force (N)."""
RATES = (1000.0, 4000.0)
CONTROLLER_HZ = 4000.0
CUTOFFS = tuple(float(f) for f in np.geomspace(6.0, 400.0, 36))
LOG_SEED = 1000
CHOICE, FINAL, JUDGE = (8, 5000), (32, 6000), (64, 9000)
"""Draws and the seed of the first: for the first choice of the best, for the last one, and to judge.

A root mean square of one decisive parameter over n draws is itself off by 71 % / sqrt(n): 25 % with 8, 9 % with 64.
"""
FINALISTS = 12
FIXED_HZ = 50.0
HOPELESS = 0.8
"""A parameter whose error exceeds this with every setting does not count."""
ALLOWED = 1.10
OFF = 0.15


@dataclass(frozen=True)
class Cell:
    """Axis, sensors, noise and rate of a log."""

    axis: str
    measured: tuple[str, ...]
    position_noise: float
    force_noise: float
    rate: float

    def __str__(self) -> str:
        noise = f"{self.position_noise:7.0e} m{self.force_noise:5g} N"
        return f"{self.axis:15}{','.join(self.measured):7}{noise}{self.rate:6g} Hz"


@dataclass(frozen=True)
class Outcome:
    """Total errors in percent on the draws that judge, that of the choice beside it, and the settings."""

    cell: Cell
    tuned: float
    best: float
    default: float
    fixed: float
    ratio_of_choice: float
    tuned_setting: Preparation
    best_setting: Preparation
    lost: tuple[str, ...]
    seconds: float

    @property
    def ratio(self) -> float:
        """Error of the tuned setting over that of the best one."""
        return self.tuned / self.best


def clean_log(axis: Axis, rate: float, signals: tuple[str, ...]) -> Log:
    values = VALUES[axis.name]
    reference = trapezoids(
        [0.1], [0.1, 0.25, 0.5], acceleration=5.0, jerk=500.0, dwell=0.05, sampling_period=1 / CONTROLLER_HZ
    )
    cascade = tuned_cascade(plant_of(axis, values), signals[0], 30.0)
    return simulate(axis, values, reference, cascade, frequency_hz=rate).log


def evaluated(cell: Cell) -> Outcome:
    """Tune from one noisy log and judge on others."""
    axis, model = load_axis(cell.axis), load_generated(cell.axis, cell.measured)
    clean = clean_log(axis, cell.rate, cell.measured)
    noise = dict.fromkeys(cell.measured, cell.position_noise) | {axis.drive.signal: cell.force_noise}
    base = Preparation(late={axis.drive.signal: -0.5 / CONTROLLER_HZ})
    begin = time.process_time()
    noisy = with_noise(clean, noise, seed=LOG_SEED)
    tuned = identified_and_tuned(axis, model, noisy, nominal=nominal_of(cell), preparation=base).preparation
    seconds = time.process_time() - begin
    choice, final, judge = (
        TotalErrors(model, (clean,), noise, VALUES[cell.axis], *draws) for draws in (CHOICE, FINAL, JUDGE)
    )
    settings = list(_grid(cell, base))
    errors = [choice.rms(setting) for setting in settings]
    kept = np.min(errors, axis=0) < HOPELESS
    totals = [_total(rms, kept) for rms in errors]
    best = min(
        (settings[i] for i in np.argsort(totals)[:FINALISTS]), key=lambda s: _total(final.rms(s), kept)
    )
    chosen = identify_by_least_squares(model, noisy, preparation=base).observations[0].preparation
    default = replace(base, cutoff_hz=chosen.cutoff_hz, decimation=chosen.decimation)
    fixed = replace(base, cutoff_hz=FIXED_HZ)
    judged = [_total(judge.rms(setting), kept) for setting in (tuned, best, default, fixed)]
    return Outcome(
        cell,
        *judged,
        ratio_of_choice=_total(choice.rms(tuned), kept) / min(totals),
        tuned_setting=tuned,
        best_setting=best,
        lost=tuple(name for name, is_kept in zip(judge.names, kept, strict=True) if not is_kept),
        seconds=seconds,
    )


def _total(rms: FloatArray, kept: FloatArray) -> float:
    """Root mean square over the parameters that are not lost, percent."""
    return 100.0 * float(np.sqrt(np.mean(rms[kept] ** 2)))


def nominal_of(cell: Cell) -> dict[str, float]:
    """Nominal values of the user: each parameter 15 % too high or too low."""
    random = np.random.default_rng(zlib.crc32(str(cell).encode()))
    return {name: value * (1.0 + random.choice([-OFF, OFF])) for name, value in VALUES[cell.axis].items()}


def _grid(cell: Cell, base: Preparation) -> Iterator[Preparation]:
    for cutoff in CUTOFFS:
        if cutoff < 0.45 * cell.rate:
            usual = max(1, int(0.4 * cell.rate / cutoff))
            for decimation in sorted({1, usual, 2 * usual}):
                yield replace(base, cutoff_hz=cutoff, decimation=decimation)


def cells(quick: bool) -> list[Cell]:
    """All cells, or one for each set of sensors."""
    whole = [Cell(*s, *noise, rate) for s in SENSORS for noise in NOISES for rate in RATES]
    return whole[2 :: len(NOISES) * len(RATES)] if quick else whole


def line(outcome: Outcome) -> str:
    tuned, best = outcome.tuned_setting, outcome.best_setting
    return (
        f"{outcome.cell}{tuned.cutoff_hz:7.1f} /{tuned.decimation:3}{best.cutoff_hz:8.1f} /{best.decimation:3}"
        f"{outcome.tuned:9.3g}{outcome.best:9.3g}{outcome.ratio:7.2f}{outcome.ratio_of_choice:8.2f}{outcome.default:9.3g}{outcome.fixed:9.3g}"
        f"{outcome.seconds:6.1f}  {','.join(outcome.lost)}"
    )


def main(arguments: list[str] | None = None) -> None:
    given = parser_of(__doc__, first=0, cells=24, quick=False).parse_args(arguments)
    chosen = cells(given.quick)[given.first :][: given.cells]
    print(
        "cutoff [Hz] / decimation; total errors in %\n"
        + " " * 46
        + "tuned        best    tuned     best  ratio (choice) default    50 Hz     s  lost"
    )
    outcomes = []
    for cell in chosen:
        outcomes.append(evaluated(cell))
        print(line(outcomes[-1]), flush=True)
    for name in ("tuned", "default", "fixed"):
        ratios = np.array([getattr(o, name) / o.best for o in outcomes])
        share = 100 * np.mean(ratios <= ALLOWED)
        spread = f"median {np.median(ratios):.2f}, worst {ratios.max():.2f}"
        print(f"{name:8} within 10 % of the best in {share:.0f} % of {len(ratios)} cells, {spread}")
    of_choice = np.array([o.ratio_of_choice for o in outcomes])
    print(f"tuned on the draws that chose the best: {100 * np.mean(of_choice <= ALLOWED):.0f} %")


if __name__ == "__main__":
    main()
