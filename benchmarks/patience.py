"""A time limit for code that may hang; for `bad_input` and `damaged_logs`."""

import contextlib
import signal
from collections.abc import Iterator
from types import FrameType

_WAITS = 5
"""Longest wait by the clock, in limits of processor time: other work may have the cores."""


class Hangs(BaseException):
    """Code ran longer than allowed."""


@contextlib.contextmanager
def limited(seconds: int) -> Iterator[None]:
    """Raise `Hangs` if the block uses more processor time, or waits longer than that of several such blocks."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise Hangs

    limits = (
        (signal.ITIMER_PROF, signal.SIGPROF, seconds),
        (signal.ITIMER_REAL, signal.SIGALRM, _WAITS * seconds),
    )
    before = [signal.signal(number, stop) for _, number, _ in limits]
    for timer, _, most in limits:
        signal.setitimer(timer, most)
    try:
        yield
    finally:
        for (timer, number, _), handler in zip(limits, before, strict=True):
            signal.setitimer(timer, 0)
            signal.signal(number, handler)
