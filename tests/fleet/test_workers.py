"""Workers that die: every log is in the result once, and a log that kills its worker is a row that says so."""

import os
import signal
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from distributed import LocalCluster

from symid.errors import SymidError
from symid.fleet import identify_batch
from symid.fleet.schedulers import Cluster, Processes, Scheduler

N = 16


def killing(*numbers: int, once: tuple[int, Path] | None = None) -> Callable[[int], int]:
    """A function that squares; a few numbers kill the process that works on them, one of them the first time only.

    It is local, so that it is sent to other processes as it is: they need not know this file.
    """

    def work(task: int) -> int:
        time.sleep(0.01)
        first = once is not None and task == once[0] and not once[1].exists()
        if first:
            once[1].touch()
        if first or task in numbers:
            os.kill(os.getpid(), signal.SIGKILL)
        return task * task

    return work


def results(scheduler: Scheduler, work: Callable[[int], int]) -> dict[int, int | None]:
    found = list(scheduler.run(work, range(N)))
    assert sorted(task for task, _ in found) == list(range(N))
    return dict(found)


SQUARES = {task: task * task for task in range(N)}


def test_a_task_that_kills_its_process_twice_has_no_result_and_one_that_does_it_once_has(
    tmp_path: Path,
) -> None:
    work = killing(5, once=(7, tmp_path / "flag"))
    assert results(Processes(2), work) == {**SQUARES, 5: None}


def test_workers_that_die_before_they_take_a_task_leave_rows_without_results(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def broken(*_: object, **__: object) -> Any:
        raise BrokenPipeError

    monkeypatch.setattr("symid.fleet.schedulers.joblib.Parallel", broken)
    assert dict(Processes(2).run(abs, [1, 2])) == {1: None, 2: None}


@pytest.fixture(scope="module")
def cluster() -> Iterator[LocalCluster]:
    """A scheduler and two worker processes, which a nanny starts anew when they die."""
    with LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=True,
        dashboard_address=":0",
        host="127.0.0.1",
        silence_logs=50,
        scheduler_kwargs={"allowed_failures": 1},  # deaths after which a task is given up; 3 by default
    ) as running:
        running.wait_for_workers(2, timeout=60)
        yield running


def test_a_cluster_gives_the_rows_of_this_process(logs: Path, cluster: LocalCluster) -> None:
    alone = identify_batch("rigid_1m", logs, jobs=1)
    on_cluster = identify_batch("rigid_1m", logs, scheduler=cluster.scheduler_address)
    volatile = ("seconds", "finished")
    assert on_cluster.table.drop(volatile).rows() == alone.table.drop(volatile).rows()


def kill_a_worker_after(rows: int, pids: Sequence[int]) -> Any:
    def track(items: Iterable[Any], total: int) -> Iterator[Any]:
        for place, item in enumerate(items):
            if place == rows:
                os.kill(pids[0], signal.SIGKILL)
            yield item

    return track


def worker_pids(cluster: LocalCluster) -> list[int]:
    return [nanny.pid for nanny in cluster.workers.values()]


def test_a_worker_of_a_cluster_is_killed_in_the_middle(logs: Path, cluster: LocalCluster) -> None:
    for place in range(6, 24):
        (logs / f"{place}.parquet").symlink_to(f"{place % 6}.parquet")
    batch = identify_batch(
        "rigid_1m",
        logs,
        output="r.parquet",
        scheduler=cluster.scheduler_address,
        track=kill_a_worker_after(5, worker_pids(cluster)),
    )
    assert batch.table["log"].n_unique() == batch.table.height == 24
    assert batch.statuses == {"ok": 24}


def test_a_task_that_kills_the_workers_of_a_cluster_has_no_result(cluster: LocalCluster) -> None:
    cluster.wait_for_workers(2, timeout=60)
    found = results(Cluster(cluster.scheduler_address), killing(5))
    assert found == {**SQUARES, 5: None}


def test_a_cluster_that_cannot_do_the_work_is_one_error(cluster: LocalCluster) -> None:
    cluster.wait_for_workers(1, timeout=60)  # a cluster without any would be waited for

    def fail(task: int) -> int:
        raise LookupError("no symid here")

    with pytest.raises(SymidError, match=r"cannot do the work \(LookupError: no symid here\)"):
        results(Cluster(cluster.scheduler_address), fail)


def test_a_worker_is_killed_in_the_middle_of_a_batch(logs: Path) -> None:
    for place in range(6, 24):
        (logs / f"{place}.parquet").symlink_to(f"{place % 6}.parquet")
    from joblib.externals.loky.reusable_executor import get_reusable_executor

    def track(items: Iterable[Any], total: int) -> Iterator[Any]:
        for place, item in enumerate(items):
            if place == 3:
                pids = list(get_reusable_executor(reuse=True)._processes)
                os.kill(pids[0], signal.SIGKILL)
            yield item

    batch = identify_batch("rigid_1m", logs, output="r.parquet", jobs=2, track=track)
    assert batch.table["log"].n_unique() == batch.table.height == 24
    assert batch.statuses == {"ok": 24}
