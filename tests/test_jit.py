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
CALLING = """
from called import scaled
from symid.jit import jitted

@jitted
def moved(x):
    return scaled(x)

print(moved(3))
"""
CALLED = """
from symid.jit import jitted

@jitted
def scaled(x):
    return {factor} * x
"""


def test_code_is_compiled_again_when_its_record_is_gone_and_when_what_it_calls_has_changed(
    tmp_path: Path,
) -> None:
    (tmp_path / "calling.py").write_text(CALLING, encoding="utf-8")
    # Sources of two lengths: Python itself takes one of the same length and second for unchanged.
    for record, more, factor, printed in (("Old", "", 2, "3.0\n6\n"), ("New", "+ 1.0", 15, "4.0\n45\n")):
        (tmp_path / "loop.py").write_text(LOOP.format(record=record, more=more), encoding="utf-8")
        (tmp_path / "called.py").write_text(CALLED.format(factor=factor), encoding="utf-8")
        command = [sys.executable, "-c", "import loop, calling"]
        run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
        assert run.stdout == printed
        assert len(list((tmp_path / "__pycache__").glob("*.nbi"))) >= 3
