"""The journal of a batch, which keeps finished rows however the batch ends, and the lock of its results."""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import TracebackType

from filelock import BaseFileLock, FileLock, Timeout

from symid.errors import SettingError, SymidError
from symid.files import is_finite_number
from symid.fleet.row import TEXT_COLUMNS, ResultRow

_ROWS, _SECONDS = 64, 1.0
"""After which rows are synchronised to the disk; if only the process dies, none is lost."""


def journal_file(results: Path) -> Path:
    """Journal beside a file of results."""
    return results.with_name(results.name + ".journal")


def read_journal(file: Path) -> list[ResultRow]:
    """Rows of a journal, without a line that was not completed before its process ended."""
    rows: list[ResultRow] = []
    if not file.exists():
        return rows
    for line in file.read_bytes().split(b"\n"):
        try:
            row = json.loads(line)
        except (ValueError, RecursionError):
            continue
        if _is_row(row):
            rows.append(row)
    return rows


def _is_row(row: object) -> bool:
    """Whether a line has the form that a batch writes: text in text columns, numbers in the others."""
    if not isinstance(row, dict) or not isinstance(row.get("log"), str):
        return False
    return all(
        value is None or (isinstance(value, str) if name in TEXT_COLUMNS else is_finite_number(value))
        for name, value in row.items()
    )


class Journal:
    """Appends rows to a file, which may exist already.

    SymidError if a row cannot be written, as on a full disk; earlier rows remain intact.
    """

    def __init__(self, file: Path) -> None:
        self.file = file
        self._pending, self._since = 0, time.monotonic()
        try:
            self._handle = os.open(file, os.O_CREAT | os.O_RDWR | os.O_APPEND, 0o666)
        except OSError as error:
            raise _cannot_write(self.file, error) from error
        size = os.fstat(self._handle).st_size
        if size and os.pread(self._handle, 1, size - 1) != b"\n":
            self._write(b"\n")  # ends an incomplete line

    def append(self, row: ResultRow) -> None:
        """Append a row as a line of JSON; the file is forced to disk every few rows."""
        self._write(json.dumps(row, allow_nan=False).encode() + b"\n")
        self._pending += 1
        if self._pending >= _ROWS or time.monotonic() - self._since > _SECONDS:
            try:
                os.fsync(self._handle)
            except OSError as error:
                raise _cannot_write(self.file, error) from error
            self._pending, self._since = 0, time.monotonic()

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with contextlib.suppress(OSError):
            os.fsync(self._handle)
        os.close(self._handle)

    def _write(self, line: bytes) -> None:
        """Write a line completely or not at all."""
        before, rest = os.fstat(self._handle).st_size, memoryview(line)
        try:
            while rest:
                rest = rest[os.write(self._handle, rest) :]
        except OSError as error:
            with contextlib.suppress(OSError):
                os.ftruncate(self._handle, before)
            raise _cannot_write(self.file, error) from error


def _cannot_write(file: Path, error: OSError) -> SymidError:
    return SymidError(f"{file}: cannot be written ({error.strerror})")


@contextlib.contextmanager
def locked(files: Sequence[Path]) -> Iterator[None]:
    """Lock tables of results against other batches, by a hidden file beside each; the lock ends with its process."""
    with contextlib.ExitStack() as held:
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
        lock.release()  # the previous batch has removed the file since it was opened


def _release(lock: BaseFileLock) -> None:
    with contextlib.suppress(OSError):  # Windows does not remove open files
        Path(lock.lock_file).unlink()
    lock.release()
