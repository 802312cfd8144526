"""Total error of the setting that `tune_total` chooses from a log, beside the best fixed setting chosen with hindsight.

A cell is an axis with a set of sensors, a level of noise and a sampling rate. One noisy log of the cell is all that
the tuning sees, with nominal values that are 15 % off: noise and parameters are estimated from it. The setting is
then judged on other draws of the noise, with the true parameters, by the root mean square over draws and parameters
of the relative errors (beyond 100 % they count as 100 %; parameters that every setting loses do not count). So are
all settings of a fine grid, of which the best is the hindsight; the automatic choice of `symid identify`; and a
constant 50 Hz, as other tools have.

The axis runs along trapezoids under a cascade of 30 Hz, of which the tuning knows nothing, and whose force is held
between its samples; the noise is that of the record, the controller does not feel it.

Usage: python -m benchmarks.tuning_grid [--quick]
"""

from __future__ import annotations

import argparse
import time
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from symid import Axis, Log, Preparation, load_axis, load_generated
from symid.identification.settings import completed
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade
from symid.tuning import TotalErrors, identified_and_tuned, with_noise

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
SEEDS = 8
FIXED_HZ = 50.0
ALLOWED = 1.10
OFF = 0.15


@dataclass(frozen=True)
class Cell:
    """What a log is recorded from."""

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
    """Total errors in percent, and the settings."""

    cell: Cell
    tuned: float
    best: float
    default: float
    fixed: float
    tuned_setting: Preparation
    best_setting: Preparation
    lost: tuple[str, ...]
    seconds: float

    @property
    def ratio(self) -> float:
        """Error of the tuned setting over that of the best one."""
        return self.tuned / self.best


def clean_log(axis: Axis, rate: float, signals: tuple[str, ...]) -> Log:
    """Noise-free log along trapezoids."""
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
    begin = time.perf_counter()
    noisy = with_noise(clean, noise, seed=1000)
    tuned = identified_and_tuned(axis, model, noisy, nominal=nominal_of(cell), preparation=base)
    seconds = time.perf_counter() - begin
    judge = TotalErrors(model, (clean,), noise, VALUES[cell.axis], SEEDS)
    settings = list(_grid(cell, base))
    errors = {setting_key(s): judge.rms(s) for s in settings}
    default = completed(base, judge.noisy[0], model)
    default = replace(base, cutoff_hz=default.cutoff_hz, decimation=default.decimation)
    kept = np.min(list(errors.values()), axis=0) < 0.8
    totals = {key: float(np.sqrt(np.mean(rms[kept] ** 2))) for key, rms in errors.items()}
    best = min(settings, key=lambda s: totals[setting_key(s)])

    def total(setting: Preparation) -> float:
        return 100.0 * float(np.sqrt(np.mean(judge.rms(setting)[kept] ** 2)))

    return Outcome(
        cell=cell,
        tuned=total(tuned.preparation),
        best=100.0 * totals[setting_key(best)],
        default=total(default),
        fixed=total(replace(base, cutoff_hz=FIXED_HZ)),
        tuned_setting=tuned.preparation,
        best_setting=best,
        lost=tuple(name for name, is_kept in zip(judge.names, kept, strict=True) if not is_kept),
        seconds=seconds,
    )


def nominal_of(cell: Cell) -> dict[str, float]:
    """What the user believes of the axis: each parameter 15 % off, up or down."""
    random = np.random.default_rng(zlib.crc32(str(cell).encode()))
    return {name: value * (1.0 + random.choice([-OFF, OFF])) for name, value in VALUES[cell.axis].items()}


def setting_key(setting: Preparation) -> tuple[float | None, int | None]:
    """What differs between settings."""
    return setting.cutoff_hz, setting.decimation


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
    """Row of the table for one cell."""
    tuned, best = outcome.tuned_setting, outcome.best_setting
    return (
        f"{outcome.cell}{tuned.cutoff_hz:7.1f} /{tuned.decimation:3}{best.cutoff_hz:8.1f} /{best.decimation:3}"
        f"{outcome.tuned:9.3g}{outcome.best:9.3g}{outcome.ratio:7.2f}{outcome.default:9.3g}{outcome.fixed:9.3g}"
        f"{outcome.seconds:6.1f}  {','.join(outcome.lost)}"
    )


def main(arguments: list[str] | None = None) -> None:
    """Print the grid and the share of the cells within 10 % of the best."""
    parser = argparse.ArgumentParser(description="Tuned settings against the best ones.")
    parser.add_argument("--quick", action="store_true", help="one cell for each set of sensors")
    chosen = cells(parser.parse_args(arguments).quick)
    print(
        "cutoff [Hz] / decimation; total errors in %\n"
        + " " * 46
        + "tuned        best    tuned     best  ratio  default    50 Hz     s  lost"
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


if __name__ == "__main__":
    main()
