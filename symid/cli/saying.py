"""Messages of commands besides reports: visible text, also where a stream is closed or knows only ASCII."""

from __future__ import annotations

import contextlib
import io
import os
import sys

from symid.text import one_line, visible


def say(text: str, *, err: bool = False, end: str = "\n") -> None:
    """Print text on standard output or standard error; nothing where that is closed."""
    stream = sys.stderr if err else sys.stdout
    if stream is not None:
        print(visible(text), end=end, file=stream)


def fail(message: str, code: int = 2) -> int:
    """Say in one line what is wrong; gives the exit code."""
    with contextlib.suppress(OSError):
        say(f"symid: {one_line(message)}", err=True)
    return code


def prepare_streams() -> None:
    """Let both streams write what their encoding lacks as escapes instead of failing."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def finish_output() -> None:
    """Write out what standard output still holds; OSError if that is not possible."""
    if sys.stdout is None or sys.stdout.closed:
        return
    try:
        sys.stdout.flush()
    except OSError:
        # The rest of the buffer would fail again, with a trace, when the interpreter ends.
        with contextlib.suppress(OSError, ValueError, AttributeError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise
