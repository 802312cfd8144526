"""Progress on standard error, for work that takes long, on a terminal."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Iterator, Sized
from contextlib import AbstractContextManager, ExitStack, nullcontext
from typing import TypeVar

Item = TypeVar("Item")

_PATIENCE = 2.0
"""Seconds of work before progress is shown."""


def _is_watched() -> bool:
    return sys.stderr is not None and sys.stderr.isatty()


def working(what: str) -> AbstractContextManager[object]:
    """Show that work of unknown length is going on, if standard error is a terminal.

    Examples
    --------
    >>> with working("thinking"):
    ...     1 + 1
    2
    """
    if not _is_watched():
        return nullcontext()
    from rich.console import Console  # takes 50 ms to load

    return Console(stderr=True).status(what)


def tracked(items: Iterable[Item], what: str, total: int | None = None) -> Iterator[Item]:
    """Pass items on; once their work has taken two seconds, show a bar if standard error is a terminal.

    It is labelled `what`; `total` is the number of items if they have no length.

    Examples
    --------
    >>> list(tracked(["a", "b"], "letters"))
    ['a', 'b']
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
