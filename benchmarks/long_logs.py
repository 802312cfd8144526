"""Cost and peak memory of `identify` against the length of a log that is read from a Parquet or CSV file in blocks.

Logs of an EMPS-like axis (see identify_speed.py) are written block by block to a temporary folder, so that none is in
memory as a whole. Every log is identified in a separate process, in blocks and, up to `--whole` samples, in memory as
well; the two must agree. Printed are wall time, samples per second, the process' peak memory beyond what an imported
symid takes, and the slope of log(seconds) over log(samples): 1 is linear.

Usage: python -m benchmarks.long_logs [--smallest 1e5] [--largest 1e7] [--whole 1e7] [--kind parquet] [--folder FOLDER]
"""

import json
import subprocess
import sys
import tempfile
import time
from argparse import SUPPRESS
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

import symid
from benchmarks.identify_speed import RATE, FloatArray, simulate_emps
from benchmarks.options import parser_of
from symid.data import MEMORY
from symid.identification import open_axis_log

PART = 1_000_000
"""Samples that are simulated at a time; its sines have whole periods, so that they continue."""
AGREEMENT = 1e-9


def lengths(smallest: float, largest: float) -> list[int]:
    """Powers of ten from the smallest to the largest."""
    return [10**k for k in range(round(np.log10(smallest)), round(np.log10(largest)) + 1)]


def part(first: int, samples: int) -> dict[str, FloatArray]:
    """Samples from `first` on; all sines have whole periods in a part, noise differs from part to part."""
    q, force = simulate_emps(samples, np.random.default_rng(first))
    return {"t": (first + np.arange(samples)) / RATE, "q": q, "F": force}


def write(file: Path, samples: int) -> None:
    frames = [(first, min(PART, samples - first)) for first in range(0, samples, PART)]
    if file.suffix == ".csv":
        with file.open("wb") as out:
            for i, span in enumerate(frames):
                pl.DataFrame(part(*span)).write_csv(out, include_header=i == 0)
        return
    schema = {name: pl.Float64() for name in ("t", "q", "F")}
    lazy = [pl.defer(lambda s=span: pl.DataFrame(part(*s)), schema=schema) for span in frames]
    pl.concat(lazy).sink_parquet(file, engine="streaming")


def peak_memory() -> float:
    """Largest memory of this process so far, MB; getrusage would count its parent's before the program began."""
    status = Path("/proc/self/status").read_text()
    return float(status.split("VmHWM:")[1].split()[0]) / 1024


def identified(file: str, blocks: bool) -> dict[str, Any]:
    """Identify a log in this process: seconds, peak memory in MB beyond what symid takes, parameters and deviations."""
    axis, model = symid.load_axis("emps"), symid.load_generated("emps")
    before = peak_memory()
    begin = time.perf_counter()
    log = open_axis_log(axis, file, memory=1 if blocks else 10**15)
    found = symid.identify(model, log)
    return {
        "seconds": time.perf_counter() - begin,
        "peak": peak_memory() - before,
        "status": found.status,
        "parameters": found.fit.parameters.tolist(),
        "deviations": found.standard_deviations.tolist(),
    }


def in_own_process(file: Path, blocks: bool) -> dict[str, Any]:
    """Result of `identified` in a separate process."""
    command = [sys.executable, "-m", "benchmarks.long_logs", "--identify", str(file)]
    command += ["--blocks"] if blocks else []
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return dict(json.loads(done.stdout))


def difference(one: dict[str, Any], other: dict[str, Any]) -> float:
    """Largest relative difference of parameters and deviations."""
    pairs = ((one[key], other[key]) for key in ("parameters", "deviations"))
    return max(float(np.max(np.abs(np.array(a) / np.array(b) - 1.0))) for a, b in pairs)


def slope(samples: list[int], seconds: list[float]) -> float:
    """Exponent of the power law through the points."""
    return float(np.polyfit(np.log(samples), np.log(seconds), 1)[0])


def main() -> None:
    parser = parser_of(__doc__, smallest=1e5, largest=1e7, whole=1e7)
    parser.add_argument("--kind", choices=["parquet", "csv"], default="parquet")
    parser.add_argument("--folder", help="where logs are written [a temporary folder]")
    parser.add_argument("--identify", help=SUPPRESS)
    parser.add_argument("--blocks", action="store_true", help=SUPPRESS)
    given = parser.parse_args()
    if given.identify:
        print(json.dumps(identified(given.identify, given.blocks)))
        return
    print(
        f"{'samples':>12} {'file MB':>8} {'s':>8} {'samples/s':>11} {'peak MB':>8} | {'whole s':>8} {'peak MB':>8} off"
    )
    sizes, seconds = lengths(given.smallest, given.largest), []
    for samples in sizes:
        with tempfile.TemporaryDirectory(dir=given.folder) as folder:
            file = Path(folder) / f"log.{given.kind}"
            write(file, samples)
            found = in_own_process(file, blocks=True)
            seconds.append(found["seconds"])
            line = (
                f"{samples:12d} {file.stat().st_size / 1e6:8.0f} {found['seconds']:8.2f} "
                f"{samples / found['seconds']:11.3g} {found['peak']:8.0f} | "
            )
            if samples <= given.whole:
                whole = in_own_process(file, blocks=False)
                off = difference(found, whole)
                line += f"{whole['seconds']:8.2f} {whole['peak']:8.0f} {off:.1e}"
                line += "" if off < AGREEMENT else " TOO MUCH"
            print(line, flush=True)
    if len(sizes) > 1:
        print(f"slope of log(s) over log(samples): {slope(sizes, seconds):.2f}, by steps:", end=" ")
        print(", ".join(f"{np.log10(b / a):.2f}" for a, b in pairwise(seconds)))
    print(f"a log is read in blocks by itself if it would take more than {MEMORY / 1e9:g} GB (--memory)")


if __name__ == "__main__":
    main()
