"""Tables on narrow terminals: text wraps between words, and no number is cut."""

import io

import pytest

from symid.report.tables.console import ReportConsole, TextTable


@pytest.mark.parametrize("width", [20, 40])
def test_no_number_is_cut(width: int) -> None:
    file = io.StringIO()
    table = TextTable("", "name", "value", "deviation", "because", right=("value", "deviation"))
    table.add("M", "362.5871234", "0.00026123", "it is written so")
    ReportConsole(file=file, width=width, soft_wrap=True).print(table)
    printed = file.getvalue()
    assert "…" not in printed
    assert {"M", "362.5871234", "0.00026123", "written", "deviation"} <= set(printed.split())
    assert "it is written so" not in printed
