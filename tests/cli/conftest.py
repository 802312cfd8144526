"""A recorded run, and parameters in the folder of a test."""

from pathlib import Path

import pytest
from axes.shipped import write_parameters
from recorded_run import recorded_run

from symid.data import Log


@pytest.fixture(scope="module")
def recorded() -> Log:
    return recorded_run()


@pytest.fixture
def parameters(folder: Path) -> None:
    """Values of the shipped axes in the folder, as AXIS.json."""
    write_parameters(folder)
