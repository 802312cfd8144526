"""One batch at a time writes a table of results."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from filelock import BaseFileLock, FileLock, Timeout

from symid.errors import SettingError, SymidError


@contextmanager
def locked(files: Sequence[Path]) -> Iterator[None]:
    """Hold tables of results against other batches, by a hidden file beside each, whose lock ends with its process.

    Raises
    ------
    SettingError
        If another batch holds one of them.
    SymidError
        If a lock cannot be made.
    """
    with ExitStack() as held:
        for file in sorted(files):
            try:
                held.callback(_release, _acquired(file.resolve()))
            except Timeout as error:
                raise SettingError(
                    f"{file}: another batch is writing these results: wait for it, or give another output"
                ) from error
            except (OSError, NotImplementedError) as error:
                cause = getattr(error, "strerror", None) or str(error)
                raise SymidError(f"{file}: cannot be locked ({cause}): choose another folder") from error
        yield


def _acquired(file: Path) -> BaseFileLock:
    place = file.with_name(f".{file.name}.lock")
    while True:
        lock = FileLock(place, timeout=0)
        lock.acquire()
        if place.exists():
            return lock
        lock.release()  # the batch before has removed it since it was opened


def _release(lock: BaseFileLock) -> None:
    with suppress(OSError):  # Windows does not remove what is open
        Path(lock.lock_file).unlink()
    lock.release()
