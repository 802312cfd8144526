"""Messages on the terminal, with settings written as options, whatever the stream is; progress of long work."""

import contextlib
import io
import os
import re
import sys
import time
import warnings
from collections.abc import Iterable, Iterator, Sized
from contextlib import AbstractContextManager, ExitStack, nullcontext
from typing import Any, Final, TextIO, TypeVar

from symid.text import one_line, visible

_SAME: Final = re.findall(
    r"\w+",
    "bounds encoding held jobs joint known late measured memory method resample scheduler standstill to trim",
)
"""Settings whose option has their name."""
_OPTIONS: Final = {
    "columns": "--column",
    "controller": "--controller-gain",
    "cutoff_hz": "--cutoff",
    "filter_force=True": "--filter all",
    "fixed": "--fix",
    "gains": "--gain",
    "nominal": "--nominal P.json",
    "prior": "--prior P.json",
    "rate_hz": "--rate",
    "sampling_period": "--rate",
    "seconds": "--timeout",
    "units": "--unit",
} | {name: f"--{name}" for name in _SAME}
_SETTING: Final = re.compile(r"`((\w+)(?:=([^`]+))?)`")


def with_options(value: Any) -> Any:
    """Text, or a record with texts, in which settings between backquotes are written as options.

    >>> with_options("jitters: give `resample=own`, or lower `cutoff_hz`")
    'jitters: give --resample own, or lower --cutoff'
    >>> with_options({"notes": ["take `filter_force=True`", "column `x`"]})
    {'notes': ['take --filter all', 'column `x`']}
    """
    if isinstance(value, str):
        return _SETTING.sub(_option, value) if "`" in value else value
    if isinstance(value, dict):
        return {name: with_options(part) for name, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [with_options(part) for part in value]
    return value


def _option(match: re.Match[str]) -> str:
    whole, name, value = match.groups()
    option = _OPTIONS.get(whole) or _OPTIONS.get(name)
    if option is None:
        return match[0]
    return f"{option} {value}" if value and whole not in _OPTIONS else option


Item = TypeVar("Item")

_PATIENCE = 2.0
"""Seconds of work before progress is shown."""


def _is_watched() -> bool:
    return sys.stderr is not None and sys.stderr.isatty()


def working(what: str) -> AbstractContextManager[object]:
    """Show that work of unknown length is going on, if standard error is a terminal."""
    if not _is_watched():
        return nullcontext()
    from rich.console import Console  # takes 50 ms to load

    return Console(stderr=True).status(what)


def tracked(items: Iterable[Item], what: str, total: int | None = None) -> Iterator[Item]:
    """Pass items on; once their work has taken two seconds, show a bar if standard error is a terminal.

    It is labelled `what`; `total` is the number of items if they have no length.
    """
    if not _is_watched():
        yield from items
        return
    from rich.console import Console  # takes 50 ms to load
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    if total is None and isinstance(items, Sized):
        total = len(items)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]:.3g}/s"),
        TimeRemainingColumn(),
    )
    with ExitStack() as shown:
        bar: Progress | None = None
        begin = time.monotonic()
        for done, item in enumerate(items):
            if bar is None and time.monotonic() - begin > _PATIENCE:
                bar = shown.enter_context(Progress(*columns, console=Console(stderr=True), transient=True))
                bar.add_task(what, total=total, rate=0.0)
            if bar is not None:
                bar.update(bar.task_ids[0], completed=done, rate=done / (time.monotonic() - begin))
            yield item


def is_closed(stream: TextIO | None) -> bool:
    """Whether the parent process closed a standard stream."""
    return stream is None or getattr(stream, "name", "") == os.devnull


def say(text: str, *, err: bool = False, end: str = "\n") -> None:
    """Print text with settings written as options; nothing if the stream is closed."""
    stream = sys.stderr if err else sys.stdout
    if stream is not None:
        print(visible(with_options(text)), end=end, file=stream)


def fail(message: str, code: int = 2) -> int:
    """Print an error in one line and return the exit code."""
    with contextlib.suppress(OSError):
        say(f"symid: {one_line(message)}", err=True)
    return code


def prepare_streams() -> None:
    """Let streams escape characters that their encoding lacks, and open closed ones on the null device.

    Worker processes flush them, and a file must not get their descriptor: libraries would print into it.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115 - until the process ends
    warnings.filterwarnings("ignore", module="joblib")  # of work that is not needed after a fault
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def finish_output() -> None:
    """Flush standard output; OSError if that is not possible."""
    if sys.stdout is None or sys.stdout.closed:
        return
    try:
        sys.stdout.flush()
    except OSError:
        # The rest of the buffer would fail again, with a trace, when the interpreter ends.
        with contextlib.suppress(OSError, ValueError, AttributeError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise
