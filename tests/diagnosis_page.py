"""Pages of diagnoses; those of the made-up ones are written once."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from diagnosis_example import diagnosis_example

from symid.diagnosis import Diagnosis
from symid.report.pages.diagnosis_page import write_diagnosis_html


def written(found: Diagnosis) -> str:
    """Text of the page of a diagnosis."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "report.html"
        write_diagnosis_html(found, file)
        return file.read_text(encoding="utf-8")


@cache
def page_of(kind: str) -> str:
    """Text of the page of the made-up diagnosis of a kind."""
    return written(diagnosis_example(kind))
