"""The benchmark compares the same job: its script finds what a batch finds."""

import runpy
from pathlib import Path
from typing import Any

import pytest

import symid

BENCHMARK: dict[str, Any] = runpy.run_path(str(Path(__file__).parents[2] / "benchmarks" / "batch.py"))


def test_script_of_the_benchmark_finds_the_parameters_of_a_batch(tmp_path: Path) -> None:
    (path,) = BENCHMARK["write_logs"](tmp_path, 1, 20_000)
    BENCHMARK["batch"]([path], jobs=1)
    (row,) = symid.identify_batch("emps", path, jobs=1).rows
    found: list[Any] = []
    BENCHMARK["plain"]([path], lambda log, s: found.append(BENCHMARK["run_script"]("emps", log, s)))
    wanted = [row[name] for name in ("M", "Fv", "Fc", "OF")]  # the script keeps rows at standstill
    assert found[0]["parameters"][:3] == pytest.approx(wanted[:3], rel=0.03)
    assert found[0]["parameters"][3] == pytest.approx(wanted[3], rel=0.1)
