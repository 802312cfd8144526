"""A batch whose workers or whose command are killed: does the result contain every log once, as without the kills?

Logs of an EMPS-like axis, 40 000 samples each, differ in their noise only. The first batch is undisturbed. In the
second, on a Dask LocalCluster of two workers, one worker is killed by its process id after a third of the rows. In the
third, `symid batch` on all cores is killed with its process group when a third of its rows are in the journal, and the
same command is run again. It prints lost logs, duplicated logs, rows that differ from the undisturbed ones, and rows
that the second command reused. The exit code is 1 if a log is lost, duplicated or different.

Usage: python -m benchmarks.batch_kills [--logs 1000]
"""

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import polars as pl
from distributed import LocalCluster

import symid
from benchmarks.batch import write_logs
from benchmarks.options import parser_of
from symid.fleet.journal import read_journal

VOLATILE = ("seconds", "finished", "log")
JOURNAL = "results.parquet.journal"


def undisturbed(paths: Sequence[Path], output: Path) -> pl.DataFrame:
    """Table of a batch that nothing happens to."""
    return symid.identify_batch("emps", paths, output=output).table


def worker_killed(paths: Sequence[Path], output: Path) -> pl.DataFrame:
    """Table of a batch on a cluster that loses one of its two workers."""
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50) as cluster:

        def track(rows: Iterable[Any], total: int) -> Iterator[Any]:
            for place, row in enumerate(rows):
                if place == total // 3:
                    victim = next(iter(cluster.workers.values()))
                    os.kill(victim.pid, signal.SIGKILL)
                yield row

        address = cluster.scheduler_address
        return symid.identify_batch("emps", paths, output=output, scheduler=address, track=track).table


def command_killed(paths: Sequence[Path], folder: Path) -> tuple[pl.DataFrame, int]:
    """Table of a command that was killed and given again, and the rows that it had from before."""
    start = [sys.executable, "-c", "from symid.cli import main; main()"]
    command = [*start, "batch", "emps", str(paths[0].parent), "-o", "results.parquet"]
    journal = folder / JOURNAL
    running = subprocess.Popen(command, cwd=folder, start_new_session=True, stdout=subprocess.DEVNULL)
    while running.poll() is None and len(read_journal(journal)) < len(paths) // 3:
        time.sleep(0.2)
    with contextlib.suppress(ProcessLookupError):  # too few logs: it had ended
        os.killpg(running.pid, signal.SIGKILL)
    running.wait()
    kept = {row["log"]: row["finished"] for row in read_journal(journal)}
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    table = pl.read_parquet(folder / "results.parquet")
    after = dict(table.select("log", "finished").rows())
    return table, sum(after.get(log) == finished for log, finished in kept.items())


def judged(name: str, table: pl.DataFrame, expected: pl.DataFrame) -> bool:
    """Print what became of the logs; whether each is there once, as it should be."""
    logs = table["log"].map_elements(lambda log: Path(log).name, return_dtype=pl.String)
    lost, twice = expected.height - logs.n_unique(), table.height - logs.n_unique()
    rows = [
        frame.sort("content").drop(column for column in VOLATILE if column in frame.columns).rows()
        for frame in (table, expected)
    ]
    apart = sum(a != b for a, b in zip(*rows, strict=False))
    print(f"  {name:34}{table.height:8} rows{lost:8} lost{twice:8} twice{apart:8} other", flush=True)
    return not (lost or twice or apart)


def main() -> None:
    options = parser_of(__doc__, logs=1000).parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "logs").mkdir()
        paths = write_logs(folder / "logs", options.logs)
        expected = undisturbed(paths, folder / "undisturbed.parquet")
        good = judged("undisturbed", expected, expected)
        good &= judged("a worker of a cluster killed", worker_killed(paths, folder / "c.parquet"), expected)
        table, kept = command_killed(paths, folder)
        good &= judged("command killed, given again", table, expected)
        print(f"  rows that the second command had from the first: {kept}")
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
