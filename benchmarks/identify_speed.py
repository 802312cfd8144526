"""The whole `identify` of a long log in memory against the filter passes that it needs, and against a plain script.

Logs of an EMPS-like axis and of direct_2m1s measured at the motor are simulated. "passes" are scipy's sosfiltfilt
alone, on as many threads as symid uses and on one: the low-pass of each signal and of each friction column, and, if
there is decimation, the decimation filter of each column of W (constants aside) and of y. "script" does the same job
in straightforward numpy and scipy. "unexamined" is identify without its examination of timing and bias.
Every run has a separate process, whose peak memory is counted beyond the log itself; the runs alternate. Ratios are
of processor time, which other work on the machine changes little.

Usage: python -m benchmarks.identify_speed [--samples 10000000] [--rounds 3]
"""

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import signal

import symid
from benchmarks.options import parser_of

RATE = 1000.0
AXES = {"emps": ("q", "F"), "direct_2m1s": ("q2", "Fm")}
SHORT = 100_000
AIM = 2.0
FloatArray = NDArray[np.float64]
generated = cache(symid.load_generated)


def simulate_emps(samples: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Position and force of a rigid axis with friction that follows three sines."""
    t = np.arange(samples) / RATE
    q, v, a = np.zeros((3, samples))
    for amplitude, frequency in ((0.1, 0.41), (0.02, 1.3), (2e-4, 11.0)):  # m, Hz
        w = 2.0 * np.pi * frequency
        q += amplitude * np.sin(w * t)
        v += amplitude * w * np.cos(w * t)
        a -= amplitude * w**2 * np.sin(w * t)
    force = 95.0 * a + 203.0 * v + 20.0 * np.sign(v) - 3.0 + 2.0 * rng.standard_normal(samples)
    return q + 1e-7 * rng.standard_normal(samples), force


def simulate_direct(samples: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Position and force of a motor on a flexible structure, driven by noise between 1 and 60 Hz."""
    frequency = np.fft.rfftfreq(samples, 1.0 / RATE)
    inside = (frequency > 1.0) & (frequency < 60.0)
    s = 2j * np.pi * frequency[inside]
    structure, damping, stiffness, motor, viscous = 3000.0, 2e4, 4e7, 100.0, 500.0
    above = structure * s**2 + damping * s + stiffness
    moving = (structure + motor) * s**2 + damping * s + stiffness
    compliance = moving / (motor * s**2 * above + viscous * s * moving)
    spectrum = np.zeros(frequency.size, dtype=complex)
    spectrum[inside] = np.exp(2j * np.pi * rng.random(s.size)) * samples / np.sqrt(s.size)
    force = 50.0 * np.fft.irfft(spectrum, samples)
    spectrum[inside] *= compliance
    q = 50.0 * np.fft.irfft(spectrum, samples)
    return q + 1e-8 * rng.standard_normal(samples), force + 0.2 * rng.standard_normal(samples)


def low_pass(cutoff: float) -> FloatArray:
    return np.asarray(signal.butter(4, cutoff, fs=RATE, output="sos"))


def decimator(factor: int) -> FloatArray:
    return np.asarray(signal.cheby1(8, 0.05, 0.8 / factor, output="sos"))


def run_identify(axis: str, log: symid.Log, settings: dict[str, Any], examine: bool = True) -> dict[str, Any]:
    """Identify, all settings but the decimation chosen from the log."""
    model, preparation = generated(axis), symid.Preparation(decimation=settings["decimation"])
    found = symid.identify(model, log, preparation=preparation, examine=examine)
    chosen = found.observations[0].preparation
    return {
        "cutoff": chosen.cutoff_hz,
        "factor": chosen.decimation,
        "parameters": found.fit.parameters.tolist(),
    }


def run_passes(axis: str, log: symid.Log, settings: dict[str, Any], threads: int) -> dict[str, Any]:
    model, factor = generated(axis), settings["factor"]
    signals = [log[name] for name in AXES[axis]]
    smooth = low_pass(settings["cutoff"])
    inputs = [(smooth, x) for x in (*signals, *([signals[0]] * len(model.law_columns)))]
    if factor > 1:
        columns = len(model.minimal_units) - (1 if axis == "emps" else 0) + 1
        thin = decimator(factor)
        inputs += [(thin, signals[i % 2]) for i in range(columns)]

    def run(job: tuple[FloatArray, FloatArray]) -> None:
        signal.sosfiltfilt(*job)[::factor]

    # without a pool: memory that a thread frees goes back to the system, which costs half as much again
    if threads == 1:
        for job in inputs:
            run(job)
        return {}
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(run, inputs))
    return {}


def run_script(axis: str, log: symid.Log, settings: dict[str, Any]) -> dict[str, Any]:
    """Do the same job in straightforward numpy and scipy."""
    sos, factor = low_pass(settings["cutoff"]), settings["factor"]
    q, F = (signal.sosfiltfilt(sos, log[name]) for name in AXES[axis])
    v = np.gradient(q, 1.0 / RATE)
    a = np.gradient(v, 1.0 / RATE)
    friction = signal.sosfiltfilt(sos, np.sign(v))
    if axis == "emps":
        W = np.column_stack([a, v, friction, np.ones_like(v)])
    else:
        jerk = np.gradient(a, 1.0 / RATE)
        dF = np.gradient(F, 1.0 / RATE)
        ddF, snap = np.gradient(dF, 1.0 / RATE), np.gradient(jerk, 1.0 / RATE)
        W = np.column_stack([-ddF, -dF, v, friction, a, jerk, snap])
    edge = int(3.0 * RATE / settings["cutoff"])
    W, y = W[edge:-edge], F[edge:-edge]
    if factor > 1:
        thin = decimator(factor)
        W = np.column_stack([signal.sosfiltfilt(thin, column)[::factor] for column in W.T])
        y = signal.sosfiltfilt(thin, y)[::factor]
    X = np.linalg.lstsq(W, y)[0]
    rho = y - W @ X
    covariance = rho @ rho / (len(y) - len(X)) * np.linalg.inv(W.T @ W)
    return {"parameters": X.tolist(), "deviations": np.sqrt(np.diag(covariance)).tolist()}


THREADS = min(4, os.cpu_count() or 1)
JOBS: dict[str, Callable[[str, symid.Log, dict[str, Any]], dict[str, Any]]] = {
    "identify": run_identify,
    "unexamined": lambda axis, log, settings: run_identify(axis, log, settings, examine=False),
    "passes": lambda axis, log, settings: run_passes(axis, log, settings, THREADS),
    "passes, 1 thread": lambda axis, log, settings: run_passes(axis, log, settings, 1),
    "script": run_script,
}


def peak_mb() -> float:
    """Peak memory of this process so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000.0


def child(job: str, axis: str, folder: Path, settings: dict[str, Any]) -> None:
    """Run one job once, after a short run that loads what it needs, and print its costs."""
    signals = dict(zip(AXES[axis], (np.load(folder / f"{axis}_{i}.npy") for i in range(2)), strict=True))
    log = symid.Log("simulated", 0.0, 1.0 / RATE, signals)
    JOBS[job](axis, log.window(0, min(SHORT, log.n_samples)), settings)
    before = peak_mb()
    start, begin = time.perf_counter(), time.process_time()
    result = JOBS[job](axis, log, settings)
    costs = {"seconds": time.perf_counter() - start, "processor": time.process_time() - begin}
    print(json.dumps({**costs, "peak_mb": peak_mb() - before, **result}))


def run(job: str, axis: str, folder: Path, settings: dict[str, Any]) -> dict[str, Any]:
    """Costs and results of one job in a separate process."""
    result: dict[str, Any] = json.loads(in_own_process("--child", job, axis, folder, json.dumps(settings)))
    return result


def in_own_process(*arguments: object) -> bytes:
    """What this benchmark prints as a separate process: children inherit peaks of memory."""
    command = [sys.executable, "-m", "benchmarks.identify_speed", *map(str, arguments)]
    return subprocess.run(command, check=True, capture_output=True).stdout


def compare(axis: str, folder: Path, decimation: int | None, rounds: int) -> None:
    settings: dict[str, Any] = {"decimation": decimation, "cutoff": 30.0, "factor": decimation or 10}
    runs: dict[str, list[dict[str, Any]]] = {job: [] for job in JOBS}
    for i in range(rounds):
        for job in JOBS:
            if i == 0 or job in ("identify", "unexamined", "passes"):
                runs[job].append(run(job, axis, folder, settings))
            if job == "identify":
                settings |= {key: runs[job][0][key] for key in ("cutoff", "factor")}
    ours = np.array([r["processor"] for r in runs["identify"]])
    print(f"\n{axis}: cutoff {settings['cutoff']:g} Hz, one row for every {settings['factor']} samples")
    for job, results in runs.items():
        times = np.array([r["processor"] for r in results])
        clock = float(np.median([r["seconds"] for r in results]))
        ratio = float(np.median(ours[: len(times)] / times))
        verdict = ("  met" if ratio <= AIM else "  MISSED") if job.startswith("passes") else ""
        memory = float(np.median([r["peak_mb"] for r in results]))
        note = "" if job == "identify" else f"   identify takes {ratio:5.2f} times as long{verdict}"
        print(
            f"  {job:18}{clock:8.3f} s, processor{np.median(times):8.3f} s{memory:8.0f} MB{note}", flush=True
        )
    plain, deviation = (np.array(runs["script"][0][key]) for key in ("parameters", "deviations"))
    sure = deviation < 0.02 * np.abs(plain)
    apart = np.max(np.abs(np.array(runs["identify"][0]["parameters"]) / plain - 1.0)[sure])
    print(
        f"  the {np.count_nonzero(sure)} parameters sure to 2 % differ from the script's by {100 * apart:.2g} %"
    )


def simulate(axis: str, folder: Path, samples: int) -> None:
    """Write the signals of a log into a folder."""
    simulator = {"emps": simulate_emps, "direct_2m1s": simulate_direct}[axis]
    for i, values in enumerate(simulator(samples, np.random.default_rng(20261121))):
        np.save(folder / f"{axis}_{i}.npy", values)


def main() -> None:
    if sys.argv[1:2] == ["--simulate"]:
        simulate(sys.argv[2], Path(sys.argv[3]), int(sys.argv[4]))
        return
    if sys.argv[1:2] == ["--child"]:
        job, axis, folder, settings = sys.argv[2:]
        child(job, axis, Path(folder), json.loads(settings))
        return
    options = parser_of(__doc__, samples=10_000_000, rounds=3).parse_args()
    print(
        f"{options.samples} samples, {THREADS} threads, median of {options.rounds} alternating rounds "
        "(1 thread, script: one)"
    )
    print(
        f"memory beyond the log of {2 * 8e-6 * options.samples:.0f} MB; aim: within {AIM:g} times the passes"
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for axis in AXES:
            in_own_process("--simulate", axis, folder, options.samples)
            for decimation in (None, 1):
                compare(axis, folder, decimation, options.rounds)


if __name__ == "__main__":
    main()
