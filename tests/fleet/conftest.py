"""A folder of logs for batches."""

from pathlib import Path

import pytest
from fleet_logs import write_log


@pytest.fixture
def logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Working folder with a folder of six good logs."""
    monkeypatch.chdir(tmp_path)
    folder = Path("logs")
    folder.mkdir()
    for seed in range(6):
        write_log(folder / f"{seed}.parquet", seed)
    return folder
