"""The code in README and docs runs, block after block of a page; links lead somewhere; no effect lacks its entry."""

import contextlib
import io
import re
from pathlib import Path

import pytest
from command_line import follows

from symid.diagnosis import LIBRARY

ROOT = Path(__file__).parents[1]
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").rglob("*.md")])
BLOCK = re.compile(r"```python\n(.*?)```\n(?:\n```text\n(.*?)```)?", re.DOTALL)
"""Code, and what it prints, if that stands below it."""
CATALOGUE = ROOT / "docs" / "effects" / "index.md"


def name_of(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_code_of_a_page_runs_and_prints_what_stands_below_it(
    page: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    namespace: dict[str, object] = {"__name__": "page"}
    for block, printed in BLOCK.findall(page.read_text(encoding="utf-8")):
        message = io.StringIO()
        with contextlib.redirect_stdout(message):
            exec(compile(block, page.name, "exec"), namespace)
        assert not printed or follows(message.getvalue(), printed), f"{block} prints {message.getvalue()}"


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_lead_to_files(page: Path) -> None:
    for target in re.findall(r"\]\((?!http)([^)#]+)", page.read_text(encoding="utf-8")):
        assert (page.parent / target).exists(), f"{page.name}: {target}"


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_files_that_a_page_includes_exist(page: Path) -> None:
    for included in re.findall(r'^--8<-- "([^"]+)"', page.read_text(encoding="utf-8"), re.MULTILINE):
        assert (ROOT / included).is_file()


def entries() -> dict[str, str]:
    """Sections of the catalogue by their headings."""
    _, *parts = re.split(r"^## ", CATALOGUE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return {part.partition("\n")[0]: part for part in parts}


def test_the_catalogue_holds_the_library_and_nothing_else() -> None:
    assert set(entries()) == {effect.name for effect in LIBRARY}


@pytest.mark.parametrize("effect", LIBRARY, ids=lambda effect: f"{effect.name}-{'-'.join(effect.amplitudes)}")
def test_an_entry_says_law_signature_rivals_and_remedy(effect) -> None:
    entry = entries()[effect.name]
    for heading in ("**Law.**", "**Confused with**", "**On the machine.**"):
        assert heading in entry
    assert f"]({effect.name}.png)" in entry
    free = () if effect.fixed else effect.amplitudes
    for value in (*free, *effect.shape_names):
        assert re.search(rf"\b{value}\b", entry), f"{effect.name}: {value}"
