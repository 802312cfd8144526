"""A log that takes too long, or a batch that is killed, leaves no process at work."""

import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from symid.errors import SettingError
from symid.fleet import BatchSettings, identify_batch
from symid.fleet.schedulers import Processes, scheduler_of
from symid.fleet.worker_limits import TooLongError, limit_memory, raising_after, share_of_memory


def test_a_worker_that_holds_the_interpreter_is_ended() -> None:
    work = eval("lambda task: task if task else sum(range(10**13))")  # sent as it is: workers lack this file
    assert dict(Processes(2, seconds=0.3).run(work, [0, 1, 2])) == {0: None, 1: 1, 2: 2}


def test_in_this_process_a_log_that_takes_too_long_is_a_row(
    logs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("symid.fleet.work._identified", lambda *_: time.sleep(60))
    batch = identify_batch("rigid_1m", logs / "0.parquet", jobs=1, settings=BatchSettings(seconds=0.2))
    (row,) = batch.rows
    assert (row["status"], row["key"]) == ("failed", None)
    assert "took longer than 0.2 s" in str(row["message"])


def test_the_alarm_is_put_back() -> None:
    before = signal.getsignal(signal.SIGALRM)
    with pytest.raises(TooLongError, match=r"longer than 0\.05 s"), raising_after(0.05):
        time.sleep(10)
    assert (signal.getsignal(signal.SIGALRM), signal.getitimer(signal.ITIMER_REAL)[0]) == (before, 0.0)


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), float("inf")])
def test_times_that_are_none_are_refused(seconds: float) -> None:
    with pytest.raises(SettingError, match="not possible"):
        scheduler_of(1, None, 1, seconds)


def test_a_worker_ends_with_its_parent_even_while_it_holds_the_interpreter() -> None:
    """The parent starts a child that computes without a pause, and is killed."""
    child = (
        "import os; from symid.fleet.worker_limits import end_with; end_with(os.getppid()); "
        "print('on', flush=True); sum(range(10**13))"
    )
    parent = (
        "import subprocess, sys\n"
        f"run = subprocess.Popen([sys.executable, '-c', {child!r}], stdout=subprocess.PIPE)\n"
        "run.stdout.readline()\n"
        "print(run.pid, flush=True)\n"
        "run.wait()\n"
    )
    with subprocess.Popen([sys.executable, "-c", parent], stdout=subprocess.PIPE, text=True) as started:
        assert started.stdout is not None
        worker = int(started.stdout.readline())
        started.kill()
    end = time.monotonic() + 60
    while Path(f"/proc/{worker}/stat").exists() and time.monotonic() < end:
        if Path(f"/proc/{worker}/stat").read_text(encoding="ascii").split()[2] == "Z":
            break
        time.sleep(0.01)
    else:
        assert not Path(f"/proc/{worker}").exists()


def test_a_worker_that_was_starting_when_its_parent_was_killed_ends() -> None:
    with subprocess.Popen([sys.executable, "-c", ""]) as gone:
        pass
    waiting = (
        f"import time; from symid.fleet.worker_limits import end_with; end_with({gone.pid}); time.sleep(60)"
    )
    assert subprocess.run([sys.executable, "-c", waiting], timeout=60, check=False).returncode == 1


def test_memory_of_a_process_is_limited() -> None:
    assert share_of_memory(2) >= 4e9
    program = (
        "from symid.fleet.worker_limits import limit_memory\nlimit_memory(3e8)\n"
        "try:\n    bytearray(10**9)\nexcept MemoryError:\n    print('refused')\n"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout == "refused\n"
    before = resource.getrlimit(resource.RLIMIT_DATA)
    limit_memory(float("inf"))
    assert resource.getrlimit(resource.RLIMIT_DATA) == before
    assert os.getpid()
