"""Speed of `symid batch`: two cores relative to one, to a plain script, and to the filter passes alone.

Logs of an EMPS-like axis, 40 000 samples each, differ in their noise only. "one core" and "two cores" are
`identify_batch` with that number of processes, which are started before the time is taken; "unexamined" omits the
examination of timing and bias, as the script does. "script" reads each log and does the same in straightforward numpy
and scipy, with given instead of chosen cutoff and decimation, on one core. "passes" are reading and scipy's sosfiltfilt
only, as often as identification needs it. symid on one core runs in one process, script and passes in another.
"cluster" is a Dask LocalCluster of two workers, if Dask is installed. All runs alternate; ratios are medians over the
rounds. Runs on one core are compared by processor time, which other work on the machine changes little; two cores by
the clock.

Usage: python -m benchmarks.batch [--logs 1000] [--rounds 3]
"""

import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from threadpoolctl import threadpool_limits

import symid
from benchmarks.identify_speed import JOBS, simulate_emps
from benchmarks.options import parser_of

SAMPLES = 40_000
AIM_TWO_CORES, AIM_CLUSTER, AIM_SCRIPT, AIM_UNEXAMINED, AIM_PASSES = 1.9, 1.85, 2.0, 4.0, 2.0
WARM_UP = 4


def write_logs(folder: Path, logs: int, samples: int = SAMPLES) -> list[Path]:
    """Logs of one motion with different noise, as Parquet."""
    paths = []
    for seed in range(logs):
        q, force = simulate_emps(samples, np.random.default_rng(seed))
        path = folder / f"{seed:06d}.parquet"
        pl.DataFrame({"t": np.arange(samples) / 1000.0, "q": q, "F": force}).write_parquet(path)
        paths.append(path)
    return paths


def batch(
    paths: list[Path], jobs: int | None = None, scheduler: str | None = None, examine: bool = True
) -> None:
    settings = symid.BatchSettings(examine=examine)
    done = symid.identify_batch("emps", paths, jobs=jobs, scheduler=scheduler, settings=settings)
    assert done.statuses.get("ok", 0) >= 0.9 * len(paths), done.statuses


def plain(paths: list[Path], job: str, settings: dict[str, float | int]) -> list[dict[str, Any]]:
    """Read each log and do a job of `identify_speed` with it."""
    run = JOBS[job]
    frames = map(pl.read_parquet, paths)
    return [run("emps", {name: frame[name].to_numpy() for name in ("q", "F")}, settings) for frame in frames]


def processor_time(run: Callable[..., object], *arguments: object) -> float:
    """Processor time that this process takes for a run, s."""
    begin = time.process_time()
    run(*arguments)
    return time.process_time() - begin


def chosen(path: Path) -> dict[str, float | int]:
    """Cutoff and decimation that symid chooses for a log."""
    row = symid.identify_batch("emps", path, settings=symid.BatchSettings(examine=False)).rows[0]
    return {"cutoff": row["cutoff_hz"], "factor": row["decimation"]}


def cluster_of_two() -> Any:
    """A Dask cluster of two workers of one thread."""
    from distributed import LocalCluster

    return LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50)


def runs(stack: ExitStack, settings: dict[str, float | int]) -> dict[str, Callable[[list[Path]], float]]:
    own, other = (
        stack.enter_context(ProcessPoolExecutor(1, mp_context=get_context("spawn"))) for _ in range(2)
    )
    found: dict[str, Callable[[list[Path]], float]] = {
        "one core": lambda paths: own.submit(processor_time, batch, paths, 1).result(),
        "two cores": lambda paths: processor_time(batch, paths, 2),
        "unexamined, one core": lambda paths: own.submit(
            processor_time, batch, paths, 1, None, False
        ).result(),
        "script": lambda paths: other.submit(processor_time, plain, paths, "script", settings).result(),
        "passes": lambda paths: other.submit(
            processor_time, plain, paths, "passes, 1 thread", settings
        ).result(),
    }
    if find_spec("distributed"):
        cluster = stack.enter_context(cluster_of_two())
        found["cluster of two"] = lambda paths: processor_time(batch, paths, None, cluster.scheduler_address)
    return found


def measured(paths: list[Path], rounds: int) -> dict[str, np.ndarray]:
    """Seconds by the clock, and of its processor if it uses one core, of each run in each round."""
    seconds: dict[str, list[tuple[float, float]]] = {}
    with ExitStack() as stack:
        stack.enter_context(threadpool_limits(1))
        compared = runs(stack, chosen(paths[0]))
        for run in compared.values():
            run(paths[:WARM_UP])
        for _ in range(rounds):
            for name, run in compared.items():
                begin = time.perf_counter()
                processor = run(paths)
                seconds.setdefault(name, []).append((time.perf_counter() - begin, processor))
    return {name: np.array(values) for name, values in seconds.items()}


def main() -> None:
    options = parser_of(__doc__, logs=1000, rounds=3).parse_args()
    with tempfile.TemporaryDirectory() as name:
        paths = write_logs(Path(name), options.logs)
        seconds = measured(paths, options.rounds)
    print(f"{options.logs} logs of {SAMPLES} samples, median of {options.rounds} alternating rounds")
    for run, times in seconds.items():
        clock, processor = 1e3 * np.median(times, axis=0) / options.logs
        own = "" if run in ("two cores", "cluster of two") else f", processor {processor:6.1f} ms"
        print(f"  {run:22}{clock:9.1f} ms a log{SAMPLES / clock * 1e3:12.3g} samples/s{own}")
    for text, over, under, aim, more in (
        ("two cores are faster than one", "one core", "two cores", AIM_TWO_CORES, True),
        ("cluster of two is faster than one core", "one core", "cluster of two", AIM_CLUSTER, True),
        ("one core is faster than the script", "script", "one core", AIM_SCRIPT, True),
        ("unexamined is faster than the script", "script", "unexamined, one core", AIM_UNEXAMINED, True),
        ("one core takes longer than the passes", "one core", "passes", AIM_PASSES, False),
        ("unexamined takes longer than the passes", "unexamined, one core", "passes", AIM_PASSES, False),
    ):
        if over in seconds and under in seconds:
            ratio = float(np.median(seconds[over] / seconds[under], axis=0)[int("two" not in under)])
            met = ratio >= aim if more else ratio <= aim
            print(f"{text}: {ratio:.2f} times (aim {aim:g}: {'met' if met else 'MISSED'})")


if __name__ == "__main__":
    main()
