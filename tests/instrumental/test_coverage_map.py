"""The quick part of benchmarks/coverage_map.py."""

import numpy as np
import pytest

from benchmarks import coverage_map


def test_intervals_cover_or_the_record_says_that_bias_dominates(capsys: pytest.CaptureFixture[str]) -> None:
    rows = [coverage_map.measured_row(case, 25) for case in coverage_map.cases(quick=True)]
    for row in rows:
        assert np.all((row.corrected >= 0.8) | (row.stated > 0.5))
        assert not np.any(row.is_biased & (row.stated < 0.5))
        assert row.false_alarms == 0.0
    assert rows[1].stated.max() == 1.0
    coverage_map.print_map(rows)
    assert "says nothing" in capsys.readouterr().out


def test_a_moved_force_is_seen_and_its_remedy_restores_the_coverage() -> None:
    (case,) = coverage_map.timing_cases(quick=True)
    seen, errors, before, after, _ = coverage_map.timing_row(case, 15)
    assert seen == 1.0
    assert np.abs(errors).max() < 0.5
    assert before.min() < 0.6
    assert after.min() >= 0.75
