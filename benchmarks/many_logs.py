"""Time and memory of `symid batch` on a Dask cluster against the number of logs, up to an extrapolation.

A LocalCluster of two workers identifies 100, 1000 ... logs of 40 000 samples of an EMPS-like axis (see batch.py) and
writes their table. Of the logs 100 are different; the others are further names of these files, which each is read and
identified for. Printed are wall time, time of a log, the memory that this process, which holds the rows, takes in
addition, the size of the table, and the exponent of the time over the number of logs; with that exponent of the last
step the time of `--extrapolated` logs.

Usage: python -m benchmarks.many_logs [--largest 1e4] [--extrapolated 1e5]
"""

import math
import os
import tempfile
import time
from pathlib import Path

import symid
from benchmarks.batch import cluster_of_two, write_logs
from benchmarks.long_logs import peak_memory
from benchmarks.options import parser_of

DIFFERENT = 100


def linked(folder: Path, files: list[Path], logs: int) -> Path:
    """A folder with as many logs, each a further name of one of the files."""
    folder.mkdir()
    for i in range(logs):
        os.link(files[i % len(files)], folder / f"{i:06d}.parquet")
    return folder


def main() -> None:
    options = parser_of(__doc__, largest=1e4, extrapolated=1e5).parse_args()
    sizes = [10**k for k in range(2, round(math.log10(options.largest)) + 1)]
    seconds: list[float] = []
    with tempfile.TemporaryDirectory() as name, cluster_of_two() as cluster:
        home = Path(name)
        (home / "different").mkdir()
        files = write_logs(home / "different", DIFFERENT)
        symid.identify_batch("emps", files[:8], scheduler=cluster.scheduler_address)  # imports of the workers
        before = peak_memory()
        print(f"{'logs':>8} {'s':>8} {'ms a log':>9} {'peak MB':>8} {'table MB':>9}")
        for logs in sizes:
            folder, table = linked(home / str(logs), files, logs), home / f"{logs}.result.parquet"
            begin = time.perf_counter()
            done = symid.identify_batch("emps", folder, output=table, scheduler=cluster.scheduler_address)
            seconds.append(time.perf_counter() - begin)
            assert len(done.rows) == logs
            assert done.statuses.get("ok", 0) >= 0.9 * logs, done.statuses
            print(
                f"{logs:8d} {seconds[-1]:8.1f} {1e3 * seconds[-1] / logs:9.1f} {peak_memory() - before:8.0f} "
                f"{table.stat().st_size / 1e6:9.2f}",
                flush=True,
            )
    if len(sizes) > 1:
        slope = math.log10(seconds[-1] / seconds[-2])
        likely = seconds[-1] * (options.extrapolated / sizes[-1]) ** slope
        print(
            f"time grows with the exponent {slope:.2f}; {options.extrapolated:.0e} logs take {likely:.0f} s"
        )


if __name__ == "__main__":
    main()
