"""The quick part of the benchmark of spreads and charts."""

import importlib.util
import sys
from pathlib import Path


def benchmark(name: str):
    path = Path(__file__).parents[2] / "benchmarks" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def test_a_few_draws_of_each_kind() -> None:
    charts = benchmark("fleet_charts")
    assert charts.false_differences(20, 20) <= 0.1
    assert charts.false_changes(20, 3.0, 20) <= 0.2
    for kind in ("step", "drift"):
        found = charts.detection(kind, 40, 6.0, 10)
        assert found.found >= 0.8
        assert found.sized >= 0.7
