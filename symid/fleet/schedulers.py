"""Schedulers of a batch: this process, processes of this machine, or a cluster.

Each takes a function and tasks, and yields each task once with its result, in any order. The result of a task that
killed its process twice is None.
"""

import math
import os
import signal
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, Protocol, TypeVar

import joblib
from joblib.externals.loky.process_executor import TerminatedWorkerError

from symid.errors import SettingError, SymidError
from symid.fleet.worker_limits import (
    MOST_SECONDS,
    end_with,
    ending_after,
    limit_memory,
    raising_after,
    share_of_memory,
)

AnyTask = TypeVar("AnyTask")
Result = TypeVar("Result")
Finished = Generator[tuple[AnyTask, Result | None]]

_DEATHS = (TerminatedWorkerError, BrokenPipeError)
"""Exceptions for a worker that has died, at its work or before it took any."""


class Scheduler(Protocol):
    """Runs tasks in processes or on a cluster."""

    def run(self, work: Callable[[AnyTask], Result], tasks: Sequence[AnyTask]) -> Finished[AnyTask, Result]:
        """Each task once with its result, None for a task that killed its process twice."""


@dataclass(frozen=True)
class Processes:
    """Processes of this machine.

    A single job runs in the calling process, which a log can then kill. A process that takes longer than `seconds` for
    a task is terminated as if the task had killed it.

    >>> list(Processes(1).run(abs, [-1, 2]))
    [(-1, 1), (2, 2)]
    """

    jobs: int
    seconds: float = MOST_SECONDS

    def run(self, work: Callable[[AnyTask], Result], tasks: Sequence[AnyTask]) -> Finished[AnyTask, Result]:
        """Run tasks, as `Scheduler.run`."""
        if self.jobs == 1:
            for task in tasks:
                with raising_after(self.seconds):
                    result = work(task)
                yield task, result
            return
        left = dict(enumerate(tasks))
        while left:
            begun: list[int] = []

            def calls() -> Iterator[Any]:
                for place, task in list(left.items()):
                    begun.append(place)  # noqa: B023  consumed within this round
                    yield joblib.delayed(_placed)(work, place, task, self.seconds)

            # A dead worker ends the whole pool: each task that was begun but not finished is run again alone, then
            # the rest in a new pool.
            try:
                for place, result in _pool(self.jobs)(calls()):
                    yield left.pop(place), result
            except _DEATHS:
                for place in [place for place in begun if place in left] or list(left)[:1]:
                    task = left.pop(place)
                    yield task, self._in_own_process(work, task)

    def _in_own_process(self, work: Callable[[AnyTask], Result], task: AnyTask) -> Result | None:
        """Result of a suspected task in a separate process.

        None if the task kills two processes, or one after more than half of its time limit.
        """
        for _ in range(2):
            begun = time.monotonic()
            try:
                ((_, result),) = _pool(2)([joblib.delayed(_placed)(work, 0, task, self.seconds)])
            except _DEATHS:
                if time.monotonic() - begun > self.seconds / 2:
                    break
            else:
                return result  # type: ignore[no-any-return]  # joblib has no types
        return None


def _pool(jobs: int) -> joblib.Parallel:
    return joblib.Parallel(
        jobs,
        backend="loky",
        return_as="generator_unordered",
        inner_max_num_threads=1,
        initializer=_prepare_worker,
        initargs=(os.getpid(), share_of_memory(jobs)),
    )


def _prepare_worker(parent: int, memory: float) -> None:
    """Set up a worker: it ignores Ctrl-C, ends with the main process, and has a limit of memory."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with(parent)
    limit_memory(memory)


def _placed(
    work: Callable[[AnyTask], Result], place: int, task: AnyTask, seconds: float
) -> tuple[int, Result]:
    with ending_after(seconds):
        return place, work(task)


_PATIENCE = 10.0  # s, within which the scheduler of a cluster must answer


@dataclass(frozen=True)
class Cluster:
    """Workers of a Dask cluster (``tcp://10.0.0.1:8786``) that have symid and see the logs under the same paths."""

    address: str

    def run(self, work: Callable[[AnyTask], Result], tasks: Sequence[AnyTask]) -> Finished[AnyTask, Result]:
        """Run tasks, as `Scheduler.run`."""
        # A client that never began waits for an answer once more, and complains, when it is deleted.
        begun = type("Client", (_distributed().Client,), {"__del__": lambda _: None})
        try:
            client = begun(self.address, timeout=_PATIENCE, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:  # TypeError: tls without certificates
            raise SettingError(
                f"no Dask scheduler answers at {self.address}: start one with 'dask scheduler', or check the address"
            ) from error
        with client:
            yield from _submitted(client, work, tasks)


_GROUP = 8  # most tasks sent together: one by one, the scheduler would limit a hundred workers
_AHEAD = 3  # groups submitted in advance for each thread of the cluster


def _submitted(
    client: Any, work: Callable[[AnyTask], Result], tasks: Sequence[AnyTask]
) -> Finished[AnyTask, Result]:
    distributed = _distributed()
    threads = max(1, sum(client.nthreads().values()))
    groups = _groups(tasks, _AHEAD * threads)
    flow, waiting = distributed.as_completed(loop=client.loop), {}
    suspects: list[AnyTask] = []

    def submit(group: Sequence[AnyTask]) -> None:
        future = client.submit(_grouped, work, group, pure=False)
        waiting[future.key] = group
        flow.add(future)

    for group in islice(groups, _AHEAD * threads):
        submit(group)
    for future in flow:
        group = waiting.pop(future.key)
        if (results := _results(future)) is None:
            suspects += group
        else:
            yield from zip(group, results, strict=True)
        if (following := next(groups, None)) is not None:
            submit(following)
    for task in suspects:  # one at a time, since all tasks of a dead worker are suspected
        results = _results(client.submit(_grouped, work, [task], pure=False))
        yield task, None if results is None else results[0]


def _groups(tasks: Sequence[AnyTask], ahead: int) -> Iterator[Sequence[AnyTask]]:
    """Tasks in groups that become smaller towards the end, so that all workers end at nearly the same time.

    >>> [len(group) for group in _groups(range(40), 6)]
    [6, 5, 4, 4, 3, 3, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]
    """
    begin = 0
    while begin < len(tasks):
        size = max(1, min(_GROUP, (len(tasks) - begin) // ahead))
        yield tasks[begin : begin + size]
        begin += size


def _results(future: Any) -> list[Any] | None:
    """Results of a group; None if it killed its workers."""
    distributed = _distributed()
    try:
        results: list[Any] = future.result()
    except distributed.scheduler.KilledWorker:
        return None
    except Exception as error:
        cause = f"{type(error).__name__}: {error}"
        raise SymidError(f"the cluster cannot do the work ({cause}): check its workers") from error
    return results


def _grouped(work: Callable[[AnyTask], Result], tasks: Sequence[AnyTask]) -> list[Result]:
    return [work(task) for task in tasks]


def _distributed() -> Any:
    try:
        import distributed  # the extra symid[cluster]
    except ImportError as error:
        raise SettingError("`scheduler` needs Dask: install it with pip install 'symid[cluster]'") from error
    return distributed


def scheduler_of(
    jobs: int | None, address: str | None, n_tasks: int, seconds: float = MOST_SECONDS
) -> Scheduler:
    """The cluster at an address, else the given number of processes, or one per core.

    SettingError if the number of processes or the time limit is not positive, or Dask is not installed.
    """
    if not 0 < seconds < math.inf:
        raise SettingError(f"a limit of {seconds:g} s for each log is not possible: give more than 0")
    if jobs is not None and jobs < 1:
        raise SettingError(f"{jobs} jobs are not possible: give 1 or more")
    if address is not None:
        _distributed()
        return Cluster(address)
    return Processes(max(1, min(jobs or joblib.cpu_count() or 1, n_tasks)), seconds)
