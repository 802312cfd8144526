"""A folder of good files, and what becomes of it and of the command when something is strange."""

from __future__ import annotations

import contextlib
import io
import json
import os
import shutil
import tempfile
import traceback
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars as pl

from benchmarks.bad.cases import Case
from benchmarks.patience import Hangs, limited
from symid.cli import main

PATIENCE = 60
AXIS = """from symid import Axis, Body, Drive, Position, ViscousFriction
body = Body("body", mass="M")
axis = Axis("own_axis", (body, ViscousFriction(body, "Fv")), Drive("F", body), (Position("q", body),))
"""


@dataclass(frozen=True)
class Outcome:
    """What became of a case: "done", "refused", or what must not be."""

    verdict: str
    detail: str

    @property
    def is_failure(self) -> bool:
        """Whether this must not be."""
        return self.verdict not in ("done", "refused")


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
    return {name: (folder / name).read_text(encoding="utf-8") for name in ("P.json", "R.json", "M.json")}


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
            if not (folder / name).is_file() or (folder / name).read_bytes() != content:
                return Outcome("lost", name)
        strange = [path.name for path in Path(place).rglob("*") if path.name.startswith(".symid-")]
        named = "../x" in case.arguments[1:] and case.arguments[0] != "new"  # an output that was asked for
        outside = [path.name for path in Path(place).iterdir() if path.name != "work" and not named]
        return Outcome("left behind", f"{strange} {outside}") if strange or outside else found


def outcome_of(case: Case, folder: Path) -> Outcome:
    """Run a command in a folder, in this process."""
    out, err = io.StringIO(), io.StringIO()
    code: object = None
    with contextlib.chdir(folder), warnings.catch_warnings(record=True) as warned, limited(PATIENCE):
        warnings.simplefilter("always")
        os.environ["SYMID_TRACE"] = "1"
        try:
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                main(list(case.arguments))
        except SystemExit as stop:
            code = stop.code
        except Hangs:
            return Outcome("hang", f"more than {PATIENCE} s")
        except KeyboardInterrupt:
            raise
        except BaseException:  # noqa: BLE001  # whatever comes through is what is looked for
            return Outcome("traceback", traceback.format_exc())
        finally:
            del os.environ["SYMID_TRACE"]
    if warned:
        return Outcome("warning", f"{warned[0].message} in {warned[0].filename}:{warned[0].lineno}")
    if "\x1b" in out.getvalue() + err.getvalue():
        return Outcome("escape", out.getvalue() + err.getvalue())
    if code in (0, None, 1):
        return Outcome("done", out.getvalue())
    lines = err.getvalue().splitlines()
    fine = code == 2 and len(lines) >= 1 and lines[-1].startswith("symid: ")
    return Outcome("refused" if fine else "several lines", f"exit code {code}: {err.getvalue()}")
