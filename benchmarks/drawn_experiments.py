"""Proposed experiments, performed by a simulator that shares no code with symid, on machines with drawn effects.

Each case of `benchmarks.blind` with one effect is diagnosed; where the true effect is one of the two causes that
remain, the proposed motion is performed on the true machine with fresh noise each time, after a move to its beginning
that is not recorded. Both causes are fitted to the readings, and the one with the smaller error is chosen. Printed are
the stated probability, how often the right cause was chosen, and the limits that the machine exceeded: travel, speed,
acceleration and force of the log, by more than 2 %.

Usage: python -m benchmarks.drawn_experiments [--cases N] [--seed N] [--runs N]
"""

import json
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from scipy.interpolate import CubicSpline

from benchmarks.options import parser_of
from symid import Log, load_axis
from symid.diagnosis import Experiment, diagnose
from symid.diagnosis.experiment.design import limits_seen, next_experiment_of, rivals_of
from symid.diagnosis.prediction.record import record_of
from symid.simulation import Trajectory

from .blind import draw, engine, gap, laws, plan
from .next_experiment import chosen

APPROACH = 1.5
"""Duration of the move to the beginning, s."""
MARGIN = 0.02


@dataclass(frozen=True)
class Outcome:
    """A case: how surely its experiment was said to decide, how often it did, and what went beyond the limits."""

    label: dict[str, Any]
    planned: Experiment
    right: int
    runs: int
    exceeded: str

    @property
    def is_performed(self) -> bool:
        """Whether the true effect is among the causes and a motion was proposed."""
        return self.runs > 0


def outcomes(cases: int, seed: int, runs: int) -> Iterator[Outcome]:
    with tempfile.TemporaryDirectory() as folder:
        for one in plan.plans(cases, seed, plan.Wish(group="single")):
            label = plan.draw_case(one, Path(folder))
            yield outcome(label, Path(folder) / one.name, runs)


def outcome(label: dict[str, Any], folder: Path, runs: int) -> Outcome:
    """Diagnosis of a case, its next experiment, and that performed."""
    axis = load_axis(label["axis"])
    first, second = (log_of(folder / f"{name}.parquet") for name in draw.SECONDS)
    nominal = json.loads((folder / "nominal.json").read_text())
    found = diagnose(axis, first, validation=second, nominal=nominal)
    planned, pair = next_experiment_of(found), rivals_of(found)
    truth = (label["effects"][0]["effect"], label["effects"][0]["at"])
    if pair is None or planned.trajectory is None or truth not in planned.causes:
        return Outcome(label, planned, 0, 0, "")
    cause, record = planned.causes.index(truth), pair.record
    right, exceeded = 0, ""
    setting, effects = machine_of(label, planned.trajectory)
    run = draw.simulate(setting, effects, "experiment", disturbed=True)
    begin = round(APPROACH * gap.RATE)
    for k in range(runs):
        noisy = draw.measured(replace(setting, seed=setting.seed + 1 + k), run.readings, "experiment")
        signals = {record.forces[0] if name == "F" else name: x[begin:] for name, x in noisy.items()}
        log = Log.from_arrays(signals, sampling_period=1 / gap.RATE, source="experiment")
        performed = record_of(record.dynamics, log, record.motion_hz, record.late, record.holds)
        right += chosen(pair, performed, cause) == cause
    (signal,) = draw.driven(setting)
    motion, force = run.readings[signal][begin:], run.readings["F"][begin:]
    limits, most = limits_seen(record), float(np.abs(record.log[record.forces[0]]).max())
    speed = np.gradient(motion) * gap.RATE
    within = {
        "travel": (np.ptp(motion), limits.travel[1] - limits.travel[0]),
        "speed": (np.abs(speed).max(), limits.speed),
        "acceleration": (np.quantile(np.abs(np.gradient(speed) * gap.RATE), 0.995), limits.acceleration),
        "force": (np.abs(force).max(), most),
    }
    exceeded = ", ".join(
        f"{what} {value / limit:.2f}"
        for what, (value, limit) in within.items()
        if value > (1 + MARGIN) * limit
    )
    return Outcome(label, planned, right, runs, exceeded)


def log_of(file: Path) -> Log:
    columns = pl.read_parquet(file)
    signals = {name: columns[name].to_numpy() for name in columns.columns if name != "t"}
    return Log.from_arrays(signals, sampling_period=1 / gap.RATE, source=file.stem)


def machine_of(label: dict[str, Any], path: Trajectory) -> tuple[draw.Setting, tuple[laws.Effect, ...]]:
    """The machine of a case with a further motion, and its effects."""
    setting = draw.draw_setting(
        label["axis"], tuple(label["sensors"]), np.random.default_rng(tuple(label["seed"]))
    )
    any_size = np.random.default_rng(0)
    effects = tuple(
        replace(laws.draw(e["effect"], e["at"], any_size), numbers=e["numbers"]) for e in label["effects"]
    )
    t = np.arange(0.0, path.time[-1], 1 / engine.CONTROL_HZ)
    spline = CubicSpline(path.time, path.position)
    share = np.linspace(0.0, 1.0, round(APPROACH * engine.CONTROL_HZ), endpoint=False)
    smooth = path.position[0] * share**3 * (10 - 15 * share + 6 * share**2)  # from rest to rest
    position = np.concatenate([smooth, spline(t)])
    position = position[: position.size // engine.LOG_TICKS * engine.LOG_TICKS]
    velocity = np.gradient(position) * engine.CONTROL_HZ
    motions = {**setting.motions, "experiment": np.stack([position, velocity, 0 * position])}
    return replace(setting, motions=motions), effects


def line(found: Outcome) -> str:
    effects = " + ".join(f"{e['effect']} at {e['at']}" for e in found.label["effects"])
    head = f"{found.label['axis']:15} {effects:45}"
    if not found.is_performed:
        causes = " or ".join(" at ".join(cause) for cause in found.planned.causes) or "no doubt"
        return f"{head} not performed: {causes}"
    rival = next(" at ".join(c) for c in found.planned.causes if c[0] not in effects or c[1] not in effects)
    said = f"{found.planned.probability:6.1%} {found.right:3}/{found.runs}"
    return f"{head} {said}  against {rival}  {found.exceeded and 'EXCEEDS ' + found.exceeded}".rstrip()


def main() -> None:
    given = parser_of(__doc__, cases=12, seed=1, runs=10).parse_args()
    print(f"{'axis':15} {'effect':45} stated  right")
    performed = []
    for found in outcomes(given.cases, given.seed, given.runs):
        print(line(found), flush=True)
        performed += [found] if found.is_performed else []
    known = [found for found in performed if np.isfinite(found.planned.probability)]
    stated, right = (
        np.mean([found.planned.probability for found in known]),
        np.mean([found.right / found.runs for found in known]),
    )
    print(f"{len(known)} experiments: stated {stated:.1%}, right {right:.1%}")


if __name__ == "__main__":
    main()
