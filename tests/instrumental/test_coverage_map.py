"""The quick part of benchmarks/coverage_map.py."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

PATH = Path(__file__).parents[2] / "benchmarks" / "coverage_map.py"


@pytest.fixture(scope="module")
def coverage_map() -> ModuleType:
    spec = importlib.util.spec_from_file_location("coverage_map", PATH)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["coverage_map"] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


def test_intervals_cover_or_the_record_says_that_bias_dominates(
    coverage_map: ModuleType, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = [coverage_map.measured_row(case, 25) for case in coverage_map.cases(quick=True)]
    for row in rows:
        assert np.all((row.corrected >= 0.8) | (row.stated > 0.5))
        assert not np.any(row.is_biased & (row.stated < 0.5))
        assert row.false_alarms == 0.0
    assert rows[1].stated.max() == 1.0
    coverage_map.print_map(rows)
    assert "says nothing" in capsys.readouterr().out


def test_a_moved_force_is_seen_and_its_remedy_restores_the_coverage(coverage_map: ModuleType) -> None:
    (case,) = coverage_map.timing_cases(quick=True)
    seen, errors, before, after, _ = coverage_map.timing_row(case, 15)
    assert seen == 1.0
    assert np.abs(errors).max() < 0.5
    assert before.min() < 0.6
    assert after.min() >= 0.75
