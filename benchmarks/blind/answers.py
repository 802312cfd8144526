"""The diagnosis of each case as a process of its own, in a folder with the two logs and the nominal values only."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

LOGS = ("identification.parquet", "validation.parquet")
COMMAND = (sys.executable, "-c", "from symid.cli import main; main()", "diagnose")


def diagnose(case: Path, timeout: float, command: tuple[str, ...] = COMMAND) -> dict[str, Any]:
    """What the process answered, how it ended and the seconds that it took; a crash is an answer too."""
    record = json.loads((case / "case.json").read_text())
    with tempfile.TemporaryDirectory() as place:
        for log in LOGS:
            shutil.copy(case / log, place)
        (Path(place) / "nominal.json").write_text(json.dumps(record["nominal"]))
        options = ["--validation", LOGS[1], "--nominal", "nominal.json", "--json", "-"]
        start = time.perf_counter()
        try:
            done = subprocess.run(
                [*command, record["model"], LOGS[0], *options],
                cwd=place,
                check=False,
                capture_output=True,
                text=True,
                timeout=timeout,
            )
        except subprocess.TimeoutExpired:
            return {"answer": None, "ended": f"stopped after {timeout:g} s", "seconds": timeout}
        seconds = time.perf_counter() - start
    try:
        answer = json.loads(done.stdout) if done.returncode == 0 else None
    except json.JSONDecodeError:
        answer = None
    ended = f"exit {done.returncode} {' '.join(done.stderr.split()[-40:])}".strip()
    return {"answer": answer, "ended": ended, "seconds": seconds}


def diagnose_set(
    folder: Path, jobs: int, timeout: float, command: tuple[str, ...] = COMMAND
) -> list[dict[str, Any]]:
    """Answers of all cases, written to `answers/` as they come."""
    cases = sorted(path for path in folder.glob("case*") if path.is_dir())
    target = folder / "answers"
    target.mkdir(exist_ok=True)

    def one(case: Path) -> dict[str, Any]:
        found = {"case": case.name} | diagnose(case, timeout, command)
        (target / f"{case.name}.json").write_text(json.dumps(found, indent=1))
        return found

    with ThreadPoolExecutor(jobs) as pool:
        return list(pool.map(one, cases))


def read(folder: Path) -> dict[str, dict[str, Any]]:
    """Answers of a folder by the name of the case."""
    return {
        path.stem: json.loads(path.read_text()) for path in sorted((folder / "answers").glob("case*.json"))
    }
