"""`identify_batch`: many logs identified into a table with one row per log, and its summary."""

import os
import shutil
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import polars as pl

from symid.axis import AnyAxis
from symid.errors import SettingError, SymidError
from symid.files import free_name, replacing
from symid.fleet.batch_settings import BatchSettings
from symid.fleet.journal import Journal, journal_file, locked, read_journal
from symid.fleet.plan import FleetAxis, PathLike, fleet_axes, log_files
from symid.fleet.result_table import (
    columns_of_parameters,
    read_rows,
    result_files,
    result_frame,
    units_of,
    write_table,
)
from symid.fleet.results import Units
from symid.fleet.row import ResultRow
from symid.fleet.schedulers import Scheduler, scheduler_of
from symid.fleet.work import Task, killed, work
from symid.identification import known_of_logs
from symid.shown import Shown
from symid.text import visible

Track = Callable[[Iterable[Any], int], Iterable[Any]]
_BEFORE = ".before"


class Interrupted(KeyboardInterrupt):
    """A batch was interrupted.

    Attributes
    ----------
    rows : int
        Number of finished rows.
    journal : Path or None
        File with these rows.
    """

    def __init__(self, rows: int, journal: Path | None) -> None:
        self.rows, self.journal = rows, journal
        super().__init__(f"interrupted: {_words_on_rows(rows, journal)}")


@dataclass(frozen=True, eq=False, repr=False)
class Batch(Shown):
    """Results of a batch."""

    rows: tuple[ResultRow, ...]
    """One for each log, in the order of the logs."""
    units: Units
    """Units by axis, sensors and parameter."""
    diagnosed: bool
    """Whether the logs were diagnosed."""
    joint: bool
    """Whether the rows hold the triangular factors of their logs, see `BatchSettings`."""
    reused: int
    """Number of rows reused from an earlier run."""
    files: tuple[Path, ...]
    """Files written."""
    replaced: Path | None
    """Copy of the former table if that held logs that are not in this one."""

    @cached_property
    def table(self) -> pl.DataFrame:
        """The rows as the table that is written to files."""
        return result_frame(self.rows, columns_of_parameters(self.units), self.diagnosed, self.joint)

    @property
    def headline(self) -> str:
        """Number of logs, in total and by status."""
        statuses = ", ".join(f"{name} {count}" for name, count in self.statuses.items())
        return f"of {len(self.rows)} logs: {statuses}"

    def to_frame(self) -> pl.DataFrame:
        """The rows as a polars data frame; ``to_pandas`` and ``to_arrow`` convert it to those of other libraries."""
        return self.table

    @property
    def statuses(self) -> dict[str, int]:
        """Number of logs of each status, the most frequent first."""
        return dict(Counter(str(row["status"]) for row in self.rows).most_common())


def identify_batch(
    axes: AnyAxis | Sequence[AnyAxis],
    logs: PathLike | Iterable[PathLike],
    *,
    output: PathLike | Iterable[PathLike] | None = None,
    settings: BatchSettings | None = None,
    known: Mapping[str, Mapping[str, float]] | None = None,
    jobs: int | None = None,
    scheduler: str | None = None,
    track: Track = lambda rows, total: rows,
) -> Batch:
    """Identify each log separately. A log that cannot be identified becomes a row with a status and a message.

    With `output`, a batch that was interrupted, even by a power failure, is completed by the same call. A row is reused
    if the contents of its log, the declaration of its axis, the settings and the version of symid are unchanged.

    Parameters
    ----------
    axes : Axis, str, path-like, model, or sequence of them
        Declarations, names or paths of their files, or models of them. A log belongs to the first of these axes whose
        force and sensors it contains.
    logs : path-like or iterable of path-like
        Files, folders (all logs in them) and glob patterns.
    output : path-like or iterable of path-like, optional
        A .parquet or .csv file, or one of each.
    settings : BatchSettings, optional
        Settings that all logs share.
    known : mapping of str to mapping of str to float, optional
        Values of parameters that differ from log to log, such as a payload, by path or name of the log; SI.
    jobs : int, optional
        Number of processes; that of the cores by default. With 1, this process does the work.
    scheduler : str, optional
        Address of a Dask scheduler, whose workers see the logs under the same paths.
    track : callable
        Takes the rows as they arrive and their final number, passes them on, and may show progress.

    Returns
    -------
    Batch

    Raises
    ------
    SettingError, GeneratedModuleError, SymidError
        If a setting is invalid, an axis has no module, or the results cannot be written.
    Interrupted
        By Ctrl-C; finished rows are kept.

    Examples
    --------
    >>> from symid.axis import shipped_folder
    >>> file = shipped_folder("data") / "emps" / "DATA_EMPS.mat"
    >>> batch = identify_batch("emps", file, settings=BatchSettings(columns={"q": "qm"}))
    >>> batch.table.select("axis", "samples").row(0), round(batch.rows[0]["M"])
    (('emps', 24841), 95)
    """
    settings, files = settings or BatchSettings(), result_files(output)  # the Parquet file first
    names = log_files(logs, exclude=files)
    of_logs = known_of_logs(known, names)
    if known and settings.joint:
        raise SettingError("known values of each log do not go with `joint`: leave one of them out")
    chosen = fleet_axes(axes, settings, of_logs[0])
    run = scheduler_of(jobs, scheduler, len(names), settings.seconds)
    with locked(files):
        return _identified(chosen, dict(zip(names, of_logs, strict=True)), files, run, track)


def _identified(
    chosen: tuple[FleetAxis, ...],
    names: Mapping[str, Mapping[str, float]],
    files: tuple[Path, ...],
    run: Scheduler,
    track: Track,
) -> Batch:
    """The batch of logs by name, each with the values known of it alone, while its files are locked."""
    journal = journal_file(files[0]) if files else None
    # All files are read, so that a file with other contents is refused before anything is computed.
    table, *_ = [read_rows(file) for file in files] or [[]]
    earlier = _by_key([*table, *(read_journal(journal) if journal else ())])
    tasks = [
        Task(name, os.path.abspath(name), tuple(earlier.get(visible(name), ())), known)
        for name, known in names.items()
    ]
    rows: dict[str, ResultRow] = {}
    made = 0
    try:
        with ExitStack() as opened:
            book = opened.enter_context(Journal(journal)) if journal else None
            finished = opened.enter_context(closing(run.run(partial(work, chosen), tasks)))
            for task, outcome in track(finished, len(tasks)):
                result = outcome or killed(task)
                if result.row is None:  # log, axis and settings are unchanged
                    rows[task.log] = earlier[visible(task.log)][str(result.unchanged)]
                    continue
                if book:
                    book.append(result.row)
                rows[task.log] = result.row
                made += 1
    except KeyboardInterrupt as stop:
        raise Interrupted(len(rows), journal) from stop
    except SymidError as error:
        raise SymidError(f"{error}; {_words_on_rows(len(rows), journal)}") from error
    ordered = tuple(rows[name] for name in names)
    units = units_of(ordered, chosen)
    dropped = {str(row["log"]) for row in table}.difference(map(visible, names))
    replaced = _former_kept(files, dropped)
    diagnosed = any(axis.settings.diagnose for axis in chosen)
    joint = any(axis.settings.joint for axis in chosen)
    batch = Batch(ordered, units, diagnosed, joint, len(names) - made, files, replaced)
    try:
        for file in files:
            write_table(batch.table, units, file)
    except SymidError as error:
        raise SymidError(f"{error}; {_words_on_rows(len(ordered), journal)}") from error
    if journal:
        journal.unlink(missing_ok=True)
    return batch


def _by_key(rows: Iterable[ResultRow]) -> dict[str, dict[str, ResultRow]]:
    """Finished rows by log and key; a row is reused if the key is unchanged."""
    by_key: dict[str, dict[str, ResultRow]] = defaultdict(dict)
    for row in rows:
        if row.get("key") and row.get("status"):
            by_key[str(row["log"])][str(row["key"])] = row
    return by_key


def _words_on_rows(rows: int, journal: Path | None) -> str:
    if journal is None:
        return f"{rows} rows were finished and are lost: give an output file"
    kept = len(read_journal(journal))  # an interrupt may fall between the writing of a row and its counting
    return f"{kept} finished rows are kept in {journal}: run the same command again to do the rest"


def _former_kept(files: Sequence[Path], dropped: set[str]) -> Path | None:
    """A copy of the former table, if it holds logs that are not in the new one."""
    if not dropped:
        return None
    place = free_name(files[0], _BEFORE)
    try:
        with replacing(place) as kept:
            shutil.copy2(files[0], kept)
    except OSError as error:
        raise SymidError(f"{place}: cannot be written ({error.strerror}); {files[0]} is as it was") from error
    return place
