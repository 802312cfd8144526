"""Limits of a worker: time, memory, and its end with the batch.

An alarm of the operating system ends a worker that takes too long; no computation, even one that blocks the
interpreter, can prevent that. Systems without alarms (Windows) only have the check of the parent process.
"""

import contextlib
import ctypes
import os
import signal
import threading
import time
from collections.abc import Iterator
from typing import Final

from symid.data import whole_memory

MOST_SECONDS: Final = 3600.0
"""Default time limit of a log, s."""
_LEAST_MEMORY: Final = 4e9
_SHARES: Final = 2.0
"""Multiple of its share of memory that a worker may take, since few need it at the same time."""
_PARENT_DEATH: Final = 1  # PR_SET_PDEATHSIG of prctl
_ALARMS: Final = hasattr(signal, "setitimer")


class TooLongError(Exception):
    """A log exceeded its time limit."""


def share_of_memory(jobs: int) -> float:
    """Memory limit of each of several workers in bytes."""
    return max(_LEAST_MEMORY, _SHARES * whole_memory() / jobs)


def limit_memory(n_bytes: float) -> None:
    """Limit the memory of this process: a larger allocation fails here, not elsewhere on the machine."""
    try:
        import resource  # not on Windows
    except ImportError:
        return
    with contextlib.suppress(ValueError, OSError, OverflowError):
        resource.setrlimit(resource.RLIMIT_DATA, (int(n_bytes), resource.getrlimit(resource.RLIMIT_DATA)[1]))


def end_with(parent: int) -> None:
    """End this process with the process that started it: immediately on Linux, otherwise within about a second.

    The parent's number comes from itself: this process may have been starting still when its parent was killed.
    """
    with contextlib.suppress(AttributeError, OSError, TypeError):
        ctypes.CDLL(None).prctl(_PARENT_DEATH, signal.SIGKILL, 0, 0, 0)
    threading.Thread(target=_end_after, args=(parent,), daemon=True).start()


def _end_after(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(1.0)
    os._exit(1)


@contextlib.contextmanager
def ending_after(seconds: float) -> Iterator[None]:
    """Let the operating system end this process if the block takes longer."""
    if not _ALARMS:
        yield
        return
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


@contextlib.contextmanager
def raising_after(seconds: float) -> Iterator[None]:
    """Raise TooLongError if the block takes longer; only in the main thread, since others cannot be interrupted."""
    if not _ALARMS or threading.current_thread() is not threading.main_thread():
        yield
        return

    def too_long(*_: object) -> None:
        raise TooLongError(f"took longer than {seconds:g} s: give it more time, or cut the log")

    before = signal.signal(signal.SIGALRM, too_long)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
