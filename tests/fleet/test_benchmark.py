"""Quick parts of the benchmarks of batches, spreads and charts."""

from pathlib import Path

import pytest

import symid
from benchmarks import batch as batches, fleet_charts as charts


def test_script_of_the_benchmark_finds_the_parameters_of_a_batch(tmp_path: Path) -> None:
    (path,) = batches.write_logs(tmp_path, 1, 20_000)
    batches.batch([path], jobs=1)
    alike = symid.Preparation(widening=1.0)  # as the script filters laws
    row = symid.identify("emps", path, preparation=alike, examine=False).minimal_parameters
    (found,) = batches.plain([path], "script", batches.chosen(path))
    # the script keeps rows at standstill, and those that the start of its filter spoils
    wanted = list(row.values())
    assert found["parameters"][:3] == pytest.approx(wanted[:3], rel=0.05)
    assert found["parameters"][3] == pytest.approx(wanted[3], rel=0.1)


def test_a_few_draws_of_each_kind() -> None:
    assert charts.false_differences(20, 20) <= 0.1
    assert charts.false_changes(20, 3.0, 20) <= 0.2
    for kind in ("step", "drift"):
        found = charts.detection(kind, 40, 6.0, 10)
        assert found.found >= 0.8
        assert found.sized >= 0.7
