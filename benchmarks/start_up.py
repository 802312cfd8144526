"""Time of `symid identify` of a short log as a process, of a plain script, and of the imports alone.

The log is that of an EMPS-like axis, 10 000 samples, as CSV. "script" reads it and does the same in straightforward
numpy, scipy and polars, with given cutoff and decimation. "imports" only imports numpy and polars, which symid uses to
read and compute. The runs alternate; processor times and wall-clock times are medians over the rounds.

Usage: python -m benchmarks.start_up [--rounds 7]
"""

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import polars as pl

from benchmarks.identify_speed import simulate_emps
from benchmarks.installed import as_installed
from benchmarks.options import parser_of

SAMPLES = 10_000
AIM = 0.5
SCRIPT = """
import sys
import polars as pl
from benchmarks.identify_speed import run_script
log = pl.read_csv(sys.argv[1])
print(run_script("emps", {name: log[name].to_numpy() for name in ("q", "F")}, {"cutoff": 2.25, "factor": 177}))
"""


def commands(log: Path) -> dict[str, list[str]]:
    python = sys.executable
    symid = "import sys; from symid.cli import main; main()"
    return {
        "symid identify": [python, "-c", symid, "identify", "emps", str(log)],
        "script": [python, "-c", SCRIPT, str(log)],
        "imports": [python, "-c", "import numpy, polars"],
    }


def costs(command: list[str], environment: dict[str, str]) -> tuple[float, float]:
    """Seconds by the clock and of the processor that a process takes."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, env=environment)
    clock, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    return clock, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    options = parser_of(__doc__, rounds=7).parse_args()
    with tempfile.TemporaryDirectory() as name:
        log = Path(name) / "log.csv"
        q, force = simulate_emps(SAMPLES, np.random.default_rng(0))
        pl.DataFrame({"t": np.arange(SAMPLES) / 1000.0, "q": q, "F": force}).write_csv(log)
        compared, environment = commands(log), as_installed(Path(name) / "compiled")
        for command in compared.values():
            costs(command, environment)
        rounds = [
            [costs(command, environment) for command in compared.values()] for _ in range(options.rounds)
        ]
    for run, (clock, processor) in zip(compared, np.median(rounds, axis=0), strict=True):
        verdict = (
            f" (aim {AIM:g} s: {'met' if processor <= AIM else 'MISSED'})" if run == "symid identify" else ""
        )
        print(f"{run:16}{processor:7.2f} s of the processor{verdict}, {clock:.2f} s by the clock")


if __name__ == "__main__":
    main()
