"""A batch that is stopped, killed or out of disk loses nothing and does nothing twice."""

import contextlib
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import polars as pl
import pytest
from command_line import run
from fleet_logs import write_log

import symid
from symid.fleet import BatchSettings, Interrupted, identify_batch
from symid.fleet.journal import Journal, journal_file, read_journal

RESULTS = Path("r.parquet")
JOURNAL = journal_file(RESULTS)
LONGEST = 60.0
MANY, BEFORE = 16, 10


def batch(logs: Path, **settings: Any) -> Any:
    return identify_batch("rigid_1m", logs, output=RESULTS, jobs=1, settings=BatchSettings(**settings))


def finished(logs: Path | str = RESULTS) -> dict[str, str]:
    """When each log of the results was finished; fails if a log is there twice."""
    table = pl.read_parquet(logs)
    assert table["log"].n_unique() == table.height
    return dict(table.select("log", "finished").iter_rows())


def test_only_what_changed_is_done_again(logs: Path) -> None:
    first = batch(logs)
    assert (first.reused, JOURNAL.exists()) == (0, False)
    before = finished()
    again = batch(logs)
    assert again.reused == 6
    assert again.table.equals(first.table)

    write_log(logs / "2.parquet", 77, mass=6.0)
    write_log(logs / "new.csv", 78)
    os.utime(logs / "3.parquet")  # touched, not changed
    third = batch(logs)
    assert third.reused == 5
    after = finished()
    assert [name for name, when in after.items() if when != before.get(name)] == [
        "logs/2.parquet",
        "logs/new.csv",
    ]
    assert pl.read_parquet(RESULTS).filter(pl.col("log") == "logs/2.parquet")["M"].item() == pytest.approx(
        6, rel=0.01
    )

    assert batch(logs, preparation=symid.Preparation(cutoff_hz=8.0)).reused == 0
    assert batch(logs, preparation=symid.Preparation(cutoff_hz=8.0)).reused == 7


def test_another_version_or_declaration_does_all_again(logs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    batch(logs)
    monkeypatch.setattr(symid, "__version__", "999")
    assert batch(logs).reused == 0
    noisy = symid.load_axis("rigid_1m").with_signal("q", noise=1e-6)
    other = identify_batch(noisy, logs, output=RESULTS, jobs=1)
    assert other.reused == 0


def test_former_logs_are_kept_beside_the_results(logs: Path) -> None:
    batch(logs)
    before = RESULTS.read_bytes()
    fewer = batch(logs / "1.parquet")
    assert fewer.replaced == Path("r.parquet.before")
    assert fewer.replaced.read_bytes() == before
    assert list(finished()) == ["logs/1.parquet"]
    assert batch(logs).replaced is None


def interrupt_after(rows: int) -> Any:
    def track(items: Iterable[Any], total: int) -> Iterator[Any]:
        for place, item in enumerate(items):
            if place == rows:
                raise KeyboardInterrupt
            yield item

    return track


def test_an_interrupted_batch_continues(logs: Path) -> None:
    with pytest.raises(Interrupted, match=r"4 finished rows are kept in r.parquet.journal"):
        identify_batch("rigid_1m", logs, output=RESULTS, jobs=1, track=interrupt_after(4))
    kept = {str(row["log"]): row["finished"] for row in read_journal(JOURNAL)}
    assert len(kept) == 4
    assert batch(logs).reused == 4
    assert kept.items() < finished().items()
    assert not JOURNAL.exists()


def test_a_torn_line_is_done_again_and_ends_before_the_next(logs: Path) -> None:
    with pytest.raises(Interrupted):
        identify_batch("rigid_1m", logs, output=RESULTS, jobs=1, track=interrupt_after(3))
    whole = JOURNAL.read_bytes()
    JOURNAL.write_bytes(whole[:-40])
    with pytest.raises(Interrupted):
        identify_batch("rigid_1m", logs, output=RESULTS, jobs=1, track=interrupt_after(5))
    assert len({row["log"] for row in read_journal(JOURNAL)}) == 5
    assert batch(logs).reused == 5
    assert len(finished()) == 6


COMMAND = [
    sys.executable,
    "-c",
    "from symid.cli import main; main()",
    "batch",
    "rigid_1m",
    "logs",
    "-o",
    "r.parquet",
]


WAITING = f"""
import time
from symid.cli import main
from symid.fleet.journal import Journal

append, rows = Journal.append, []

def append_and_wait(self, row):
    append(self, row)
    rows.append(row)
    if len(rows) == {BEFORE}:
        time.sleep({LONGEST})

Journal.append = append_and_wait
main()
"""


def started(jobs: int) -> subprocess.Popen[str]:
    """A batch in a session of its own that has finished rows, and waits before the others."""
    process = subprocess.Popen(
        [sys.executable, "-c", WAITING, *COMMAND[3:], "--jobs", str(jobs)],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    end = time.monotonic() + LONGEST
    while not (JOURNAL.exists() and JOURNAL.read_bytes().count(b"\n") >= BEFORE):
        if time.monotonic() > end or process.poll() is not None:
            os.killpg(process.pid, signal.SIGKILL)
            raise AssertionError(f"no {BEFORE} rows: {process.communicate()}")
        time.sleep(0.005)
    return process


@pytest.fixture
def many(logs: Path) -> Path:
    """So many logs that a batch can be met in the middle of them."""
    for place in range(6, MANY):
        shutil.copy(logs / f"{place % 6}.parquet", logs / f"{place}.parquet")
    return logs


@pytest.mark.parametrize(("blow", "jobs"), [(signal.SIGINT, 1), (signal.SIGKILL, 2)])
def test_a_batch_that_is_stopped_from_outside_loses_nothing(
    many: Path, blow: signal.Signals, jobs: int
) -> None:
    process = started(jobs)
    try:
        (os.killpg if blow == signal.SIGINT else os.kill)(process.pid, blow)  # Ctrl-C reaches the workers too
        error = process.communicate(timeout=LONGEST)[1]  # ends when its workers have ended too
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    kept = {str(row["log"]): row["finished"] for row in read_journal(JOURNAL)}
    assert BEFORE <= len(kept) < MANY
    assert not RESULTS.exists()
    if blow == signal.SIGINT:
        assert process.returncode == 130
        assert error.count("\n") == 1
        assert f"{len(kept)} finished rows are kept" in error
    assert run("batch", "rigid_1m", "logs", "-o", "r.parquet", "--jobs", "1") == 0
    after = finished()
    assert len(after) == MANY
    assert kept.items() <= after.items()


def test_a_full_disk_is_one_line_and_keeps_what_is_finished(logs: Path) -> None:
    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000))

    full = subprocess.run(
        [*COMMAND, "--jobs", "1"],
        preexec_fn=limit,
        capture_output=True,
        text=True,
        timeout=LONGEST,
        check=False,
    )
    assert full.returncode == 2
    assert full.stderr.count("\n") == 1
    rows = len(read_journal(JOURNAL))
    assert 0 < rows < 6
    assert f"cannot be written (File too large); {rows} finished rows are kept" in full.stderr
    assert JOURNAL.read_bytes().endswith(b"\n")
    assert batch(logs).reused == rows


def test_a_table_that_cannot_be_written_keeps_the_journal(
    logs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as broken:
        broken.setattr(pl.DataFrame, "write_parquet", full)
        with pytest.raises(symid.SymidError, match=r"No space left on device\); 6 finished rows are kept"):
            batch(logs)
    assert [path.name for path in sorted(Path().glob("r.*"))] == ["r.parquet.journal"]
    assert batch(logs).reused == 6


def test_a_journal_on_a_full_device_says_so(tmp_path: Path) -> None:
    full = tmp_path / "r.journal"
    full.symlink_to("/dev/full")
    with Journal(full) as journal, pytest.raises(symid.SymidError, match="No space left"):
        journal.append({"log": "a"})


def test_rows_survive_the_journal_unchanged(tmp_path: Path) -> None:
    row = {"log": 'é,\n"x".csv', "M": 0.1 + 0.2, "samples": 3, "status": "ok", "message": None}
    with Journal(tmp_path / "j") as journal:
        journal.append(row)
    assert read_journal(tmp_path / "j") == [row]
    assert json.loads((tmp_path / "j").read_text()) == row
