"""A folder of good files, and what becomes of it and of the command when something is strange."""

import contextlib
import json
import os
import shutil
import tempfile
from pathlib import Path

import numpy as np
import polars as pl

from benchmarks.bad.cases import Case
from benchmarks.commands import Outcome, run_command

OWN = {("identify", "R.json"), ("import", "M.json")}
"""Results of a command that it may replace by new ones where it is told to."""
AXIS = """from symid import Axis, Body, Drive, Position, ViscousFriction
body = Body("body", mass="M")
axis = Axis("own_axis", (body, ViscousFriction(body, "Fv")), Drive("F", body), (Position("q", body),))
"""


def good_folder(folder: Path) -> dict[str, str]:
    """Fill a folder with files that work; gives the texts of its JSON files."""
    t = np.arange(2000) / 500
    q, v, a = np.zeros((3, t.size))
    for size, w in ((0.1, 9.0), (0.02, 31.0)):
        q, v, a = q + size * np.sin(w * t), v + size * w * np.cos(w * t), a - size * w**2 * np.sin(w * t)
    force = 5 * a + 3 * v + 2 * np.sign(v) + 0.05 * np.random.default_rng(1).standard_normal(t.size)
    pl.DataFrame({"t": t, "q": q, "F": force}).write_csv(folder / "run.csv")
    pl.DataFrame({"Time (ms)": 1e3 * t, "Pos [mm]": 1e3 * q, "Force [N]": force}).write_csv(
        folder / "foreign.csv"
    )
    (folder / "P.json").write_text(json.dumps({"M": 5.0, "Fv": 3.0, "Fs": 2.0}), encoding="utf-8")
    (folder / "Q.json").write_text(json.dumps({"M": [5.0, 0.1], "Fv": [3.0, 1.0]}), encoding="utf-8")
    (folder / "own_axis.py").write_text(AXIS, encoding="utf-8")
    (folder / "out").mkdir()
    os.mkfifo(folder / "pipe")
    for command in (
        "identify rigid_1m run.csv --json R.json",
        "import foreign.csv --axis rigid_1m -o M.json",
        "batch rigid_1m run.csv foreign.csv -o results.parquet --jobs 1 --joint",
    ):
        verdict = outcome_of(Case(tuple(command.split())), folder)
        assert verdict.verdict == "done", verdict
    return {
        name: (folder / name).read_text(encoding="utf-8") for name in ("P.json", "Q.json", "R.json", "M.json")
    }


def outcome_in_a_copy(case: Case, good: Path) -> Outcome:
    """Change a copy of a good folder, run the command there, and look at what it left."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "work"
        shutil.copytree(good, folder, ignore=shutil.ignore_patterns("pipe"))
        os.mkfifo(folder / "pipe")
        with contextlib.suppress(OSError, ValueError):
            case.prepare(folder)
        before = {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}
        found = outcome_of(case, folder)
        if found.is_failure:
            return found
        for name, content in before.items():
            if (case.arguments[0], name) in OWN and name in case.arguments:
                continue
            if not (folder / name).is_file() or (folder / name).read_bytes() != content:
                return Outcome("lost", name)
        strange = [path.name for path in Path(place).rglob("*") if path.name.startswith(".symid-")]
        named = "../x" in case.arguments[1:] and case.arguments[0] != "new"  # an output that was asked for
        outside = [path.name for path in Path(place).iterdir() if path.name != "work" and not named]
        return Outcome("left behind", f"{strange} {outside}") if strange or outside else found


def outcome_of(case: Case, folder: Path) -> Outcome:
    """Run a command in a folder, in this process."""
    with contextlib.chdir(folder):
        os.environ["SYMID_TRACE"] = "1"
        try:
            ended = run_command(case.arguments)
        finally:
            del os.environ["SYMID_TRACE"]
    if isinstance(ended, Outcome):
        return ended
    if "\x1b" in ended.out + ended.err:
        return Outcome("escape", ended.out + ended.err)
    if ended.code in (0, None, 1):
        return Outcome("done", ended.out)
    lines = ended.err.splitlines()
    fine = ended.code == 2 and len(lines) >= 1 and lines[-1].startswith("symid: ")
    return Outcome("refused" if fine else "several lines", f"exit code {ended.code}: {ended.err}")
