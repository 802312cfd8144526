"""The diagnosis of each case in a separate process, in a folder with the two logs and the nominal values only."""

import json
import math
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import IO, Any

LOGS = ("identification.parquet", "validation.parquet")
COMMAND = (sys.executable, "-c", "from symid.cli import main; main()", "diagnose")
_WAITS = 10.0
"""By the clock a case may take this many times its processor time."""
_KILOBYTES = 1024.0
"""Linux gives the peak of the memory in kilobytes."""


def diagnose(
    case: Path, timeout: float, command: tuple[str, ...] = COMMAND, tree: Path | None = None
) -> dict[str, Any]:
    """What the process answered, how it ended, its processor time in s and its peak of memory in MB.

    A crash is an answer too. The code is that of another checkout, `tree`, if one is given.
    """
    record = json.loads((case / "case.json").read_text())
    with tempfile.TemporaryDirectory() as place:
        for log in LOGS:
            shutil.copy(case / log, place)
        (Path(place) / "nominal.json").write_text(json.dumps(record["nominal"]))
        options = ["--validation", LOGS[1], "--nominal", "nominal.json", "--json", "-"]
        return _ran([*command, record["model"], LOGS[0], *options], Path(place), timeout, tree)


def _ran(command: Sequence[str], place: Path, timeout: float, tree: Path | None) -> dict[str, Any]:
    """Run a command in a folder; its bytecode is kept, as that of an installation is."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    if tree is not None:
        environment["PYTHONPATH"] = str(tree.resolve())
    # files hold any length, outside the folder
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = subprocess.Popen(command, cwd=place, stdout=out, stderr=err, env=environment)
        # Processor time, as the clock runs on while other processes work; the clock ends a process that waits.
        most = math.ceil(timeout)
        resource.prlimit(process.pid, resource.RLIMIT_CPU, (most, most + 1))
        stop = threading.Timer(_WAITS * timeout, process.kill)
        stop.start()
        _, status, usage = os.wait4(process.pid, 0)
        said, complaint = (_text_of(file) for file in (out, err))
    waited = not stop.is_alive()
    stop.cancel()
    process.returncode = code = os.waitstatus_to_exitcode(status)
    cost = {"seconds": usage.ru_utime + usage.ru_stime, "peak_mb": usage.ru_maxrss / _KILOBYTES}
    if waited or code == -signal.SIGXCPU:
        limit = f"{_WAITS * timeout:g} s" if waited else f"{timeout:g} s of processor time"
        return {"answer": None, "ended": f"stopped after {limit}"} | cost
    try:
        answer = json.loads(said) if code == 0 else None
    except json.JSONDecodeError:
        answer = None
    ended = f"exit {code} {' '.join(complaint.split()[-40:])}".strip()
    return {"answer": answer, "ended": ended} | cost


def _text_of(file: IO[bytes]) -> str:
    file.seek(0)
    return file.read().decode()


def diagnose_set(
    folder: Path, jobs: int, timeout: float, command: tuple[str, ...] = COMMAND
) -> list[dict[str, Any]]:
    """Answers of all cases, written to `answers/` as they come."""
    target = folder / "answers"
    target.mkdir(exist_ok=True)

    def one(case: Path) -> dict[str, Any]:
        found = {"case": case.name} | diagnose(case, timeout, command)
        (target / f"{case.name}.json").write_text(json.dumps(found, indent=1))
        return found

    with ThreadPoolExecutor(jobs) as pool:
        return list(pool.map(one, cases_of(folder)))


def cases_of(folder: Path) -> list[Path]:
    return sorted(path for path in folder.glob("case*") if path.is_dir())


def read(folder: Path) -> dict[str, dict[str, Any]]:
    """Answers of a folder by the name of the case."""
    return {
        path.stem: json.loads(path.read_text()) for path in sorted((folder / "answers").glob("case*.json"))
    }


def difference(one: Any, other: Any) -> float:
    """Largest relative difference of the numbers of two answers; infinite if anything else differs.

    >>> difference({"a": [1.0, "x"]}, {"a": [2.0, "x"]}), difference(["x"], ["y"])
    (0.5, inf)
    """
    differing = [(a, b) for a, b in _pairs(one, other) if a != b]
    if not all(isinstance(x, int | float) for pair in differing for x in pair):
        return math.inf
    return max((abs(a - b) / max(abs(a), abs(b)) for a, b in differing), default=0.0)


def _pairs(one: Any, other: Any) -> Iterator[tuple[Any, Any]]:
    """Leaves of two answers at the same places; what has no partner stands beside None."""
    if isinstance(one, dict) and isinstance(other, dict):
        for key in one | other:
            yield from _pairs(one.get(key), other.get(key))
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for a, b in zip(one, other, strict=True):
            yield from _pairs(a, b)
    else:
        yield one, other
