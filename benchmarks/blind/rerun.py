"""Axes that a diagnosis wrote, simulated beside the true simulator's own re-run with other noise.

For each case whose answer is right: `symid diagnose --write-axis` writes the explained axis, symid simulates it along
the reference of the validation log under the case's controller, and the position that it reads is held against the
measured one. What the engine reads in a second run of the same machine, with other noise, is the least that can be
asked for. A simulated reading has noise only where the case's controller takes it; the second run's has the same, so
that with a quiet controller the second run moves as the first one did and is off by the noise of one reading. Beside
that stands the second run as a log has it, off by the noise of two readings, and for rigid axes how far off the values
of the plain axis leave it at least, if they are estimated from the force of the log with its noise.

Usage: python -m benchmarks.blind rerun FOLDER
"""

import json
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from symid import Axis, load_axis
from symid.errors import SymidError
from symid.simulation import Trajectory, simulate
from symid.simulation.controllers.controller import Command, Controller, LinearLaw

from . import answers, draw, engine, gap, laws, score, seal

AIM = 1.2
"""Times the error of the second run."""


@dataclass(frozen=True)
class CaseController(Controller):
    """The controller of `engine.loop`: position loop, PI velocity loop, low-pass on the velocity."""

    signal: str  # position that is controlled
    # Kpp, Kpv, Kiv: gains of the position loop, the velocity loop and its integral
    Kpp: float
    Kpv: float
    Kiv: float
    newest: float  # weight of the newest difference in the velocity

    @property
    def signals(self) -> tuple[str, ...]:
        """The controlled position."""
        return (self.signal,)

    @property
    def start(self) -> np.ndarray:
        """Integral of the velocity error, last reading, velocity: at rest at zero."""
        return np.zeros(3)

    def linear(self, period: float) -> LinearLaw:
        """The law as matrices; inputs: reference, its velocity and acceleration, reading."""
        slope = self.newest / period
        velocity, read = np.array([0.0, -slope, 1 - self.newest]), np.array([0.0, 0.0, 0.0, slope])
        error, seen = -velocity, np.array([self.Kpp, 1.0, 0.0, -self.Kpp]) - read
        integral = np.array([1.0, 0.0, 0.0])
        return LinearLaw(
            A=np.array([integral + period * error, np.zeros(3), velocity]),
            B=np.array([period * seen, [0.0, 0.0, 0.0, 1.0], read]),
            C=self.Kpv * error + self.Kiv * (integral + period * error),
            D=(self.Kpv + self.Kiv * period) * seen,
        )

    def force(
        self, command: Command, measured: Mapping[str, float], state: np.ndarray, period: float
    ) -> tuple[float, np.ndarray]:
        """Force until the next sample, as `engine._command` has it."""
        integral, last, speed = state.tolist()
        reading = measured[self.signal]
        difference = (reading - last) / period if command.index else 0.0
        speed += self.newest * (difference - speed)
        error = command.velocity + self.Kpp * (command.position - reading) - speed
        integral += error * period
        return self.Kpv * error + self.Kiv * integral, np.array([integral, reading, speed])


@dataclass(frozen=True)
class Rerun:
    """One case, errors as rms of position against the measured one, in m."""

    name: str
    label: dict[str, Any]
    again: float  # the engine's second run
    logged: float  # the same as it is recorded, with the noise of its own reading
    explained: float
    message: str
    seconds: float  # of simulation for each second of motion
    least: float = np.nan  # by values that are estimated at best from the force of a rigid axis

    @property
    def effects(self) -> str:
        return " + ".join(f"{e['effect']} at {e['at']}" for e in self.label["effects"])

    @property
    def ratio(self) -> float:
        """Error of the explained axis over that of the second run."""
        return self.explained / self.again

    @property
    def logged_ratio(self) -> float:
        """The same over that of the second run's log."""
        return self.explained / self.logged


def rerun_set(folder: Path, jobs: int, timeout: float) -> Iterator[Rerun]:
    """All cases of a folder with effects found right, in order; axes are written once, to `axes/` of the folder."""
    labels = seal.open_labels(folder) if (folder / "answers").exists() else seal.read(folder)
    with_effect = {name: label for name, label in labels.items() if label["effects"]}
    (folder / "axes").mkdir(exist_ok=True)
    with ThreadPoolExecutor(jobs) as pool:
        records = pool.map(lambda name: _written(folder, name, timeout), with_effect)
        for (name, label), record in zip(with_effect.items(), records, strict=True):
            verdict = score.verdict(label, record)
            # those have no element to be written
            if verdict.right and verdict.found and label["group"] != "foreign":
                yield _rerun(folder, name, label)


def _written(folder: Path, name: str, timeout: float) -> dict[str, Any]:
    """The answer for a case, and its axis beside it."""
    target = (folder / "axes" / name).resolve()
    kept = target.with_suffix(".answer")
    if not kept.exists():
        command = (*answers.COMMAND, "--write-axis", f"{target}.py")
        kept.write_text(json.dumps(answers.diagnose(folder / name, timeout, command), indent=1))
    record: dict[str, Any] = json.loads(kept.read_text())
    return record


def _rerun(folder: Path, name: str, label: dict[str, Any]) -> Rerun:
    """Both motions of a case beside the measured one."""
    any_size = np.random.default_rng(0)
    effects = tuple(
        replace(laws.draw(e["effect"], e["at"], any_size), numbers=e["numbers"]) for e in label["effects"]
    )
    setting = draw.draw_setting(
        label["axis"], tuple(label["sensors"]), np.random.default_rng(tuple(label["seed"]))
    )
    (signal,) = draw.driven(setting)
    measured = pl.read_parquet(folder / name / "validation.parquet")[signal].to_numpy()
    other = replace(setting, seed=setting.seed + 1)
    run = draw.simulate(other, effects, "validation", disturbed=True)
    recorded = draw.measured(other, run.readings, "validation")[signal]
    logged = _rms(recorded - measured)
    again = logged if setting.noisy_controller else _rms(run.readings[signal] - measured)
    file = folder / "axes" / f"{name}.py"
    begun = time.process_time()
    try:
        found = simulated(load_axis(str(file)), json.loads(file.with_suffix(".json").read_text()), setting)
    except (SymidError, ArithmeticError) as error:
        return Rerun(name, label, again, logged, np.inf, str(error), np.nan)
    seconds = (time.process_time() - begun) / draw.SECONDS["validation"]
    off = _rms(found - measured)
    recorded_as = replace(setting, noise=label["noise"])  # a worldly record wanders
    return Rerun(name, label, again, logged, off, "", seconds, least_of_values(recorded_as))


def least_of_values(setting: draw.Setting) -> float:
    """Expected rms error of the simulated position by values estimated from the log for identification; rigid axes.

    The covariance is the least of any estimate from the exact motion and the noise N of the force, (W' N^-1 W)^-1; it
    passes through the derivatives S of the simulated position by the values: the mean square is tr(S cov S')/n.
    """
    if setting.axis != "rigid_1m":
        return np.nan
    quiet, axis = replace(setting, noisy_controller=False), load_axis("rigid_1m")
    v = draw.simulate(quiet, (), "identification", disturbed=False).velocity
    columns = {"M": np.gradient(v) * gap.RATE, "Fv": v, "Fs": np.sign(v)}
    spectra, true = np.fft.fft(np.stack(list(columns.values()))), setting.true
    density = draw.force_density(setting, np.fft.fftfreq(v.size))
    covariance = np.linalg.inv((spectra / density @ spectra.conj().T).real / v.size)
    exact = simulated(axis, true, quiet)
    moved = (
        (simulated(axis, {**true, name: 1.01 * true[name]}, quiet) - exact) / (0.01 * true[name])
        for name in columns
    )
    S = np.stack(list(moved), axis=1)
    return float(np.sqrt(np.einsum("ij,jk,ik->", S, covariance, S) / len(S)))


def simulated(axis: Axis, values: dict[str, float], setting: draw.Setting) -> np.ndarray:
    """Reading of the position sensor of a written axis in the validation log of a case."""
    (signal,) = draw.driven(setting)
    for sensor in axis.sensors:
        axis = axis.with_signal(sensor.signal, noise=0.0, delay=sensor.delay)
    if setting.noisy_controller:
        delay = axis.measured((signal,))[0].delay
        axis = axis.with_signal(signal, setting.noise["position"], setting.noise["step"], delay)
    position, velocity, _ = setting.motions["validation"]
    path = Trajectory(
        position, velocity, np.zeros_like(velocity), 1 / engine.CONTROL_HZ, "reference of the case"
    )
    gains = (setting.controller[name] for name in ("Kpp", "Kpv", "Kiv"))
    run = simulate(axis, values, path, CaseController(signal, *gains, setting.lowpass))
    return np.asarray(run.log[signal][:: engine.LOG_TICKS])


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


HEAD = (
    f"{'case':8} {'axis':15} {'ratio':>6}  {'off [um]':>9}  {'again [um]':>10}  {'least [um]':>10}  {'speed':>6}"
    "  effects"
)


def line(case: Rerun) -> str:
    """One case in a line; speed in multiples of real time."""
    off, again, speed = 1e6 * case.explained, 1e6 * case.again, 1 / case.seconds
    told = f"{case.ratio:6.2f}  {off:9.4f}  {again:10.4f}  {1e6 * case.least:10.4f}  {speed:6.1f}"
    return f"{case.name:8} {case.label['axis']:15} {told}  {case.effects}  {case.message}".rstrip()


def table(cases: list[Rerun]) -> str:
    """Cases within the aim by kind and in all, and how fast the written axes are simulated."""
    kinds = defaultdict(list)
    for case in cases:
        for effect in {e["effect"] for e in case.label["effects"]}:
            kinds[effect].append(case)
    lines = [f"{'kind':30}  {f'within {AIM:g}':>10}  {'of a log':>8}  median   worst"]
    for kind, some in [*sorted(kinds.items()), ("all", cases)]:
        ratios, n = [case.ratio for case in some], len(some)
        within = f"{sum(ratio <= AIM for ratio in ratios)}/{n}"
        of_log = f"{sum(case.logged_ratio <= AIM for case in some)}/{n}"
        lines.append(f"{kind:30}  {within:>10}  {of_log:>8}  {np.median(ratios):6.2f}  {max(ratios):6.2f}")
    speeds = [1 / case.seconds for case in cases]
    lines.append(
        f"times real time, processor, controller of {engine.CONTROL_HZ / 1000:g} kHz: "
        f"median {np.nanmedian(speeds):.1f}, least {np.nanmin(speeds):.1f}"
    )
    return "\n".join(lines)
