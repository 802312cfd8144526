"""The notebook of docs/ runs in a kernel, and shows what stands in it."""

import re
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOK = Path(__file__).parents[1] / "docs" / "how_to" / "notebook.ipynb"
NUMBER = re.compile(r"\d+(\.\d+)?(e[-+]\d+)?")
VALUE = re.compile(r"= (\d+(?:\.\d+)?)")


def shown(cell: nbformat.NotebookNode) -> list[tuple[str, tuple[str, ...], str]]:
    """Kind, formats and text of each output of a cell, without numbers and the width of their columns."""
    return [
        (
            one.output_type,
            tuple(sorted(one.get("data", {}))),
            re.sub(" +", " ", NUMBER.sub("#", one.get("data", {}).get("text/plain", ""))),
        )
        for one in cell.get("outputs", [])
    ]


def values(cell: nbformat.NotebookNode) -> list[float]:
    """Identified values that a cell shows, such as M = 120.4."""
    texts = [one.get("data", {}).get("text/plain", "") for one in cell.get("outputs", [])]
    return [float(value) for text in texts for value in VALUE.findall(text)]


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")
def test_the_notebook_shows_what_stands_in_it(tmp_path: Path) -> None:
    written, run = (nbformat.read(NOTEBOOK, as_version=4) for _ in range(2))
    NotebookClient(run, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    nbformat.write(run, tmp_path / NOTEBOOK.name)
    for before, after in zip(written.cells, run.cells, strict=True):
        assert values(after) == pytest.approx(values(before), rel=1e-2), "execute the notebook anew"
        assert shown(after) == shown(before), f"compare {tmp_path / NOTEBOOK.name}:\n{after.source}"
    assert (tmp_path / "fit.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    kinds = [kind for cell in written.cells for _, kinds, _ in shown(cell) for kind in kinds]
    assert kinds.count("image/png") == 2
    assert kinds.count("text/html") >= 4
