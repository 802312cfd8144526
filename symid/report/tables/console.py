"""The console and the tables of reports."""

import io
import sys
from collections.abc import Sequence
from typing import Any

from rich.cells import cell_len
from rich.console import Console
from rich.errors import MarkupError
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from symid.text import visible

_WIDTH_OF_FILES = 160
_TAGS = ("[bold]", "[/bold]", "[italic]", "[/italic]")
"""All markup of reports; other brackets belong to names of files and columns and are printed."""


class ReportConsole(Console):
    """A console that prints brackets in names literally and control characters as escapes."""

    def render_str(self, text: str, *, markup: bool | None = None, **options: Any) -> Text:
        """Text with the markup of reports."""
        shown = visible(text)
        if markup is False:
            return super().render_str(shown, markup=False, **options)
        marked = escape(shown)
        for tag in _TAGS:
            marked = marked.replace(f"\\{tag}", tag)
        try:
            return super().render_str(marked, markup=True, **options)
        except MarkupError:  # a name holds such a tag
            return super().render_str(shown, markup=False, **options)

    def on_broken_pipe(self) -> None:
        """The reader of the output has closed it. That is not a failure; rich would exit with 1."""
        raise BrokenPipeError


def plain(text: str, style: str = "") -> Text:
    r"""Text of one style, its control characters written out.

    >>> plain("a[b]\x1b").plain
    'a[b]\\x1b'
    """
    return Text(visible(text), style=style)


class TextTable(Table):
    """Table of plain text: brackets in names of logs and signals are not markup.

    Columns whose headings are in `right` are aligned at the right. No number and no word is cut: where the terminal is
    too narrow, lines run on.
    """

    def __init__(self, title: str, *headings: str, right: Sequence[str] = ()) -> None:
        shown = plain(title) if title else None
        super().__init__(title=shown, title_justify="left", box=None, pad_edge=False)
        for heading in headings:
            self.add_column(
                heading, justify="right" if heading in right else "left", min_width=_longest_word(heading)
            )

    def add(self, *cells: str) -> None:
        """Add a row of plain text."""
        self.add_row(*map(plain, cells))
        for column, cell in zip(self.columns, cells, strict=False):
            column.min_width = max(column.min_width or 0, _longest_word(visible(cell)))


def _longest_word(text: str) -> int:
    return max(map(cell_len, text.split()), default=0)


def report_console() -> Console:
    """Console on standard output: as wide as the terminal, and 160 columns where the output goes to a file or pipe."""
    if sys.stdout is None:  # closed by the parent process
        return ReportConsole(file=io.StringIO(), width=_WIDTH_OF_FILES)
    width = None if sys.stdout.isatty() else _WIDTH_OF_FILES
    return ReportConsole(highlight=False, soft_wrap=True, width=width)
