"""Machine code that numba keeps on disk, over a change of the code that it was compiled for."""

import subprocess
import sys
from pathlib import Path

LOOP = """
from typing import NamedTuple
from symid.jit import jitted

class {record}(NamedTuple):
    values: tuple

@jitted
def total(record):
    return sum(record.values) {more}

print(total({record}((1.0, 2.0))))
"""


def run(folder: Path, record: str, more: str = "") -> str:
    """What a module with a loop for a record prints."""
    (folder / "loop.py").write_text(LOOP.format(record=record, more=more), encoding="utf-8")
    command = [sys.executable, "-c", "import loop"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout


def test_code_kept_for_a_record_that_is_gone_is_compiled_again(tmp_path: Path) -> None:
    assert run(tmp_path, "Old") == "3.0\n"
    assert list((tmp_path / "__pycache__").glob("*.nbi"))
    assert run(tmp_path, "New", "+ 1.0") == "4.0\n"


def test_code_is_compiled_again_when_what_it_calls_has_changed(tmp_path: Path) -> None:
    module = "{imported}\nfrom symid.jit import jitted\n\n@jitted\ndef {name}(x):\n    return {value}\n"
    calling = module.format(imported="from called import scaled", name="moved", value="scaled(x)")
    (tmp_path / "calling.py").write_text(calling, encoding="utf-8")
    command = [sys.executable, "-c", "import calling; print(calling.moved(3))"]
    # Sources of two lengths: Python itself takes one of the same length and second for unchanged.
    for factor, expected in ((2, "6\n"), (15, "45\n")):
        called = module.format(imported="", name="scaled", value=f"{factor} * x")
        (tmp_path / "called.py").write_text(called, encoding="utf-8")
        assert (
            subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
            == expected
        )
