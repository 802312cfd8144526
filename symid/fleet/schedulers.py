"""Where the logs of a batch are worked on: in this process, in processes of this machine, on a cluster.

All of them take a function and tasks, and yield each task once with its result, in any order; the result is None for a
task that killed its process twice.
"""

from __future__ import annotations

import math
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
    LONGEST,
    end_with_parent,
    ending_after,
    limit_memory,
    raising_after,
    share_of_memory,
)

Task = TypeVar("Task")
Result = TypeVar("Result")
Finished = Generator[tuple[Task, Result | None]]


class Scheduler(Protocol):
    """Runs tasks in processes or on a cluster."""

    def run(self, work: Callable[[Task], Result], tasks: Sequence[Task]) -> Finished[Task, Result]:
        """Each task once with its result; None for one that twice killed the process that worked on it."""


@dataclass(frozen=True)
class Processes:
    """Processes of this machine.

    One job works in this very process, which then shares the fate of a log that kills it. A process that takes longer
    than `seconds` for a task is ended as if the task had killed it.

    >>> list(Processes(1).run(abs, [-1, 2]))
    [(-1, 1), (2, 2)]
    """

    jobs: int
    seconds: float = LONGEST

    def run(self, work: Callable[[Task], Result], tasks: Sequence[Task]) -> Finished[Task, Result]:
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
            try:
                for place, result in self._together(work, left, begun):
                    yield left.pop(place), result
            except TerminatedWorkerError:
                for place in [place for place in begun if place in left]:
                    task = left.pop(place)
                    yield task, self._alone(work, task)

    def _together(
        self, work: Callable[[Task], Result], left: dict[int, Task], begun: list[int]
    ) -> Iterator[tuple[int, Result]]:
        def calls() -> Iterator[Any]:
            for place, task in list(left.items()):
                begun.append(place)
                yield joblib.delayed(_placed)(work, place, task, self.seconds)

        results: Iterator[tuple[int, Result]] = _pool(self.jobs)(calls())
        return results

    def _alone(self, work: Callable[[Task], Result], task: Task) -> Result | None:
        """Result of a task that may have killed its process, in one that does nothing else.

        None if it kills two of these, or one after half the time that a task may take.
        """
        for _ in range(2):
            begun = time.monotonic()
            try:
                ((_, result),) = _pool(2)([joblib.delayed(_placed)(work, 0, task, self.seconds)])
            except TerminatedWorkerError:
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
        initializer=_serve,
        initargs=(share_of_memory(jobs),),
    )


def _serve(memory: float) -> None:
    """Make a worker leave Ctrl-C to the main process, end when that is gone, and not take all memory."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()
    limit_memory(memory)


def _placed(work: Callable[[Task], Result], place: int, task: Task, seconds: float) -> tuple[int, Result]:
    with ending_after(seconds):
        return place, work(task)


_PATIENCE = 10.0
"""Seconds in which the scheduler of a cluster must answer."""


@dataclass(frozen=True)
class Cluster:
    """Workers of a Dask cluster (``tcp://10.0.0.1:8786``), with symid and the same paths of logs."""

    address: str

    def run(self, work: Callable[[Task], Result], tasks: Sequence[Task]) -> Finished[Task, Result]:
        """Run tasks, as `Scheduler.run`."""
        distributed = _distributed()
        try:
            client = distributed.Client(self.address, timeout=_PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            raise SettingError(
                f"no Dask scheduler answers at {self.address}: start one with 'dask scheduler', or check the address"
            ) from error
        with client:
            yield from _submitted(client, work, tasks)


_GROUP = 8
"""Tasks that go to a worker together: one by one, the scheduler is busier than a hundred workers."""
_AHEAD = 3
"""Groups that are submitted for each thread of the cluster."""


def _submitted(client: Any, work: Callable[[Task], Result], tasks: Sequence[Task]) -> Finished[Task, Result]:
    distributed = _distributed()
    threads = max(1, sum(client.nthreads().values()))
    size = max(1, min(_GROUP, len(tasks) // (_AHEAD * threads)))
    groups = iter([tasks[start : start + size] for start in range(0, len(tasks), size)])
    flow, waiting = distributed.as_completed(loop=client.loop), {}
    suspects: list[Task] = []

    def submit(group: Sequence[Task]) -> None:
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
    for task in suspects:  # one at a time: all tasks that waited for a dead worker are suspects
        results = _results(client.submit(_grouped, work, [task], pure=False))
        yield task, None if results is None else results[0]


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


def _grouped(work: Callable[[Task], Result], tasks: Sequence[Task]) -> list[Result]:
    return [work(task) for task in tasks]


def _distributed() -> Any:
    try:
        import distributed  # the extra symid[cluster]
    except ImportError as error:
        raise SettingError("`scheduler` needs Dask: install it with pip install 'symid[cluster]'") from error
    return distributed


def scheduler_of(jobs: int | None, address: str | None, n_tasks: int, seconds: float = LONGEST) -> Scheduler:
    """The cluster at an address, else as many processes as are asked for or as there are cores.

    SettingError if their number or the time is not positive, or Dask is not installed.
    """
    if not 0 < seconds < math.inf:
        raise SettingError(f"a limit of {seconds:g} s for each log is not possible: give more than 0")
    if jobs is not None and jobs < 1:
        raise SettingError(f"{jobs} jobs are not possible: give 1 or more")
    if address is not None:
        _distributed()
        return Cluster(address)
    return Processes(max(1, min(jobs or joblib.cpu_count() or 1, n_tasks)), seconds)
