"""What all tests share: the path, one thread of linear algebra, few searches for garbage, a folder, the same draws."""

import gc
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]  # the catalogue of axes, and the benchmarks, are not installed

# Matrices are small: threads would wait for each other, and take the cores from the other workers. Read by numpy.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

settings.register_profile(
    "same examples every time", derandomize=True, deadline=None, database=None, max_examples=50
)
settings.load_profile("same examples every time")


def pytest_configure() -> None:
    """Nothing that collection makes is garbage: looking for it takes a third of the time."""
    gc.disable()


def pytest_collection_finish() -> None:
    """What is collected stays: only what the tests make is looked through, and seldom."""
    gc.freeze()
    gc.enable()
    gc.set_threshold(20_000, 20, 20)


@pytest.fixture(autouse=True, scope="session")
def no_waiting_for_the_disk() -> Iterator[None]:
    """Files need not outlive a failure of the power: a test waits for the disk up to 15 ms a file."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "fsync", lambda handle: None)
        yield


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder of the test's own."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def plain_pages(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pages without their pictures, which take most of the time and say nothing to a test of the text."""
    monkeypatch.setattr("symid.report.figures.drawn.svg_of", lambda figure, name: "<svg></svg>")
    from symid.report.pages import interactive  # loads the library of its plots

    nothing: Any = dict.fromkeys(("script", "signals", "over_velocity", "over_position", "spectrum"), "")
    plots = interactive.Plots(**nothing, responses={}, others={})
    monkeypatch.setattr("symid.report.pages.interactive.plots_of", lambda found: plots)
