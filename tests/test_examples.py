"""Every example runs, and prints what its page says."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
PAGES = {page.stem: page for page in (ROOT / "docs" / "how_to").glob("*.md")}


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.stem)
def test_an_example_prints_what_its_page_says(example: Path, tmp_path: Path) -> None:
    run = subprocess.run(
        [sys.executable, "-W", "error", str(example)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    page = PAGES[example.stem].read_text(encoding="utf-8")
    assert f'--8<-- "examples/{example.name}"' in page
    (said,) = re.findall(rf"`python examples/{example.name}` prints\n\n```text\n(.*?)```", page, re.DOTALL)
    assert run.stdout == said
