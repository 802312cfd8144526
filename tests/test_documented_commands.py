"""The commands of README and docs run, one after the other, in a folder that holds the files they name."""

import contextlib
import io
import json
import re
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from command_line import follows, run
from fleet_logs import write_log

import symid

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
SPEC = spec_from_file_location("foreign_log", ROOT / "examples" / "foreign_log.py")
assert SPEC is not None
assert SPEC.loader is not None
foreign_log = module_from_spec(SPEC)
SPEC.loader.exec_module(foreign_log)
CHANGING = ("diagnose", "generate")
"""Commands whose figures the benchmarks measure, and one before which a page changes a file by hand."""
LONG = ("docs/diagnosis.md", "docs/output_error.md", "docs/tuning.md")
"""Pages whose commands take a minute or many; what they do is tested with the diagnosis, output error and tuning."""
ELSEWHERE = ("--scheduler tcp://10.0.0.1", "diagnose emps", "identify current.py")
"""Commands that need more than a folder, or minutes: the Python code of their pages does the same."""
PAPER = {"Ms": 3899.0, "Fvs": 3949.17, "Ks": 1e9, "Mm": 362.58, "Fvm": 88.6, "Fsm": 146.0}
RIGID = {"M": 100.0, "Fv": 80.0, "Fs": 40.0}


@dataclass(frozen=True)
class Command:
    """A command of a page, and what the page says it prints; None where it says nothing."""

    text: str
    printed: str | None

    @property
    def arguments(self) -> list[str]:
        return shlex.split(self.text.partition("      #")[0])[1:]


def commands_of(page: Path) -> list[Command]:
    """Commands in the indented blocks of a page: lines that begin with symid, or with $ and then their output."""
    text = re.sub(r"\\\n +", "", page.read_text(encoding="utf-8"))
    text = re.sub(r"```.*?```", "", text, flags=re.DOTALL)
    found: list[Command] = []
    for block in re.findall(r"(?:^ {4}.*\n|^\n(?= {4}))+", text, re.MULTILINE):
        lines = [line[4:].rstrip() for line in block.splitlines()]
        for place, line in enumerate(lines):
            if line.startswith("symid "):
                found.append(Command(line, None))
            elif line.startswith("$ symid "):
                rest = lines[place + 1 :]
                until = next((i for i, other in enumerate(rest) if other.startswith("$ ")), len(rest))
                found.append(Command(line[2:], "\n".join(rest[:until])))
    return [command for command in found if not any(words in command.text for words in ELSEWHERE)]


def with_stribeck() -> pl.DataFrame:
    """A rigid axis by hand whose friction falls with speed, which no file of symid declares."""
    t = np.arange(8000) / 1000
    q = 0.1 * np.sin(2 * t) + 0.01 * np.sin(11 * t)
    v, a = 0.2 * np.cos(2 * t) + 0.11 * np.cos(11 * t), -0.4 * np.sin(2 * t) - 1.21 * np.sin(11 * t)
    friction = np.sign(v) * (40.0 + 30.0 * np.exp(-((v / 0.03) ** 2)))
    noise = np.random.default_rng(0).standard_normal(t.size)
    return pl.DataFrame({"t": t, "q": q, "F": 100.0 * a + 80.0 * v + friction + noise})


def foreign_logs(folder: Path) -> None:
    log = foreign_log.recorded()
    foreign_log.write_matlab(log, folder / "run.mat")
    foreign_log.write_csv(log, folder / "run.csv")
    foreign_log.write_trace(log, folder / "trace.csv")
    pl.DataFrame({"t [s]": log.time, "q [m]": log["q"]}).write_csv(folder / "drive.csv")
    pl.DataFrame({"t [s]": log.time, "F [N]": log["F"]})[::2].write_csv(folder / "scope.csv")


def emps_logs(folder: Path) -> None:
    (folder / "logs").mkdir()
    for name in ("DATA_EMPS.mat", "DATA_EMPS_PULSES.mat"):
        (folder / "logs" / name).symlink_to(ROOT / "data" / "emps" / name)


def results(folder: Path) -> None:
    (folder / "rows").mkdir()
    for seed in range(4):
        write_log(folder / "rows" / f"{seed}.parquet", seed)
    settings = symid.BatchSettings(joint=True)
    symid.identify_batch(
        "rigid_1m", folder / "rows", output=folder / "results.parquet", settings=settings, jobs=1
    )


def night(folder: Path) -> None:
    log = symid.read_axis_log("emps", ROOT / "data" / "emps" / "DATA_EMPS.mat", columns={"q": "qm"})
    pl.DataFrame({"t": log.time, **dict(log.signals)}).write_parquet(folder / "night.parquet")


FILES: dict[str, Callable[[Path], None]] = {
    "README.md": lambda folder: None,
    "docs/batch.md": emps_logs,
    "docs/export.md": lambda folder: with_stribeck().write_csv(folder / "run.csv"),
    "docs/fleet.md": results,
    "docs/how_to/excitation.md": lambda folder: None,
    "docs/how_to/extend.md": lambda folder: None,
    "docs/how_to/foreign_log.md": foreign_logs,
    "docs/identification.md": lambda folder: None,
    "docs/long_logs.md": night,
    "docs/simulation.md": lambda folder: None,
}
"""What each page that has commands takes as given."""


@pytest.mark.parametrize("page", FILES)
def test_commands_of_a_page_run(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SYMID_TRACE", "1")
    Path("data").symlink_to(ROOT / "data")
    Path("P.json").write_text(json.dumps({**PAPER, **RIGID}), encoding="utf-8")
    FILES[page](tmp_path)
    for command in commands_of(ROOT / page):
        message = io.StringIO()
        with contextlib.redirect_stdout(message), contextlib.redirect_stderr(message):
            code = run(*command.arguments)
        stale = "--check" in command.arguments  # a page shows what is found then
        assert code == int(stale), f"{command.text}: {message.getvalue()}"
        if command.printed is not None and command.arguments[0] not in CHANGING:
            assert follows(message.getvalue(), command.printed), f"{command.text} prints {message.getvalue()}"


def test_every_page_with_commands_is_run() -> None:
    assert {str(page.relative_to(ROOT)) for page in PAGES if commands_of(page)} == {*FILES, *LONG}


def test_what_a_page_prints_is_compared() -> None:
    assert follows("a\n  b  c\nlast", "a b\nc\n...")
    assert follows("one two 3", "one\n...\n3")
    assert not follows("one two 4", "one\n...\n3")
    assert follows("K  9.9898e+08 of 3 in 0.12 s", "K 9.98982e+08 of 3 in 0.11 s")
    assert not follows("K 9.96e+08", "K 9.98982e+08")
    assert not follows("of 4", "of 3")
