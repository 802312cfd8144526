"""Every example runs, and prints what its page says."""

import re
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
PAGES = {page.stem: page for page in (ROOT / "docs" / "how_to").glob("*.md")}


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.stem)
def test_an_example_prints_what_its_page_says(
    example: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runpy.run_path(str(example), run_name="__main__")
    page = PAGES[example.stem].read_text(encoding="utf-8")
    assert f'--8<-- "examples/{example.name}"' in page
    (printed,) = re.findall(rf"`python examples/{example.name}` prints\n\n```text\n(.*?)```", page, re.DOTALL)
    assert capsys.readouterr().out == printed
